"""Comparison as a gate: which tolerances a result misses, and where two results differ."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.compare.cone_factors import conditions_of, varied_along
from harness.errors import HarnessError
from harness.references import cone_factor_reference
from harness.run.measuring import MEASURED
from harness.study.cases import COMPLETED
from mpm_warp.parameters import did_you_mean, parameters_of
from mpm_warp.scenes import scene_class

ATTRIBUTE = "tolerances"
"""Attribute of a dataset with the tolerances of its study, as JSON."""


class NotComparableError(HarnessError):
    """Two results have no case or no number in common; the message is one line."""


def with_tolerances(dataset: xr.Dataset, tolerances: Mapping[str, float]) -> xr.Dataset:
    """The dataset with its study's tolerances, so that its file alone can be checked."""
    return dataset.assign_attrs({ATTRIBUTE: json.dumps(dict(tolerances))} if tolerances else {})


def misses(dataset: xr.Dataset) -> list[str]:
    """What the tolerances that are stored in `dataset` do not allow, a line each.

    The tolerance of a reference bounds the size of the deviation from it, in the cases that it
    applies to; that of a result bounds its size. What is not a number, or nowhere to be found, is
    missed too: a check that was not made is not passed.
    """
    tolerances: dict[str, float] = json.loads(dataset.attrs.get(ATTRIBUTE, "{}"))
    return [line for name, limit in tolerances.items() for line in _misses_of(dataset, name, limit)]


def _misses_of(dataset: xr.Dataset, name: str, limit: float) -> list[str]:
    status = dataset["status"]
    if f"deviation_{name}" in dataset:
        value = dataset[f"deviation_{name}"]
        applies = xr.DataArray(cone_factor_reference(name).applies(conditions_of(dataset)))
    elif name in dataset and dataset[name].dtype.kind in "iuf":
        value, applies = dataset[name], xr.DataArray(True)
    else:
        known = [str(it) for it in dataset.data_vars if dataset[it].dtype.kind in "iuf"]
        return [f"{name}: is neither a reference nor a result here{did_you_mean(name, known)}"]
    size = abs(value).max([dim for dim in value.dims if dim not in status.dims])
    sizes = size.broadcast_like(status).transpose(*status.dims).values.ravel()
    held = applies.broadcast_like(status).transpose(*status.dims).values.ravel()
    if not held.any():
        return [f"{name}: applies to no case"]
    return [
        f"{name}: {label}: {size:.3g} is beyond the tolerance {limit:g}"
        for label, size, is_held in zip(_labels(dataset), sizes, held, strict=True)
        if is_held and not size <= limit
    ]


@dataclass(frozen=True)
class Difference:
    """The largest relative difference of one result over the cases of two datasets.

    Attributes:
        name: of the result.
        size: difference over the first's value; infinite where only one has a number.
        label: the case.
    """

    name: str
    size: float
    label: str


def differences(first: xr.Dataset, second: xr.Dataset) -> tuple[list[Difference], list[str]]:
    """Set two results side by side, case by case of the same parameters.

    Returns:
        The largest difference of each scalar result, times and memory left aside where they are
        not what the scene is for; and the cases that only one of them has or has completed, a line
        each.

    Raises:
        NotComparableError: they have no case in common, or nothing there that can be compared.
    """
    names = [set(_parameter_names(dataset)) for dataset in (first, second)]
    ours, theirs = (_by_parameters(dataset, names[0] & names[1]) for dataset in (first, second))
    common = [key for key in ours if key in theirs]
    if not common:
        raise NotComparableError("nothing to compare: no case has the same parameters in both")
    labels = _labels(first)
    lonely = [
        f"only in the {which}: {text[index]}"
        for which, text, mine, other in (
            ("first", labels, ours, theirs),
            ("second", _labels(second), theirs, ours),
        )
        for key, index in mine.items()
        if key not in other
    ]
    places = [ours[key] for key in common], [theirs[key] for key in common]
    lonely += _completed_once(first, second, places)
    found = []
    is_compared = False
    for name in sorted(_scalar_results(first) | _scalar_results(second)):
        before, after = (
            _flat(dataset, name)[place]
            for dataset, place in zip((first, second), places, strict=True)
        )
        is_compared |= not (np.isnan(before) & np.isnan(after)).all()
        sizes = _relative(before, after)
        worst = int(np.argmax(sizes))
        found.append(Difference(name, float(sizes[worst]), labels[places[0][worst]]))
    if not is_compared and not lonely:
        raise NotComparableError("nothing to compare: no case has a scalar result in either")
    return found, lonely


def unshared(first: xr.Dataset, second: xr.Dataset) -> list[str]:
    """The parameters that only one of two results has, a line for each that has some.

    :func:`differences` compares cases in which these are at their default, where the scene has one.
    """
    ours, theirs = set(_parameter_names(first)), set(_parameter_names(second))
    return [
        f"only the {which} has {', '.join(sorted(names))}: compared where at the default"
        for which, names in (("first", ours - theirs), ("second", theirs - ours))
        if names
    ]


