"""Conventions of result datasets: names, dims, roles and attributes of their variables.

Dims. `status` holds the outcome of each case, over the dims of cases. These are the varied
parameters where a study runs all their combinations, and otherwise the single dim `case`. Varied
parameters are coordinates along these dims.

Roles. The attribute ``role`` of a variable says how the harness uses it. `mpm_warp.results.ROLES`
lists the roles that scenes give. A case without a finite ``headline`` is never `completed`, and no
error is computed from a headline that has not settled. The harness adds three roles:
``reference`` is a value of the literature, ``deviation`` the relative deviation of the result from
it, and ``experience`` a band of field values, least and greatest, over the dim `bound`. A case
whose value exceeds the attribute ``limit`` is `inaccurate`.

Names. The harness itself reads only these results by name: `status`, `message` and `case_key`;
`changed`, the parameter changed in a case of a one-at-a-time study; `run_time` [s] and
`particle_updates`, which every scene gives; `case_time` [s] and `peak_memory` [byte], which the
harness measures; `run_time_sample` over the dim `repeat` of timed runs; and `error` against an
exact solution. Tables and pictures for one kind of scene read further names.
"""

import math
from collections.abc import Hashable, Iterable
from enum import StrEnum

import numpy as np
import xarray as xr

from harness.study.compared import ERROR
from mpm_warp.fields.declaration import Parameter
from mpm_warp.results import PARAMETER_SUFFIX
from mpm_warp.uncertainty.further_runs import LARGEST_PART

COMPLETED, UNTIMED, NO_FIELDS = "completed", "untimed", "no_fields"
CRASHED, TIMED_OUT = "crashed", "timed_out"
FAILED, UNFINISHED = "failed", "unfinished"
MISSING, DAMAGED, UNREADABLE = "missing", "damaged", "unreadable"
OUTDATED = "outdated"
"""Statuses that the harness gives to cases. Errors of scenes give others."""


class Role(StrEnum):
    """How the harness uses a variable; see the docstring of this module and harness/README.md."""

    HEADLINE, UNCERTAINTY, SETTLED = "headline", "uncertainty", "settled"
    REASON, BUILT = "reason", "built"
    EXACT, ERROR = "exact", "error"
    MEASURED, PARAMETER = "measured", "parameter"
    REFERENCE, DEVIATION = "reference", "deviation"
    EXPERIENCE = "experience"


CASE = "case"
"""The dim of cases, if the varied parameters are not the dims."""
PER_CASE = ("status", "message", "case_key")
"""Texts that every collected result has for each case."""
CHANGED = "changed"
"""In a one-at-a-time study: the parameter changed in each case, "" in the case of fixed values."""
ORDER = "order_of_coordinates"
"""Attribute of the dataset of a study: its coordinates in order, which a file does not keep."""
DRAWS = "draws"
"""Number of Latin hypercube samples that give the same case: its weight in means and percentiles.

It is stored only if some case has several.
"""
TOLERANCES = "tolerances"
"""Attribute of a result with the tolerances of its study, as JSON."""
NUMERICAL = "numerical error only, of this clay, not of your soil"
HALF_WIDTH = f"half width of 95 %: {NUMERICAL}"
"""The meaning of +- in tables and pictures."""
DISTRIBUTION = "distribution"
"""Attribute of a varied parameter with the distribution that it was drawn from, in words."""
DERIVED_BY = "derived_by"
"""Attribute of a parameter that the study derives from others: the expression."""
OF_THE_RUN = ("steadiness", "noise")
"""Parts of U that a longer run makes smaller, whatever the mesh."""
GIVEN_BY = "scenes"
"""Attribute of a variable in a study of several scenes: names of the scenes that have it."""
TRACEBACK = "traceback"
"""Attribute of the file of a failed case: where in the program it failed."""


def with_role(dataset: xr.Dataset, *roles: str) -> list[str]:
    """Names of the variables that have one of these roles."""
    return [
        str(name)
        for name, variable in dataset.variables.items()
        if variable.attrs.get("role") in roles
    ]


def limits_of(dataset: xr.Dataset) -> dict[str, float]:
    """The largest allowed absolute value of each variable that has a limit, by name."""
    return {
        str(name): float(variable.attrs["limit"])
        for name, variable in dataset.data_vars.items()
        if "limit" in variable.attrs
    }


def parameter_names(dataset: xr.Dataset) -> dict[str, str]:
    """Names of variables that hold parameters, by the names of the parameters."""
    return {parameter_of(name): name for name in with_role(dataset, Role.PARAMETER)}


