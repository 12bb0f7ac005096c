"""Comparing results: two files case by case or bit by bit; cases of one file as ratios and slopes.

The uncertainty of a difference. The half width of a headline has two kinds of parts. Noise and
steadiness differ from case to case. The remaining errors of the laws of mesh, speed and window may
be similar in two cases, and would then partly cancel in a difference. They are, to some degree: the
errors of the 24 random cases of `studies/held_out_default.csv` have a mean of 0.009 and a standard
deviation of 0.015, so that two of them have a correlation of 0.22.

The common part of an error is not known case by case. So half widths are combined as the root of
the sum of squares, which is too large rather than too small if two errors have the same sign. All
276 differences of these cases, and as many ratios, agree with those of the fine runs within it.
"""

import itertools
import math
from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    COMPLETED,
    Role,
    case_dims,
    freely_varied,
    headline_values,
    headlines_of,
    is_there,
    labels_of,
    over_cases,
    parameter_names,
    parameter_of,
    reasons_of,
    scenes_of,
    spoken,
    stated,
    uncertainty_of,
    varied_names,
    varied_within,
    with_role,
)
from harness.archive.provenance import OF_CASE
from harness.compare.compared import NothingToCompareError
from harness.study.cases import complete_parameters
from harness.study.compared import ERROR
from mpm_warp.fields.flat import parameters_of
from mpm_warp.scenes import scene_class, scene_names

Identity = tuple[str, frozenset[tuple[str, object]]]
"""Scene and parameters of a case."""


@dataclass(frozen=True)
class Difference:
    """The largest relative difference of one variable between two results."""

    name: str
    size: float  # relative to the first, of a curve to its largest; infinite where one has none
    label: str  # the case with this difference


def differences(first: xr.Dataset, second: xr.Dataset) -> tuple[list[Difference], list[str]]:
    """Compare two results, case by case with the same parameters.

    Before parameters are compared, the scene fills in what a result lacks: defaults of parameters
    that were added later, and derived ones. A parameter that the scene no longer has is compared
    if both results have it, or if it varies. Returned are the largest difference of each result,
    scalar or curve, without measured times and memory, and a line for each case that only one
    result has or has completed. A difference is 0 only where both have the same numbers.
    """
    shared = parameter_names(first).keys() & parameter_names(second).keys()
    ours, theirs = _identities(first, shared), _identities(second, shared)
    common = [identity for identity in ours if identity in theirs]
    if not common:
        raise NothingToCompareError("nothing to compare: no case has the same parameters in both")
    labels, of_second = labels_of(first), labels_of(second)
    lonely = [f"only in the first: {labels[ours[key]]}" for key in ours if key not in theirs]
    lonely += [f"only in the second: {of_second[theirs[key]]}" for key in theirs if key not in ours]
    here, there = [ours[identity] for identity in common], [theirs[identity] for identity in common]
    statuses = over_cases(first, "status")[here], over_cases(second, "status")[there]
    lonely += [
        f"{before} in the first, {after} in the second: {labels[place]}"
        for place, before, after in zip(here, *statuses, strict=True)
        if (before == COMPLETED) != (after == COMPLETED)
    ]
    of_cases = {*case_dims(first), *case_dims(second)}
    first, second = xr.align(first, second, join="outer", exclude=of_cases)
    found = []
    is_compared = False
    for name in sorted(_results(first) | _results(second)):
        before, after = _rows(first, name)[here], _rows(second, name)[there]
        is_compared |= not (np.isnan(before).all() and np.isnan(after).all())
        sizes = _relative(before, after)
        worst = int(np.argmax(sizes))
        found.append(Difference(name, float(sizes[worst]), labels[here[worst]]))
    if not is_compared and not lonely:
        raise NothingToCompareError("nothing to compare: no case has a result in either")
    return found, lonely


