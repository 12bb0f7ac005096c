"""Tolerances of a study: kept in its result, and which of them the result misses."""

from __future__ import annotations

import json
from collections.abc import Mapping

import xarray as xr

from harness.archive.conventions import (
    COMPLETED,
    TOLERANCES,
    Role,
    case_dims,
    labels_of,
    over_cases,
)
from harness.compare.cone_factors import conditions_of
from harness.references.cone_factors import cone_factor_reference
from mpm_warp.parameters import did_you_mean


def with_tolerances(dataset: xr.Dataset, tolerances: Mapping[str, float]) -> xr.Dataset:
    """The dataset with its study's tolerances, so that its file alone can be checked."""
    return dataset.assign_attrs({TOLERANCES: json.dumps(dict(tolerances))} if tolerances else {})


def has_tolerances(dataset: xr.Dataset) -> bool:
    """Whether a result has tolerances of its study."""
    return TOLERANCES in dataset.attrs


def misses(dataset: xr.Dataset) -> list[str]:
    """What the tolerances that are stored in `dataset` do not allow, a line each.

    The tolerance of a reference bounds the size of the deviation from it, in the cases that it
    applies to; that of a result bounds its size. What is not a number, or nowhere to be found, is
    missed too: a check that was not made is not passed.
    """
    tolerances: dict[str, float] = json.loads(dataset.attrs.get(TOLERANCES, "{}"))
    return [line for name, limit in tolerances.items() for line in _misses_of(dataset, name, limit)]


def _misses_of(dataset: xr.Dataset, name: str, limit: float) -> list[str]:
    if (deviation := f"{Role.DEVIATION}_{name}") in dataset:
        value = dataset[deviation]
        applies = xr.DataArray(cone_factor_reference(name).applies(conditions_of(dataset)))
    elif name in dataset and dataset[name].dtype.kind in "iuf":
        value, applies = dataset[name], xr.DataArray(True)
    else:
        known = [str(it) for it in dataset.data_vars if dataset[it].dtype.kind in "iuf"]
        return [f"{name}: is neither a reference nor a result here{did_you_mean(name, known)}"]
    size = abs(value).max([dim for dim in value.dims if dim not in case_dims(dataset)])
    size = size.where(dataset["status"] == COMPLETED)  # a curve may be there that was cut short
    held = over_cases(dataset, applies)
    if not held.any():
        return [f"{name}: applies to no case"]
    return [
        f"{name}: {label}: {size:.3g} is beyond the tolerance {limit:g}"
        for label, size, is_held in zip(
            labels_of(dataset), over_cases(dataset, size), held, strict=True
        )
        if is_held and not size <= limit
    ]
