"""The speed of a run: samples of it, and what each stage of a step takes and has to do."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.counting import stage_work
from mpm_warp.history import variable
from mpm_warp.simulation import Simulation
from mpm_warp.timing import ClockedExecution, StageClock, StepTimes, yardsticks

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


class Clocks:
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

    def start(self) -> None:
        """Start the one between the steps."""
        self._steps.start()

    def note(self, taken: Sample) -> None:
        """Take down a sample, at whose begin the clock was started; and the times of stages."""
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