def parameter_of(stored: str) -> str:
    """Name of the parameter that the variable `stored` holds."""
    return stored.removesuffix(PARAMETER_SUFFIX)


def parameter_attributes(definition: Parameter) -> dict[str, str]:
    """Attributes of a variable that holds a parameter."""
    attributes = {
        # The long name is an axis label; most meanings are too long for one.
        "long_name": spoken(definition.name),
        "description": f"{definition.meaning}; {definition.allowed}",
        "role": Role.PARAMETER,
    }
    return attributes if definition.kind is str else {"units": definition.unit} | attributes


def spoken(name: Hashable) -> str:
    """A variable's name with blanks between the words."""
    own = str(name).rpartition(".")[2]  # of a law, as in material.critical_state_ratio
    return own.removesuffix(PARAMETER_SUFFIX).replace("_", " ")


def headlines_of(dataset: xr.Dataset) -> list[str]:
    """Names of the headlines that have one value per case."""
    dims, names = set(dataset["status"].dims), with_role(dataset, Role.HEADLINE)
    return [name for name in names if set(dataset[name].dims) <= dims]


def headline_values(dataset: xr.Dataset) -> np.ndarray:
    """The headline of each case, whatever its scene; NaN where there is none.

    In a study of several scenes `error` may be the headline of one scene and an additional result
    of another. So `error` is used only for cases without another headline.
    """
    names = headlines_of(dataset)
    return _first_known(dataset, sorted(names, key=lambda name: name == ERROR))


def uncertainty_of(dataset: xr.Dataset) -> np.ndarray:
    """The half width U of each case's headline; NaN where none is known."""
    return _first_known(dataset, with_role(dataset, Role.UNCERTAINTY))


def error_of_settings(dataset: xr.Dataset) -> np.ndarray:
    """U of each case without what a longer run would change: steadiness and noise.

    It compares settings of the method; U where no parts of it are known.
    """
    squares = uncertainty_of(dataset).astype(float) ** 2
    for name in with_role(dataset, Role.UNCERTAINTY):
        for part in OF_THE_RUN:
            known = over_cases(dataset, f"{name}_{part}").astype(float)
            squares = squares - np.nan_to_num(known) ** 2
    own: np.ndarray = np.sqrt(np.maximum(squares, 0.0))
    return own


def largest_parts_of(dataset: xr.Dataset) -> list[str]:
    """The largest part of each case's U, and what makes it smaller; "" without U.

    As "steadiness, 61 % of U^2: more penetration".
    """
    texts = over_cases(dataset, dataset.get(LARGEST_PART, ""))
    return [str(text) if is_there(text) else "" for text in texts.tolist()]


def _first_known(dataset: xr.Dataset, names: Iterable[str]) -> np.ndarray:
    """For each case the first of the named variables that is not NaN; NaN if all are."""
    known = over_cases(dataset, math.nan)
    for name in names:
        known = np.where(np.isnan(known), over_cases(dataset, name), known)
    return known


def reasons_of(dataset: xr.Dataset) -> list[str]:
    """Why each case has no uncertainty; "" where it has one or no reason is stored."""
    reasons = [""] * dataset["status"].size
    for name in with_role(dataset, Role.REASON):
        pairs = zip(reasons, over_cases(dataset, name).tolist(), strict=True)
        reasons = [known or (str(value) if is_there(value) else "") for known, value in pairs]
    return reasons


def known_digits(value: float, half_width: float) -> str:
    """A number with as many digits as its half width justifies; with three if that is not known."""
    if not math.isfinite(half_width) or half_width <= 0.0:
        return f"{value:#.3g}".removesuffix(".")
    # With one digit only, rounding could change a half width of 0.1 to 0.2 by half.
    leading = math.floor(math.log10(half_width))
    decimals = -leading + (half_width < 2.0 * 10.0**leading)
    return f"{round(value, decimals):z.{max(0, decimals)}f}"


def stated(value: float, half_width: float, reason: str = "") -> str:
    """A number with its half width, "10.49 +- 0.08", or with why it has none, "10.5, no U: Delta".

    A half width that is NaN is unknown; the reason is one of `reasons_of`.
    """
    number = known_digits(value, half_width)
    if math.isfinite(half_width) and half_width > 0.0:
        return f"{number} +- {known_digits(half_width, half_width)}"
    return ", ".join(filter(None, (number, without_half_width(reason))))


def without_half_width(reason: str) -> str:
    """The text shown instead of a half width: "no U: Delta, speed"; "" without a reason."""
    return f"no U: {words_of([reason])}" if reason else ""


