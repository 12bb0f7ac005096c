"""The speed of a run: samples of it, and what each stage of a step takes and has to do."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.benchmark.bare_step import BareStep
from mpm_warp.benchmark.counting import stage_work
from mpm_warp.results import variable
from mpm_warp.simulation import Simulation
from mpm_warp.execution.team import team_of
from mpm_warp.benchmark.clocks import ClockedExecution, StageClock, StepTimes, yardsticks

LEAST_STEPS = 16
"""Steps of a sample, at least."""
WARM_SHARE = 0.5
"""Of the time of a sample, for which steps are taken before any."""
CLOCKED_STEPS = 16
"""Steps after each sample whose stages are clocked."""
BARE_TIME = 0.1
"""Time for which bare steps are taken after each sample [s]."""


@dataclass(frozen=True)
class Sample:
    """Steps that were taken together.

    Attributes:
        steps: their number.
        updates: particle updates.
        seconds: wall-clock time [s].
    """

    steps: int
    updates: int
    seconds: float

    @property
    def rate(self) -> float:
        """Updates per second."""
        return self.updates / self.seconds


@dataclass(frozen=True)
class Run:
    """A run that is measured.

    Attributes:
        simulation: the run.
        take: takes so many of its steps, about.
    """

    simulation: Simulation
    take: Callable[[int], None]

    def sample(self, count: int) -> Sample:
        """Take about `count` steps."""
        simulation = self.simulation
        steps, updates = simulation.step_count, simulation.particle_updates
        start = time.perf_counter()
        self.take(count)
        simulation.array("particle.mass")  # waits for a GPU
        return Sample(
            steps=simulation.step_count - steps,
            updates=simulation.particle_updates - updates,
            seconds=time.perf_counter() - start,
        )

    def steps_within(self, seconds: float) -> int:
        """How many steps take so long [s], about, told by taking some; all is warm after them."""
        count = LEAST_STEPS
        # The first steps load kernels and record launches: only many tell how long one takes.
        while (taken := self.sample(count)).seconds < WARM_SHARE * seconds:
            count *= 2
        return max(LEAST_STEPS, math.ceil(taken.steps * seconds / taken.seconds))


class Beside:
    """What else is measured, turn about with the samples: nothing."""

    def begin(self) -> None:
        """Go before a sample."""

    def note(self, taken: Sample) -> None:
        """Take down a sample that has been begun, and measure something after it."""

    def table(self) -> xr.Dataset:
        """What came out."""
        return xr.Dataset()


class OneThread(Beside):
    """The same run on one thread, and as many such runs at once as there are threads.

    They tell how much faster the threads are, and how much faster they could be: what the cores
    give to runs that have nothing to do with each other. The state of a machine changes from second
    to second: speeds are of the same moment only where they are measured one right after the other.

    Args:
        runs: like the one that is sampled, each on one thread.
    """

    def __init__(self, runs: Sequence[Run]) -> None:
        self._runs = runs
        self._thread_gains: list[float] = []
        self._core_gains: list[float] = []

    def note(self, taken: Sample) -> None:
        """See `Beside`."""
        alone = self._runs[0].sample(taken.steps).rate
        at_once = sum(it.rate for it in self._at_once(taken.steps))
        self._thread_gains.append(taken.rate / alone)
        self._core_gains.append(at_once / alone)

    def _at_once(self, count: int) -> list[Sample]:
        samples: list[Sample] = []
        team = team_of(len(self._runs))
        team.run(lambda number: samples.append(self._runs[number].sample(count)), lambda _: None)
        return samples

    def table(self) -> xr.Dataset:
        """How many times faster the threads are, and the cores, against one thread."""
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


class Clocks(Beside):
    """Clocks of a run on one thread of the processor: between its steps, and between its stages.

    Bare steps of as many material points, about, are measured too.

    Args:
        simulation: the run.
        execution: of the run.
    """

    def __init__(self, simulation: Simulation, execution: ClockedExecution) -> None:
        self._simulation = simulation
        self._steps = execution
        self._stages = StageClock(simulation)
        self._bare = BareStep(simulation.particle_count)
        self._times: list[StepTimes] = []
        self._overheads: list[float] = []
        self._bare_gains: list[float] = []

    def begin(self) -> None:
        """Start the one between the steps."""
        self._steps.start()

    def note(self, taken: Sample) -> None:
        """Take down what that one tells, and the times of stages."""
        python = 1.0 - self._steps.share_of_steps
        times = self._stages.time_steps(CLOCKED_STEPS)
        self._times.append(times)
        self._overheads.append(python + times.launching * taken.steps / taken.seconds)
        self._bare_gains.append(taken.rate / self._bare.rate(BARE_TIME))

    def table(self) -> xr.Dataset:
        """Time and work of each stage, what bare loops reach, and what is outside the stages."""
        overhead = variable(
            float(np.median(self._overheads)),
            unit="1",
            meaning="share of the time that Python and the launches take",
            description="Python: all that is not within the steps, such as the watch, history and "
            "soil that enters; launches: those of a step, each as one that does nothing; median",
        )
        bare = variable(
            float(np.median(self._bare_gains)),
            unit="1",
            meaning="times as fast as a bare step",
            description="each sample beside bare steps right after it, of `mpm_warp.benchmark.bare_step`; "
            "median",
        )
        stages = _stage_table(self._simulation, self._times)
        return stages.assign(overhead_share=overhead, bare_step_gain=bare)


def _stage_table(simulation: Simulation, times: Sequence[StepTimes]) -> xr.Dataset:
    work, machine = stage_work(simulation), yardsticks()
    count = simulation.particle_count
    spent = {name: float(np.median([it.stages[name] for it in times])) for name in work}

    def by_stage(values: Iterable[float], unit: str, meaning: str) -> xr.Variable:
        per_point = np.array(list(values)) / count
        return variable(
            per_point, unit=unit, meaning=f"{meaning} per material point", dims=("stage",)
        )

    return xr.Dataset(
        {
            "stage_time": by_stage((1e9 * it for it in spent.values()), "ns", "time of a stage"),
            "stage_bytes": by_stage(
                (it.traffic for it in work.values()), "byte", "bytes that a stage reads and writes"
            ),
            "stage_operations": by_stage(
                (it.operations for it in work.values()), "1", "floating point operations of a stage"
            ),
            "stage_divisions": by_stage(
                (it.divisions for it in work.values()), "1", "divisions and roots of a stage"
            ),
            "streaming_rate": variable(
                machine.streaming, unit="byte s-1", meaning="memory traffic of a bare loop"
            ),
            "arithmetic_rate": variable(
                machine.arithmetic, unit="s-1", meaning="operations per second of a bare loop"
            ),
            "division_rate": variable(
                machine.division, unit="s-1", meaning="divisions per second of a bare loop"
            ),
        },
        coords={"stage": list(work)},
    )