def unshared(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """A line for each of two results that has parameters which the other lacks."""
    ours, theirs = parameter_names(first).keys(), parameter_names(second).keys()
    return [
        f"only the {which} has {', '.join(sorted(names))}; for the other the default is assumed"
        for which, names in (("first", ours - theirs), ("second", theirs - ours))
        if names
    ]


def difference_rows(found: Sequence[Difference], tolerance: float) -> list[str]:
    """A line per variable: largest difference, whether it is within the tolerance, and its case."""
    width = max((len(entry.name) for entry in found), default=0)
    rows = []
    for row in found:
        verdict = "MISSED" if row.size > tolerance else "ok"
        rows.append(f"{row.name:{width}}  {row.size:9.3g}  {verdict:6}  {row.label}")
    return rows


def differing(one: xr.Dataset, other: xr.Dataset, *, measures_machine: bool = False) -> list[str]:
    """Names of the variables in which two results of a case differ by at least one bit.

    Parameters, measurements and provenance are ignored; with `measures_machine` the headline too.
    """
    roles = [Role.MEASURED, Role.PARAMETER, *([Role.HEADLINE] if measures_machine else [])]
    aside = {*OF_CASE, *with_role(one, *roles), *with_role(other, *roles)}
    names = sorted({*map(str, one.variables), *map(str, other.variables)} - aside)
    return [
        name
        for name in names
        if not (name in one.variables and name in other.variables and _same(one, other, name))
    ]


def _same(one: xr.Dataset, other: xr.Dataset, name: str) -> bool:
    # `identical` would take 0 for -0.
    first, second = one[name].variable, other[name].variable
    same_kind = (first.dims, first.shape, first.dtype) == (second.dims, second.shape, second.dtype)
    return same_kind and (
        first.values.tobytes() == second.values.tobytes()
        if first.dtype.kind != "O"
        else first.values.tolist() == second.values.tolist()
    )


def _relative(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """The largest change of each row over the largest number before; rows of [case, point]."""
    same = (before == after) | (np.isnan(before) & np.isnan(after))
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.where(same, 0.0, np.abs(after - before)).max(axis=1)
        relative = change / np.where(np.isnan(before), 0.0, np.abs(before)).max(axis=1)
    return np.where(change == 0.0, 0.0, np.where(np.isnan(relative), np.inf, relative))


def _results(dataset: xr.Dataset) -> set[str]:
    """Names of the numbers that a case computes: scalars and curves."""
    no_results = Role.PARAMETER, Role.REFERENCE, Role.DEVIATION, Role.MEASURED
    return {
        str(name)
        for name, array in dataset.data_vars.items()
        if {*case_dims(dataset)} <= {*array.dims} and array.dtype.kind in "iuf"
    } - set(with_role(dataset, *no_results))


def _rows(dataset: xr.Dataset, name: str) -> np.ndarray:
    """A result of each case, shape [case, point]; NaN if the dataset lacks it."""
    values = dataset.get(name, np.nan * xr.ones_like(dataset["status"], float))
    return values.transpose(*case_dims(dataset), ...).values.reshape(dataset["status"].size, -1)


def _identities(dataset: xr.Dataset, shared: AbstractSet[str]) -> dict[Identity, int]:
    """The index of each case, by its scene and all its parameters."""
    names = parameter_names(dataset)
    columns = [over_cases(dataset, stored).tolist() for stored in names.values()]
    names_of_scenes = scenes_of(dataset)
    scenes = {name: scene_class(name) for name in names_of_scenes}
    places = {}
    for place, (name, *values) in enumerate(zip(names_of_scenes, *columns, strict=True)):
        scene = scenes[name]
        given = {
            key: given_value
            for key, given_value in zip(names, values, strict=True)
            if is_there(given_value)
        }
        known = {
            key: definition.kind(given.pop(key))
            for key, definition in parameters_of(scene).items()
            if key in given
        }
        # The rest are parameters that the scene no longer has.
        others = {
            key: value for key, value in given.items() if key in shared or dataset[names[key]].ndim
        }
        identity = frozenset({**complete_parameters(scene, known)[0], **others}.items())
        places[name, identity] = place
    return places


PARTS = ("stretch_number", "stretch_count", "to_depth", "from_depth")
"""Parameters that choose a part of one sounding."""
Known = tuple[float, float]
"""A value and its half width of 95 %; NaN where none is known."""
SHARES = ("ratio", "share")
"""Last words of the names of results that are no factors, though they have no unit either."""


def difference(first: Known, second: Known) -> Known:
    """`first` minus `second`."""
    return first[0] - second[0], math.hypot(first[1], second[1])


def ratio(first: Known, second: Known) -> Known:
    """`first` divided by `second`, which must not be 0."""
    value = first[0] / second[0]
    return value, math.hypot(first[1], value * second[1]) / abs(second[0])


def slope(places: np.ndarray, values: np.ndarray) -> Known:
    """Slope of the least-squares line through `values`, [n, 2] with half widths, at `places`."""
    number, half_width = values.T
    beside = places - places.mean()
    weights = beside / (beside @ beside)
    return float(weights @ number), float(np.linalg.norm(weights * half_width))


def ratio_notes(dataset: xr.Dataset) -> list[str]:
    """A line for each ratio of two scenes in the same soil, with its half width.

    Only results of the same unit and kind are compared, and no errors.
    """
    values, reasons, kinds = _headlines(dataset), reasons_of(dataset), _kinds_of_results(dataset)
    scenes, stored, within = scenes_of(dataset), parameter_names(dataset), varied_within(dataset)
    known = [scene_class(scene) for scene in {*scenes} & {*scene_names()}]
    method = {stored.get(name, name) for scene in known for name in scene.method}
    # Soils are distinguished neither by parameters that some scenes lack, nor by the mesh if each
    # scene has its own.
    columns = {
        name: column
        for name in varied_names(dataset)
        if name != "scene"
        and (name in within or name not in method)
        and all(map(is_there, column := over_cases(dataset, name).tolist()))
    }
    soils: dict[str, dict[str, int]] = {}
    for case, scene in enumerate(scenes):
        label = ", ".join(f"{name}={column[case]}" for name, column in columns.items())
        soils.setdefault(label, {}).setdefault(scene, case)
    notes = []
    for label, cases in soils.items():
        for (one, first), (other, second) in itertools.combinations(cases.items(), 2):
            are_alike = kinds[first] is not None and kinds[first] == kinds[second]
            if are_alike and values[second][0]:
                reason = "; ".join(filter(None, (reasons[first], reasons[second])))
                text = stated(*ratio(values[first], values[second]), reason)
                names = ", ".join(filter(None, [f"{spoken(one)} over {spoken(other)}", label]))
                notes.append(f"{names}: {text}")
    return notes


def change_notes(dataset: xr.Dataset) -> list[str]:
    """A line on the effect of the only varied parameter: difference, ratio and slope.

    None for a parameter of the method, because its cases share their errors; none for parts of a
    sounding.
    """
    names, values = freely_varied(dataset), np.array(_headlines(dataset))
    scene = scenes_of(dataset)[0]
    method = scene_class(scene).method if scene in scene_names() else ()
    if len(names) != 1 or parameter_of(names[0]) in (*method, *PARTS):
        return []
    (name,), places = names, over_cases(dataset, names[0])
    if places.dtype.kind not in "if" or not np.isfinite(values).all() or len(values) < 2:
        return []
    order = np.argsort(places)
    least, greatest = ((float(value[0]), float(value[1])) for value in values[order[[0, -1]]])
    kind, own = _kinds_of_results(dataset)[0], str(dataset[name].attrs.get("units", "1"))
    unit = f" {kind[0]}" if kind is not None and kind[0] != "1" else ""
    own_unit, per_unit = ("", "") if own == "1" else (f" {own}", f" per {own}")
    effects = [f"difference {stated(*difference(greatest, least))}{unit}"]
    effects += [f"ratio {stated(*ratio(greatest, least))}"] if least[0] else []
    effects += [f"slope of the straight line {stated(*slope(places, values))}{unit}{per_unit}"]
    return [f"{name} from {places.min():g} to {places.max():g}{own_unit}: {', '.join(effects)}"]


def _kinds_of_results(dataset: xr.Dataset) -> list[tuple[str, str] | None]:
    """What the headline of each case is: its unit, and whether it is a factor, a ratio or a share.

    None if a case has no headline, or if that is an error.
    """
    kinds: list[tuple[str, str] | None] = [None] * dataset["status"].size
    for name in headlines_of(dataset):
        if name != ERROR:
            word = name.rpartition("_")[2]
            kind = str(dataset[name].attrs.get("units", "1")), word if word in SHARES else ""
            known = np.isfinite(over_cases(dataset, name))
            kinds = [kind if it else had for it, had in zip(known, kinds, strict=True)]
    return kinds


def _headlines(dataset: xr.Dataset) -> list[Known]:
    half_widths = uncertainty_of(dataset).astype(float)
    return list(zip(headline_values(dataset).tolist(), half_widths.tolist(), strict=True))
