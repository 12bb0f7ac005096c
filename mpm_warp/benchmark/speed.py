"""The speed of a run, in samples, and what is measured in alternation with them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.benchmark.bare_step import BareStep
from mpm_warp.benchmark.clocks import ClockedExecution, StageClock, StepTimes
from mpm_warp.execution.worker_threads import worker_threads
from mpm_warp.results import variable
from mpm_warp.simulation import Simulation

LEAST_STEPS = 16
"""Least number of steps of a sample."""
WARM_FRACTION = 0.5
"""Fraction of the time of a sample for which steps are taken before the first sample."""
CLOCKED_STEPS = 16
"""Steps after each sample whose stages are clocked."""
BARE_TIME = 0.1
"""Time for which bare steps are taken after each sample [s]."""


@dataclass(frozen=True)
class Sample:
    """Steps that were taken and timed together.

    Attributes:
        steps: number of steps.
        updates: number of particle updates.
        seconds: wall-clock time [s].
    """

    steps: int
    updates: int
    seconds: float

    @property
    def rate(self) -> float:
        """Particle updates per second."""
        return self.updates / self.seconds


@dataclass(frozen=True)
class Run:
    """A run whose speed is measured.

    Attributes:
        simulation: the run.
        take: takes about so many of its steps.
    """

    simulation: Simulation
    take: Callable[[int], None]

    def sample(self, step_count: int) -> Sample:
        """Take about `step_count` steps and time them."""
        simulation = self.simulation
        steps, updates = simulation.step_count, simulation.particle_updates
        start = time.perf_counter()
        self.take(step_count)
        simulation.array("particle.mass")  # waits for a GPU
        return Sample(
            steps=simulation.step_count - steps,
            updates=simulation.particle_updates - updates,
            seconds=time.perf_counter() - start,
        )

    def steps_within(self, seconds: float) -> int:
        """Number of steps that take about so long [s]; the run is warm after it is found out."""
        count = LEAST_STEPS
        # The first steps load kernels and record launches: only many tell how long one takes.
        while (taken := self.sample(count)).seconds < WARM_FRACTION * seconds:
            count *= 2
        return max(LEAST_STEPS, math.ceil(taken.steps * seconds / taken.seconds))


class Companion:
    """What is measured after each sample of a run; this one measures nothing.

    The speed of a machine changes from second to second. So two speeds are compared only where they
    are measured one right after the other.
    """

    def before_sample(self) -> None:
        """Prepare for a sample."""

    def after_sample(self, sample: Sample) -> None:
        """Take a sample into account, and measure right after it."""

    def dataset(self) -> xr.Dataset:
        """What was measured."""
        return xr.Dataset()


class ThreadGain(Companion):
    """How much faster several threads are than one, and how much faster they could be.

    After each sample the same run is sampled on one thread, and then as many such runs at once as
    there are threads: what the cores give to runs that have nothing to do with each other.

    Args:
        runs: runs like the one that is sampled, each on one thread, as many as it has threads.
    """

    def __init__(self, runs: Sequence[Run]) -> None:
        self._runs = runs
        self._thread_gains: list[float] = []
        self._core_gains: list[float] = []

    def after_sample(self, sample: Sample) -> None:
        """Sample one run on one thread alone, then all of them at once."""
        alone = self._runs[0].sample(sample.steps).rate
        samples: list[Sample] = []
        threads = worker_threads(len(self._runs))
        threads.run(lambda k: samples.append(self._runs[k].sample(sample.steps)), lambda _: None)
        self._thread_gains.append(sample.rate / alone)
        self._core_gains.append(sum(it.rate for it in samples) / alone)

    def dataset(self) -> xr.Dataset:
        """The gain by the threads, and that of as many runs at once."""
        return xr.Dataset(
            {
                "thread_gain": variable(
                    float(np.median(self._thread_gains)),
                    unit="1",
                    meaning="times as fast as on one thread",
                    description="each sample beside one of one thread right after it; median",
                ),
                "core_gain": variable(
                    float(np.median(self._core_gains)),
                    unit="1",
                    meaning="times as fast as one thread, as many runs at once",
                    description="as many runs at once, each on one thread, beside one of them "
                    "alone right before; median",
                ),
            }
        )


class StageTimes(Companion):
    """Where the time of a run on one thread goes, and how fast it is beside bare steps.

    Args:
        simulation: the run.
        execution: the execution of the run.
    """

    def __init__(self, simulation: Simulation, execution: ClockedExecution) -> None:
        self._particle_count = simulation.particle_count
        self._step_clock = execution
        self._stage_clock = StageClock(simulation)
        self._bare_step = BareStep(simulation.particle_count)
        self._times: list[StepTimes] = []
        self._overheads: list[float] = []
        self._bare_gains: list[float] = []

    def before_sample(self) -> None:
        """Start the clock at the begin and the end of steps."""
        self._step_clock.start()

    def after_sample(self, sample: Sample) -> None:
        """Read that clock, clock the stages of some steps, and take bare steps."""
        python = 1.0 - self._step_clock.share_of_steps
        times = self._stage_clock.time_steps(CLOCKED_STEPS)
        self._times.append(times)
        self._overheads.append(python + times.launching * sample.steps / sample.seconds)
        self._bare_gains.append(sample.rate / self._bare_step.rate(BARE_TIME))

    def dataset(self) -> xr.Dataset:
        """The time of each stage, the time outside the stages, and the gain over bare steps."""
        stages = list(self._times[0].stages)
        seconds = np.median([list(times.stages.values()) for times in self._times], axis=0)
        return xr.Dataset(
            {
                "stage_time": variable(
                    1e9 * seconds / self._particle_count,
                    unit="ns",
                    meaning="time of a stage per material point",
                    dims=("stage",),
                ),
                "overhead_share": variable(
                    float(np.median(self._overheads)),
                    unit="1",
                    meaning="share of the time that Python and the launches take",
                    description="Python: all that is not within the steps, such as the watch, "
                    "history and soil that enters; launches: those of a step, each as one that "
                    "does nothing; median",
                ),
                "bare_step_gain": variable(
                    float(np.median(self._bare_gains)),
                    unit="1",
                    meaning="times as fast as a bare step",
                    description="each sample beside bare steps right after it, of "
                    "`mpm_warp.benchmark.bare_step`; median",
                ),
            },
            coords={"stage": stages},
        )
