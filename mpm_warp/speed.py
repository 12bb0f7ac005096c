"""The speed of a run: samples of it, and what each stage of a step takes and has to do."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.counting import stage_work
from mpm_warp.history import variable
from mpm_warp.simulation import Simulation
from mpm_warp.timing import ClockedExecution, StageClock, StepTimes, yardsticks

LEAST_STEPS = 16
"""Steps of a sample, at least."""
WARM_SHARE = 0.5
"""Of the time of a sample, for which steps are taken before any."""
CLOCKED_STEPS = 16
"""Steps after each sample whose stages are clocked."""


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


def sample(simulation: Simulation, take: Callable[[int], None], count: int) -> Sample:
    """Take about `count` steps, by a function that takes them."""
    steps, updates = simulation.step_count, simulation.particle_updates
    start = time.perf_counter()
    take(count)
    simulation.array("particle.mass")  # waits for a GPU
    return Sample(
        steps=simulation.step_count - steps,
        updates=simulation.particle_updates - updates,
        seconds=time.perf_counter() - start,
    )


def steps_within(seconds: float, simulation: Simulation, take: Callable[[int], None]) -> int:
    """How many steps take so long [s], about, told by taking some; all is warm after them."""
    count = LEAST_STEPS
    # The first steps load kernels and record launches: only many tell how long one takes.
    while (taken := sample(simulation, take, count)).seconds < WARM_SHARE * seconds:
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
    """The same run on one thread, to tell how much faster several are.

    The state of a machine changes from second to second: speeds are of the same moment only where
    they are measured one right after the other.

    Args:
        simulation: a run like the one that is sampled, on one thread.
        take: takes its steps.
    """

    def __init__(self, simulation: Simulation, take: Callable[[int], None]) -> None:
        self._simulation = simulation
        self._take = take
        self._ratios: list[float] = []

    def note(self, taken: Sample) -> None:
        """See `Beside`."""
        alone = sample(self._simulation, self._take, taken.steps)
        self._ratios.append((alone.seconds / alone.steps) / (taken.seconds / taken.steps))

    def table(self) -> xr.Dataset:
        """How many times faster the threads are, each sample over the next of one thread."""
        return xr.Dataset(
            {
                "thread_gain": variable(
                    float(np.median(self._ratios)),
                    unit="1",
                    meaning="times as fast as on one thread",
                    description="each sample beside one of one thread right after it; median",
                )
            }
        )


class Clocks(Beside):
    """Clocks of a run on one thread of the processor: between its steps, and between its stages.

    Args:
        simulation: the run.
        execution: of the run.
    """

    def __init__(self, simulation: Simulation, execution: ClockedExecution) -> None:
        self._simulation = simulation
        self._steps = execution
        self._stages = StageClock(simulation)
        self._times: list[StepTimes] = []
        self._overheads: list[float] = []

    def begin(self) -> None:
        """Start the one between the steps."""
        self._steps.start()

    def note(self, taken: Sample) -> None:
        """Take down what that one tells, and the times of stages."""
        python = 1.0 - self._steps.share_of_steps
        times = self._stages.time_steps(CLOCKED_STEPS)
        self._times.append(times)
        self._overheads.append(python + times.launching * taken.steps / taken.seconds)

    def table(self) -> xr.Dataset:
        """Time and work of each stage, what bare loops reach, and what is outside the stages."""
        overhead = variable(
            float(np.median(self._overheads)),
            unit="1",
            meaning="share of the time that Python and the launches take",
            description="Python: all that is not within the steps, such as the watch, history and "
            "soil that enters; launches: those of a step, each as one that does nothing; median",
        )
        return _stage_table(self._simulation, self._times).assign(overhead_share=overhead)


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
