"""What a run leaves behind, as a dataset: curves, scalars, and what they cost."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.watch.health import SimulationDiverged
from mpm_warp.simulation import TimeLoop


def variable(
    value: float | Floats,
    *,
    unit: str,
    meaning: str,
    description: str | None = None,
    dims: tuple[str, ...] = (),
    role: str | None = None,
    exact_of: str | None = None,
) -> xr.Variable:
    """A labelled variable.

    Args:
        value: number, or numbers over `dims`.
        unit: SI unit, "1" for a dimensionless number.
        meaning: a few words, fit for the axis of a picture.
        description: how the value came about, where that needs saying.
        dims: names of the dimensions.
        role: of the variable.
        exact_of: the variable that it is the exact value of.
    """
    labels = {"units": unit, "long_name": meaning}
    if description is not None:
        labels["description"] = description
    if exact_of is not None:
        role, labels["exact_of"] = "exact", exact_of
    if role is not None:
        labels["role"] = role
    return xr.Variable(dims, np.asarray(value), labels)


@contextmanager
def curves_kept(curves: Callable[[], xr.Dataset]) -> Iterator[None]:
    """Let a run that diverges in the block keep its curves up to there.

    Args:
        curves: gives them; a run may have none as yet.

    Raises:
        SimulationDiverged: from the block, with its `history`.
    """
    try:
        yield
    except SimulationDiverged as error:
        error.history = curves()
        raise


COSTS = {
    "run_time": ("s", "wall-clock time of the time loop"),
    "setup_time": ("s", "wall-clock time to set up"),
    "compile_time": ("s", "wall-clock time to compile or load kernels"),
    "time_step": ("s", "time step, the last one"),
    "step_count": ("1", "time steps"),
    "particle_count": ("1", "material points at the start"),
    "particle_updates": ("1", "material points times steps"),
}
"""Unit and meaning of what tells the time and work of a run."""


def costs(**values: float) -> Mapping[str, xr.Variable]:
    """Time and work of a run, by the names of `COSTS`, as variables of its dataset."""
    return {
        name: variable(value, unit=COSTS[name][0], meaning=COSTS[name][1])
        for name, value in values.items()
    }


def cost(simulation: TimeLoop, *, run_time: float) -> Mapping[str, xr.Variable]:
    """Time and work of a simulation, whose steps took `run_time` seconds."""
    return costs(
        run_time=run_time,
        setup_time=simulation.setup_time,
        compile_time=simulation.compile_time,
        time_step=simulation.plan.time_step,
        step_count=simulation.step_count,
        particle_count=simulation.plan.particle_count,
        particle_updates=simulation.particle_updates,
    )
