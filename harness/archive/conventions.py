"""Conventions of datasets: what the variables of every result are called and what they mean.

A result has the status of each case as the variable `status`, over the dims of cases: the varied
parameters where a study runs all their combinations, else the single dim `case`. What the study
varies is a coordinate along these dims. A variable's attribute ``role`` says what it is to the
harness, which knows no other names of results than those below. The roles that a scene gives are
`mpm_warp.results.ROLES`; without a finite headline no case is `completed`, and no error is derived
from one that has not settled. The harness adds a ``reference`` of the literature, the result's
relative ``deviation`` from it, and ``experience``, a band of values from the field over the dim
`bound`: the least and the greatest. Beyond the attribute ``limit`` a case is `inaccurate`.

Results that the harness reads by name: `status`, `message` and `case_key` of each case, and of one
parameter at a time which it is, `changed`; `run_time` [s] and `particle_updates`, which every scene
gives; `case_time` [s] and `peak_memory` [byte], which the harness measures, and `run_time_sample`
over the dim `repeat` of timed runs; `error` against an exact solution. Only a table or a picture
that is meant for one kind of scene knows more names.
"""

import math
from collections.abc import Hashable, Iterable
from enum import StrEnum

import numpy as np
import xarray as xr

from harness.study.compared import ERROR
from mpm_warp.parameters import Parameter
from mpm_warp.results import PARAMETER_SUFFIX

FORMAT_VERSION = 1
"""Version of the layout of case files and study files alike."""

COMPLETED, UNTIMED, NO_FIELDS = "completed", "untimed", "no_fields"
CRASHED, TIMED_OUT = "crashed", "timed_out"
FAILED, UNFINISHED = "failed", "unfinished"
MISSING, DAMAGED = "missing", "damaged"
"""Statuses of cases that the harness itself gives; a scene's errors name others."""


class Role(StrEnum):
    """What a variable is to the harness."""

    HEADLINE, UNCERTAINTY, SETTLED = "headline", "uncertainty", "settled"
    REASON, BUILT = "reason", "built"
    EXACT, ERROR = "exact", "error"
    MEASURED, PARAMETER = "measured", "parameter"
    REFERENCE, DEVIATION = "reference", "deviation"
    EXPERIENCE = "experience"


CASE = "case"
"""The dim of cases where the varied parameters are no dims."""
PER_CASE = ("status", "message", "case_key")
"""Texts that every collected result has for each case."""
CHANGED = "changed"
"""Text of each case of one parameter at a time: that parameter, "" in the case of fixed values."""
DRAWS = "draws"
"""Number of samples of a Latin hypercube that are the same case; only where some case has several.

It is the weight of the case in means and percentiles.
"""
TOLERANCES = "tolerances"
"""Attribute of a result with the tolerances of its study, as JSON."""
NUMERICAL = "numerical error only, of this clay, not of your soil"
HALF_WIDTH = f"half width of 95 %: {NUMERICAL}"
"""What +- means."""
DISTRIBUTION = "distribution"
"""Attribute of a varied parameter with the distribution that it was drawn from, in words."""
GIVEN_BY = "scenes"
"""Attribute of a result in a study of several scenes: those that have it, a number or not."""
TRACEBACK = "traceback"
"""Attribute of the file of a failed case that says where in the program it failed."""


def with_role(dataset: xr.Dataset, *roles: str) -> list[str]:
    """Names of the variables that have one of these roles."""
    return [
        str(name)
        for name, variable in dataset.variables.items()
        if variable.attrs.get("role") in roles
    ]


def limits_of(dataset: xr.Dataset) -> dict[str, float]:
    """The largest sizes allowed, by the names of the variables that have such a limit."""
    return {
        str(name): float(variable.attrs["limit"])
        for name, variable in dataset.data_vars.items()
        if "limit" in variable.attrs
    }


def parameter_names(dataset: xr.Dataset) -> dict[str, str]:
    """The parameters in a dataset: what they are called there, by their own names."""
    return {parameter_of(name): name for name in with_role(dataset, Role.PARAMETER)}