def words_of(reasons: Iterable[str]) -> str:
    """The keywords of some reasons without duplicates: "Delta, speed"."""
    parts = (piece for reason in reasons for piece in reason.split("; ") if piece)
    return ", ".join(dict.fromkeys(part.partition(":")[0] for part in parts))


def case_dims(dataset: xr.Dataset) -> tuple[str, ...]:
    """The dims of cases."""
    return tuple(map(str, dataset["status"].dims))


def varied_names(dataset: xr.Dataset) -> list[str]:
    """Names of what a study varies: the dims of cases, or the coordinates along the dim `case`.

    In a study of several scenes a coordinate that only some scenes have is included if its values
    differ between their cases.
    """
    if case_dims(dataset) != (CASE,):
        return list(case_dims(dataset))
    along = (str(name) for name, array in dataset.coords.items() if array.dims == (CASE,))
    names = [name for name in along if name not in (CASE, "scene_version")]
    if "scene" not in names:
        return names
    values = {name: filter(is_there, over_cases(dataset, name).tolist()) for name in names}
    return [name for name in names if name == "scene" or len(set(values[name])) > 1]


def freely_varied(dataset: xr.Dataset) -> list[str]:
    """Names of what a study varies, without what it derives from that."""
    return [name for name in varied_names(dataset) if DERIVED_BY not in dataset[name].attrs]


def over_cases(dataset: xr.Dataset, variable: object) -> np.ndarray:
    """The values of a variable as a flat array with one entry per case.

    The variable is given by its name, as a number, or as an array over all, some or none of the
    dims of cases. A name that the dataset lacks gives NaN for every case.
    """
    values = dataset.get(variable, np.nan) if isinstance(variable, str) else variable
    of_all = xr.DataArray(values).broadcast_like(dataset["status"])
    return np.ravel(of_all.transpose(*case_dims(dataset)).values)


def alike(dataset: xr.Dataset, names: Iterable[str]) -> dict[tuple[object, ...], list[int]]:
    """Indices of the cases that have the same values of some variables, by these values.

    None stands for a missing value.
    """
    columns = [over_cases(dataset, name).tolist() for name in names]
    groups: dict[tuple[object, ...], list[int]] = {}
    for case in range(dataset["status"].size):
        values = (column[case] for column in columns)
        key = tuple(value if is_there(value) else None for value in values)
        groups.setdefault(key, []).append(case)
    return groups


def by_case(dataset: xr.Dataset) -> xr.Dataset:
    """A result over the single dim `case`, which comes first; varied coordinates are dropped."""
    dims = case_dims(dataset)
    if dims == (CASE,):
        cases = dataset
    else:
        cases = dataset.stack(case=dims) if dims else dataset.expand_dims(CASE)
    numbered = cases.drop_vars([CASE, *dims], errors="ignore").transpose(CASE, ...)
    return numbered.assign_coords({CASE: np.arange(numbered.sizes[CASE])})


def varied_within(dataset: xr.Dataset) -> list[str]:
    """Names of what a study varies between cases of the same scene."""
    scenes = np.array(scenes_of(dataset))

    def differs(name: str) -> bool:
        values = over_cases(dataset, name)
        return any(
            len({value for value in values[scenes == kind].tolist() if is_there(value)}) > 1
            for kind in set(scenes.tolist())
        )

    return [name for name in varied_names(dataset) if name != "scene" and differs(name)]


def labels_of(dataset: xr.Dataset) -> list[str]:
    """The label of each case: its varied values as "name=value"."""
    names = varied_names(dataset)
    if not names:
        return [str(dataset.attrs["scene"])] * dataset["status"].size
    columns = [over_cases(dataset, name).tolist() for name in names]
    rows = [zip(names, row, strict=True) for row in zip(*columns, strict=True)]
    return [", ".join(f"{name}={_text(it)}" for name, it in row if is_there(it)) for row in rows]


def _text(value: object) -> str:
    # Eight digits tell cases apart; those after them are of the binary number.
    return str(float(f"{value:.8g}") if isinstance(value, float) else value)


def scenes_of(dataset: xr.Dataset) -> list[str]:
    """The scene of each case."""
    if "scene" in dataset.coords:
        return [str(name) for name in over_cases(dataset, "scene")]
    return [str(dataset.attrs.get("scene", ""))] * dataset["status"].size


def without_incomplete_curves(dataset: xr.Dataset) -> xr.Dataset:
    """A result in which curves of cases that did not complete are NaN, as their scalars are.

    A curve that no completed case has is dropped.
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
    """Whether a value is present: a parameter that a case lacks is NaN, an empty text or None."""
    return value is not None and str(value) not in ("", "nan")