def _completed_once(
    first: xr.Dataset, second: xr.Dataset, places: tuple[Sequence[int], Sequence[int]]
) -> list[str]:
    """The cases, at these places of both results, that have completed in one alone."""
    labels, before, after = _labels(first), *(_flat(it, "status") for it in (first, second))
    return [
        f"{before[ours]} in the first, {after[theirs]} in the second: {labels[ours]}"
        for ours, theirs in zip(*places, strict=True)
        if (before[ours] == COMPLETED) != (after[theirs] == COMPLETED)
    ]


def difference_rows(found: list[Difference], tolerance: float) -> list[str]:
    """A line a result, the largest difference and where it is."""
    width = max((len(it.name) for it in found), default=0)
    rows = []
    for it in found:
        verdict = "MISSED" if it.size > tolerance else "ok"
        rows.append(f"{it.name:{width}}  {it.size:9.3g}  {verdict:6}  {it.label}")
    return rows


def _relative(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    same = (before == after) | (np.isnan(before) & np.isnan(after))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.abs(after - before) / np.abs(before)
    return np.where(same, 0.0, np.where(np.isnan(relative), np.inf, relative))


def _scalar_results(dataset: xr.Dataset) -> set[str]:
    dims = dataset["status"].dims
    parameters = set(_parameter_names(dataset).values())
    # Times are left aside but where the scene is run for them.
    headlines = {scene_class(scene).headline for scene in str(dataset.attrs["scene"]).split()}
    literature = ("reference_", "deviation_")
    return {
        str(name)
        for name, array in dataset.data_vars.items()
        if array.dims == dims
        and array.dtype.kind in "iuf"
        and name not in (MEASURED - headlines) | parameters
        and not str(name).startswith(literature)
    }


def _flat(dataset: xr.Dataset, name: str) -> np.ndarray:
    status = dataset["status"]
    if name not in dataset:
        return np.full(status.size, np.nan)
    flat: np.ndarray = dataset[name].broadcast_like(status).transpose(*status.dims).values.ravel()
    return flat


def _by_parameters(
    dataset: xr.Dataset, shared: AbstractSet[str]
) -> dict[tuple[str, frozenset[tuple[str, object]]], int]:
    """The place of each case, by its scene and what is said of its parameters.

    A parameter that the other result does not have, which another version of the scene has made,
    is left out where it is at its default, or where the scene has none and it does not vary.
    """
    names = _parameter_names(dataset)
    columns = [_flat(dataset, stored).tolist() for stored in names.values()]
    scene = dataset["scene"].values if "scene" in dataset.coords else None
    scenes = [dataset.attrs["scene"]] * dataset["status"].size if scene is None else scene
    strange = set(names) - set(_known_names(dataset))
    telling = shared | {name for name in strange if dataset[names[name]].ndim}
    places = {}
    for index, (of_scene, *values) in enumerate(zip(scenes, *columns, strict=True)):
        definitions = parameters_of(scene_class(str(of_scene)))
        defaults = {name: definition.default for name, definition in definitions.items()}
        said = frozenset(
            (name, value)
            for name, value in zip(names, values, strict=True)
            if str(value) not in ("", "nan")  # derived, or of another scene
            and (name in telling or value != defaults.get(name, value))
        )
        places[str(of_scene), said] = index
    return places


def _parameter_names(dataset: xr.Dataset) -> dict[str, str]:
    """What each parameter is called in the dataset, those included that its scene no longer has."""
    names = {name: f"{name}_parameter" for name in _known_names(dataset)}
    called = {name: own if own in dataset else name for name, own in names.items()}
    dims = dataset["status"].dims
    varied = [name for name in varied_along(dataset, dims) if name != "scene"]
    # Over no dim of cases but one case alone are results, and what is the same in all cases.
    fixed = [
        str(name)
        for name, array in dataset.data_vars.items()
        if dims and array.ndim == 0 and "description" in array.attrs
    ]
    called |= {name: name for name in (*varied, *fixed) if name not in called.values()}
    return {name: own for name, own in called.items() if own in dataset}


def _known_names(dataset: xr.Dataset) -> list[str]:
    """The parameters that its scenes have now."""
    scenes = str(dataset.attrs["scene"]).split()
    return list(dict.fromkeys(it for scene in scenes for it in parameters_of(scene_class(scene))))


def _labels(dataset: xr.Dataset) -> list[str]:
    names = varied_along(dataset, dataset["status"].dims)
    columns = [_flat(dataset, name).tolist() for name in names]
    if not columns:
        return [str(dataset.attrs["scene"])] * dataset["status"].size
    return [
        ", ".join(
            f"{name}={value}"
            for name, value in zip(names, row, strict=True)
            if value not in ("", None) and str(value) != "nan"  # of another scene
        )
        for row in zip(*columns, strict=True)
    ]
