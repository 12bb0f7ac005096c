"""What a run leaves behind, as a dataset: curves, scalars, and what they cost."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike


def variable(
    value: ArrayLike,
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