def parameter_of(stored: str) -> str:
    """The parameter that is called `stored` in a dataset."""
    return stored.removesuffix(PARAMETER_SUFFIX)


def parameter_attributes(definition: Parameter) -> dict[str, str]:
    """Attributes of a variable that holds a parameter."""
    attributes = {
        # The long name labels an axis, for which most meanings are too long.
        "long_name": spoken(definition.name),
        "description": f"{definition.meaning}; {definition.allowed}",
        "role": Role.PARAMETER,
    }
    return attributes if definition.kind is str else {"units": definition.unit} | attributes


def spoken(name: Hashable) -> str:
    """A variable's name as words."""
    return str(name).removesuffix(PARAMETER_SUFFIX).replace("_", " ")


def headlines_of(dataset: xr.Dataset) -> list[str]:
    """What the scenes are run for, as far as each case has one value of it."""
    dims, names = set(dataset["status"].dims), with_role(dataset, Role.HEADLINE)
    return [name for name in names if set(dataset[name].dims) <= dims]


def headline_values(dataset: xr.Dataset) -> np.ndarray:
    """The headline of each case, whatever its scene; not a number where there is none.

    Of several scenes one may be run for its error, which others have beside their headline.
    """
    names = headlines_of(dataset)
    return _first_known(dataset, sorted(names, key=lambda name: name == ERROR))


def uncertainty_of(dataset: xr.Dataset) -> np.ndarray:
    """The half width of each case's headline, not a number where none is known."""
    return _first_known(dataset, with_role(dataset, Role.UNCERTAINTY))


def _first_known(dataset: xr.Dataset, names: Iterable[str]) -> np.ndarray:
    """Of each case the one result that its scene has, of those of several scenes."""
    known = over_cases(dataset, math.nan)
    for name in names:
        known = np.where(np.isnan(known), over_cases(dataset, name), known)
    return known


def reasons_of(dataset: xr.Dataset) -> list[str]:
    """Why each case has no uncertainty; "" where it has one, or where nothing is said of it."""
    reasons = [""] * dataset["status"].size
    for name in with_role(dataset, Role.REASON):
        told = over_cases(dataset, name).tolist()
        pairs = zip(reasons, told, strict=True)
        reasons = [known or (str(value) if is_there(value) else "") for known, value in pairs]
    return reasons


def known_digits(value: float, half_width: float) -> str:
    """A number with the digits that are known of it: 10.49; 10.5 where no error is known."""
    if not math.isfinite(half_width) or half_width <= 0.0:
        return f"{value:#.3g}".removesuffix(".")
    # A half width of 0.1 to 0.2 would lose half of itself to rounding with one digit.
    leading = math.floor(math.log10(half_width))
    decimals = max(0, -leading + (half_width < 2.0 * 10.0**leading))
    return f"{value:.{decimals}f}"


def stated(value: float, half_width: float, reason: str = "") -> str:
    """A number with its half width of 95 %: 10.49 +- 0.08; without one with the word for why.

    The reason is one of `reasons_of`: 10.5, no U: Delta. A half width may be not a number.
    """
    told = known_digits(value, half_width)
    if math.isfinite(half_width) and half_width > 0.0:
        return f"{told} +- {known_digits(half_width, half_width)}"
    return ", ".join(filter(None, (told, without_half_width(reason))))


def without_half_width(reason: str) -> str:
    """What stands in the place of a half width: no U: Delta, speed; "" without a reason."""
    return f"no U: {words_of([reason])}" if reason else ""


def words_of(reasons: Iterable[str]) -> str:
    """The words of some reasons, each once: Delta, speed."""
    parts = (piece for reason in reasons for piece in reason.split("; ") if piece)
    return ", ".join(dict.fromkeys(part.partition(":")[0] for part in parts))


def case_dims(dataset: xr.Dataset) -> tuple[str, ...]:
    """The dims of cases."""
    return tuple(map(str, dataset["status"].dims))


