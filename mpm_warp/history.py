"""What a run leaves behind, as a dataset: curves, scalars, and what they cost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from mpm_warp.grids import Floats
from mpm_warp.simulation import TimeLoop


def variable(
    value: float | Floats,
    *,
    unit: str,
    meaning: str,
    description: str | None = None,
    dims: tuple[str, ...] = (),
) -> xr.Variable:
    """A labelled variable.

    Args:
        value: number, or numbers over `dims`.
        unit: SI unit, "1" for a dimensionless number.
        meaning: a few words, fit for the axis of a picture.
        description: how the value came about, where that needs saying.
        dims: names of the dimensions.
    """
    labels = {"units": unit, "long_name": meaning}
    if description is not None:
        labels["description"] = description
    return xr.Variable(dims, np.asarray(value), labels)


def cost(simulation: TimeLoop, *, run_time: float) -> Mapping[str, xr.Variable]:
    """Time and work of a run, whose steps took `run_time` seconds, as variables of its dataset."""
    scalars = {
        "run_time": (run_time, "s", "wall-clock time of the time loop"),
        "setup_time": (simulation.setup_time, "s", "wall-clock time to set up"),
        "compile_time": (
            simulation.compile_time,
            "s",
            "wall-clock time to compile or load kernels",
        ),
        "time_step": (simulation.plan.time_step, "s", "time step"),
        "step_count": (simulation.step_count, "1", "time steps"),
        "particle_count": (simulation.plan.particle_count, "1", "material points at the start"),
        "particle_updates": (simulation.particle_updates, "1", "material points times steps"),
    }
    return {
        name: variable(value, unit=unit, meaning=meaning)
        for name, (value, unit, meaning) in scalars.items()
    }
