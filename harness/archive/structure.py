"""Check that a file has the structure of a result, so that other code can rely on its variables.

The checks are for files of other programs, because a digest proves only that a file is unchanged.
They read only the values of dims and headlines, so that `status` is fast.
"""

import json
import math
import re
from collections.abc import Hashable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    CHANGED,
    COMPLETED,
    DRAWS,
    PER_CASE,
    TOLERANCES,
    Role,
    parameter_of,
)
from harness.archive.provenance import OF_CASE
from harness.study.compared import ERROR
from harness.study.files import STUDY_NAME
from harness.study.scene_part import LARGEST_STUDY
from mpm_warp.fields import parameters_of
from mpm_warp.scenes import scene_class, scene_names

Forms = Mapping[str, xr.Variable]


class Stored(NamedTuple):
    """The attributes and variables of a file; values of variables are read on demand."""

    attributes: Mapping[str, Any]
    variables: Forms


NUMBERS, TEXT = "biuf", "O"
"""NumPy's letters for kinds of variables."""
_OF_EACH_CASE = (
    *(Role.HEADLINE, Role.UNCERTAINTY, Role.SETTLED),
    *(Role.ERROR, Role.PARAMETER, Role.DEVIATION),
)
"""Roles of variables that have one value per case."""
_BY_NAME = "run_time", "run_time_sample", "case_time", "particle_updates", "peak_memory", ERROR
"""Numbers that the harness reads by name; see `harness.archive.conventions`."""
_ROLES = frozenset(Role)
_TEXTS = ("units", "long_name", "description", "coordinates", "dtype")
_ENCODED = ("scale_factor", "add_offset", "missing_value", "_Unsigned")
"""Attributes of packed numbers, which results never have."""


def malformed(result: Stored) -> str | None:
    """The first fault in the structure of a result, of a case or a study; None if it has none."""
    return next(_faults(result), None)


def _faults(result: Stored) -> Iterator[str]:
    for key, value in result.attributes.items():
        if not isinstance(value, str | int | float | np.number):
            yield f"{key} is neither a text nor a number"
    forms = result.variables
    over = forms["status"].dims if "status" in forms else ()
    if "study" in result.attributes:
        yield from _faulty_study(result, over)
    if "status" in forms and 0 in forms["status"].shape:
        yield "there is no case"
    scenes = str(result.attributes.get("scene", "")).split()
    texts = {*PER_CASE, CHANGED, *OF_CASE, "scene", *_text_parameters(forms, scenes)}
    is_known = all(scene in scene_names() for scene in scenes)
    for name, form in forms.items():
        if name in texts or _role(form) in (Role.REASON, Role.BUILT):
            if form.dtype.kind != TEXT:
                yield f"{name} is not a text"
        # Which parameters are texts is known only if the scene is known.
        elif form.dtype.kind not in NUMBERS and (
            form.dtype.kind != TEXT or name in _BY_NAME or (is_known and "units" in form.attrs)
        ):
            yield f"{name} is not a number"
        yield from _faulty_attributes(forms, name)
        yield from _faulty_dims(forms, name, over)
    for dim in sorted({str(dim) for form in forms.values() for dim in form.dims} & forms.keys()):
        values = forms[dim].values
        if values.ndim == 0:
            yield f"{dim} is a dim but has a single value"
        elif np.unique(values).size < values.size:
            yield f"{dim} has a repeated value"
    if result.attributes.get("status") == COMPLETED:
        yield from _faulty_headline(result)


def _faulty_study(result: Stored, over: tuple[Hashable, ...]) -> Iterator[str]:
    """Faults in what every collected dataset must have."""
    attributes, forms = result.attributes, result.variables
    try:
        tolerances = json.loads(str(attributes.get(TOLERANCES, "{}")))
    except ValueError:
        tolerances = None
    sound = {
        # Names of pictures begin with that of the study, so it must not contain a folder.
        "study": isinstance(study := attributes["study"], str) and re.fullmatch(STUDY_NAME, study),
        "scene": isinstance(attributes.get("scene"), str),
        "scene_version": isinstance(attributes.get("scene_version"), int | np.integer),
        TOLERANCES: isinstance(tolerances, dict)
        and all(isinstance(tolerance, int | float) for tolerance in tolerances.values()),
        **{name: name in forms and forms[name].dims == over for name in PER_CASE},
        DRAWS: DRAWS not in forms or _are_counts(forms[DRAWS], over),
    }
    for name, is_sound in sound.items():
        if not is_sound:
            yield f"{name} is missing or malformed; collect it again"


def _are_counts(form: xr.Variable, over: tuple[Hashable, ...]) -> bool:
    """Whether a variable has a positive integer per case, with a sum that a study may have."""
    if form.dims != over or form.dtype.kind not in "iu":
        return False
    return bool((form.values >= 1).all() and form.values.sum(dtype=float) <= LARGEST_STUDY)


def _faulty_dims(forms: Forms, name: str, over: tuple[Hashable, ...]) -> Iterator[str]:
    form = forms[name]
    of_cases = tuple(dim for dim in form.dims if dim in over)
    if of_cases != tuple(dim for dim in over if dim in of_cases):
        yield f"{name} has its dims in another order"
    own = [dim for dim in form.dims if dim not in over]
    if own and of_cases and of_cases != over:
        yield f"{name} lacks some dims of the cases"
    if any(dim not in forms for dim in form.dims):
        yield f"{name} has a dim without a coordinate"
    if name in form.dims and form.dims != (name,):
        yield f"{name} is a dim but also has other dims"
    if own and name not in form.dims and _role(form) in _OF_EACH_CASE:
        yield f"{name} has more than one value per case"


def _faulty_attributes(forms: Forms, name: str) -> Iterator[str]:
    attributes = forms[name].attrs
    for key in _TEXTS:
        if not isinstance(attributes.get(key, ""), str):
            yield f"{key} of {name} is not a text"
    limit = attributes.get("limit", 0.0)
    if not isinstance(limit, int | float | np.number) or not math.isfinite(limit):
        yield f"limit of {name} is not a number"
    role = _role(forms[name])
    if "role" in attributes and role not in _ROLES:
        yield f"the role of {name} is unknown"
    if role == Role.EXACT and str(attributes.get("exact_of")) not in forms:
        yield f"{name} is the exact value of no variable"
    # Missing numbers are NaN in the file, never another fill value.
    is_filled = str(attributes.get("_FillValue", "nan")) != "nan"
    if is_filled or any(key in attributes for key in _ENCODED):
        yield f"the numbers of {name} are packed or have a fill value"


def _faulty_headline(result: Stored) -> Iterator[str]:
    """Faults in the headline, which a completed case must have."""
    headlines = [name for name, form in result.variables.items() if _role(form) == Role.HEADLINE]
    if not headlines:
        yield "it is completed but has no headline"
    for name in headlines:
        is_number = result.variables[name].dtype.kind in NUMBERS
        if not (is_number and np.isfinite(result.variables[name].values).all()):
            yield f"it is completed but {name} is not finite"


def _text_parameters(forms: Forms, scenes: list[str]) -> Iterator[str]:
    """Names of the variables that hold parameters that are texts."""
    texts = {
        name
        for scene in scenes
        if scene in scene_names()
        for name, definition in parameters_of(scene_class(scene)).items()
        if definition.kind is str
    }
    for stored, form in forms.items():
        if _role(form) == Role.PARAMETER and parameter_of(stored) in texts:
            yield stored


def _role(form: xr.Variable) -> str:
    """The role of a variable; "" if it has none, or one that is not a text."""
    role = form.attrs.get("role")
    return role if isinstance(role, str) else ""