def varied_names(dataset: xr.Dataset) -> list[str]:
    """What a study varies: the dims of cases, or the coordinates along the dim `case`.

    With several scenes there are coordinates that only some of them have: such a one counts where
    these differ in it.
    """
    if case_dims(dataset) != (CASE,):
        return list(case_dims(dataset))
    along = (str(name) for name, array in dataset.coords.items() if array.dims == (CASE,))
    names = [name for name in along if name not in (CASE, "scene_version")]
    if "scene" not in names:
        return names
    values = {name: filter(is_there, over_cases(dataset, name).tolist()) for name in names}
    return [name for name in names if name == "scene" or len(set(values[name])) > 1]


def over_cases(dataset: xr.Dataset, variable: object) -> np.ndarray:
    """The values of a variable, by name or given, one for each case in their order.

    Args:
        dataset: the result of a study.
        variable: a number, or an array over the dims of cases, or some or none of them; or the name
            of one, and not a number where the dataset does not have it.
    """
    values = dataset.get(variable, np.nan) if isinstance(variable, str) else variable
    of_all = xr.DataArray(values).broadcast_like(dataset["status"])
    return np.ravel(of_all.transpose(*case_dims(dataset)).values)


def alike(dataset: xr.Dataset, names: Iterable[str]) -> dict[tuple[object, ...], list[int]]:
    """The places of the cases that have the same values of some variables, by these values.

    In the place of what a case has no value of stands None.
    """
    columns = [over_cases(dataset, name).tolist() for name in names]
    groups: dict[tuple[object, ...], list[int]] = {}
    for case in range(dataset["status"].size):
        values = (column[case] for column in columns)
        key = tuple(value if is_there(value) else None for value in values)
        groups.setdefault(key, []).append(case)
    return groups


def by_case(dataset: xr.Dataset) -> xr.Dataset:
    """A result over the one dim `case`, which comes first and numbers them; what varies is left."""
    dims = case_dims(dataset)
    if dims == (CASE,):
        cases = dataset
    else:
        cases = dataset.stack(case=dims) if dims else dataset.expand_dims(CASE)
    numbered = cases.drop_vars([CASE, *dims], errors="ignore").transpose(CASE, ...)
    return numbered.assign_coords({CASE: np.arange(numbered.sizes[CASE])})


def varied_within(dataset: xr.Dataset) -> list[str]:
    """What a study varies between cases of the same scene."""
    scenes = np.array(scenes_of(dataset))

    def differs(name: str) -> bool:
        values = over_cases(dataset, name)
        return any(
            len({value for value in values[scenes == kind].tolist() if is_there(value)}) > 1
            for kind in set(scenes.tolist())
        )

    return [name for name in varied_names(dataset) if name != "scene" and differs(name)]


def labels_of(dataset: xr.Dataset) -> list[str]:
    """What each case is called: the varied values, in words."""
    names = varied_names(dataset)
    if not names:
        return [str(dataset.attrs["scene"])] * dataset["status"].size
    columns = [over_cases(dataset, name).tolist() for name in names]
    return [
        ", ".join(
            f"{name}={value}" for name, value in zip(names, row, strict=True) if is_there(value)
        )
        for row in zip(*columns, strict=True)
    ]


def scenes_of(dataset: xr.Dataset) -> list[str]:
    """The scene of each case."""
    if "scene" in dataset.coords:
        return [str(name) for name in over_cases(dataset, "scene")]
    return [str(dataset.attrs.get("scene", ""))] * dataset["status"].size


def without_incomplete_curves(dataset: xr.Dataset) -> xr.Dataset:
    """A result without the curves of cases that did not complete, as every scalar is.

    A variable that no completed case has is left out.
    """
    dims = set(dataset["status"].dims)
    is_completed = dataset["status"] == COMPLETED
    kept = {
        name: curve.where(is_completed).transpose(*curve.dims)
        for name, curve in dataset.data_vars.items()
        if dims < set(curve.dims) and curve.dtype.kind == "f"
    }
    return dataset.assign(kept).drop_vars([name for name in kept if kept[name].isnull().all()])


def is_there(value: object) -> bool:
    """Whether a case has a value of a parameter: one of another scene is not a number, or empty."""
    return value is not None and str(value) not in ("", "nan")
