"""The error of each case against the best known one, where no exact solution is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    Role,
    over_cases,
    parameter_names,
    spoken,
    uncertainty_of,
    with_role,
)
from harness.study.compared import ERROR, ERROR_FINEST

FLOOR = "error_floor"
"""What an error against a reference of a stated uncertainty cannot be told from nothing by."""


def error_name(dataset: xr.Dataset) -> str | None:
    """The error that a result holds, the exact one first; None where it holds neither."""
    return next((name for name in (ERROR, ERROR_FINEST) if name in dataset), None)


def with_finest_error(dataset: xr.Dataset, method: Sequence[str]) -> xr.Dataset:
    """Add the error of each case against the best known one, where no exact error is known.

    Cases are alike that differ only in parameters of the method. The reference is the one among
    them with the smallest stated uncertainty, or where none states any the costliest, by particle
    updates; it has itself no error. Its relative uncertainty is the floor, below which no error
    says anything. A case whose headline has not settled has no error and is no reference.

    Args:
        dataset: the result of a study of one scene.
        method: the parameters of the method, which the scene names.
    """
    headlines = with_role(dataset, Role.HEADLINE)
    if ERROR in dataset or not (method and headlines and "particle_updates" in dataset):
        return dataset
    values, cost = over_cases(dataset, headlines[0]), over_cases(dataset, "particle_updates")
    half_width = uncertainty_of(dataset)
    settled = over_cases(dataset, next(iter(with_role(dataset, Role.SETTLED)), 1.0)) != 0.0
    error, floor = np.full(values.shape, np.nan), np.full(values.shape, np.nan)
    for cases in _alike(dataset, method):
        sound = cases[np.isfinite(values[cases]) & settled[cases]]
        if len(sound) < 2:
            continue
        known = sound[np.isfinite(half_width[sound])]
        if len(known):
            reference = known[np.argmin(half_width[known])]
        else:
            reference = sound[np.argmax(cost[sound])]
        others = sound[sound != reference]
        error[others] = np.abs(values[others] / values[reference] - 1.0)
        floor[others] = half_width[reference] / values[reference]
    if not np.isfinite(error).any():
        return dataset
    labels = {
        "units": "1",
        "long_name": f"error of the {spoken(headlines[0])}",
        "description": "relative difference from the case that is known best, or else the one with "
        "most particle updates, among those that differ in the method alone; that one has none",
        "role": Role.ERROR,
    }
    status = dataset["status"]
    added = {ERROR_FINEST: (status.dims, error.reshape(status.shape), labels)}
    if np.isfinite(floor).any():
        of_reference = {
            "units": "1",
            "long_name": "relative uncertainty of the reference of the error",
            "description": "below it an error says nothing",
        }
        added[FLOOR] = (status.dims, floor.reshape(status.shape), of_reference)
    return dataset.assign(added)


def _alike(dataset: xr.Dataset, method: Sequence[str]) -> list[np.ndarray]:
    """Indices of the cases that agree in all parameters but those of the method, by group."""
    columns = [
        over_cases(dataset, stored).tolist()
        for name, stored in parameter_names(dataset).items()
        if name not in method
    ]
    groups: dict[str, list[int]] = {}
    for case, values in enumerate(zip(*columns, strict=True)):
        groups.setdefault(repr(values), []).append(case)
    return [np.array(group) for group in groups.values()]
