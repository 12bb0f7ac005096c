"""Whether a result is built as every result is, so that what reads it by name finds what it needs.

A digest says that a file is as it was written. It does not say who wrote it: these checks are for
files of other programs, and for those from before there were digests.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from harness.archive.conventions import PER_CASE, Role, parameter_names
from harness.archive.provenance import OF_CASE
from mpm_warp.parameters import parameters_of
from mpm_warp.scenes import scene_class, scene_names

_OF_EACH_CASE = (
    *(Role.HEADLINE, Role.UNCERTAINTY, Role.SETTLED),
    *(Role.ERROR, Role.PARAMETER, Role.DEVIATION),
)
"""Roles of variables that have one value a case."""
_TEXTS = ("units", "long_name", "description")


def malformed(dataset: xr.Dataset) -> str | None:
    """The first thing in a result that is not as it has to be, in words; None where all is well.

    Args:
        dataset: of a case, or of a study with its `status`.
    """
    return next(_faults(dataset), None)


def _faults(dataset: xr.Dataset) -> Iterator[str]:
    over = dataset["status"].dims if "status" in dataset.variables else ()
    if not all(dataset.sizes[dim] for dim in over):
        yield "there is no case"
    for dim in over:
        if dim in dataset.indexes and not dataset.indexes[dim].is_unique:
            yield f"{dim} has a value twice"
    texts = {*PER_CASE, *OF_CASE, "scene", *_text_parameters(dataset)}
    is_known = all(scene in scene_names() for scene in _scenes(dataset))
    for name, variable in dataset.variables.items():
        is_text = all(isinstance(value, str) for value in variable.values.flat)
        if str(name) in texts:
            if not is_text:
                yield f"{name} is no text"
        # Which parameters of an unknown scene are texts is not known either.
        elif variable.dtype.kind not in "biuf" and not (
            is_text and not (is_known and "units" in variable.attrs)
        ):
            yield f"{name} is no number"
        of_cases = tuple(dim for dim in variable.dims if dim in over)
        if of_cases != tuple(dim for dim in over if dim in of_cases):
            yield f"{name} has its dims in another order"
        own = [dim for dim in variable.dims if dim not in over]
        if any(dim not in dataset.coords for dim in own):
            yield f"{name} has a dim without a coordinate"
        role = variable.attrs.get("role")
        if role is not None and role not in list(Role):
            yield f"the role of {name} is unknown"
        if own and role in _OF_EACH_CASE and name not in dataset.dims:
            yield f"{name} has more than one value a case"
        yield from _faulty_attributes(dataset, str(name), variable)


def _faulty_attributes(dataset: xr.Dataset, name: str, variable: xr.Variable) -> Iterator[str]:
    said = variable.attrs
    for key in _TEXTS:
        if not isinstance(said.get(key, ""), str):
            yield f"{key} of {name} is no text"
    limit = said.get("limit", 0.0)
    if not isinstance(limit, int | float | np.number) or not math.isfinite(limit):
        yield f"limit of {name} is no number"
    if said.get("role") == Role.EXACT and said.get("exact_of") not in dataset.variables:
        yield f"{name} is exact of nothing"


def _text_parameters(dataset: xr.Dataset) -> Iterator[str]:
    """What the parameters that are texts are called in a result."""
    stored = parameter_names(dataset)
    for scene in _scenes(dataset):
        if scene in scene_names():
            for name, definition in parameters_of(scene_class(scene)).items():
                if definition.kind is str:
                    yield stored.get(name, name)


def _scenes(dataset: xr.Dataset) -> list[str]:
    return str(dataset.attrs.get("scene", "")).split()
