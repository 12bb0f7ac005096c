"""The error of each case of a result, against which its run time is to be held."""

from __future__ import annotations

import numpy as np
import xarray as xr

from mpm_warp.parameters import parameters_of
from mpm_warp.scenes import scene_class, scene_names

EXACT = "error"
"""Error against the exact solution: a result of scenes that have one."""
FINEST = "error_finest"
"""Difference from the costliest case of the study that differs in the method alone."""


def error_name(dataset: xr.Dataset) -> str | None:
    """The error that a result holds, the exact one first; None where it holds neither."""
    return next((name for name in (EXACT, FINEST) if name in dataset), None)


def with_errors(dataset: xr.Dataset) -> xr.Dataset:
    """Add the error of each case against the costliest one, where no exact error is known.

    Cases are alike that differ only in parameters of the method, which the scene names. The
    costliest of them, by particle updates, is the reference, and has itself no error.
    """
    name = dataset.attrs.get("scene")
    if EXACT in dataset or name not in scene_names():
        return dataset
    scene = scene_class(name)
    if not scene.method or scene.headline not in dataset or "particle_updates" not in dataset:
        return dataset
    result = dataset[scene.headline]
    values = result.values.ravel()
    cost = dataset["particle_updates"].broadcast_like(result).values.ravel()
    error = np.full(values.shape, np.nan)
    for cases in _alike(
        dataset, result, [p for p in parameters_of(scene) if p not in scene.method]
    ):
        sound = cases[np.isfinite(values[cases])]
        if len(sound) < 2:
            continue
        finest = sound[np.argmax(cost[sound])]
        others = sound[sound != finest]
        error[others] = np.abs(values[others] / values[finest] - 1.0)
    if not np.isfinite(error).any():
        return dataset
    labels = {
        "units": "1",
        "long_name": f"error of the {scene.headline.replace('_', ' ')}",
        "description": "relative difference from the case with most particle updates among those "
        "that differ in the method alone; that one has none",
    }
    return dataset.assign({FINEST: (result.dims, error.reshape(result.shape), labels)})


def _alike(dataset: xr.Dataset, result: xr.DataArray, names: list[str]) -> list[np.ndarray]:
    """Indices of the cases that agree in the parameters `names`, group by group."""
    stored = (name if name in dataset else f"{name}_parameter" for name in names)
    columns = [
        dataset[name].broadcast_like(result).values.ravel().tolist()
        for name in stored
        if name in dataset
    ]
    groups: dict[str, list[int]] = {}
    for case, values in enumerate(zip(*columns, strict=True)):
        groups.setdefault(repr(values), []).append(case)
    return [np.array(group) for group in groups.values()]
