"""Ratios, differences and slopes of results, each with a half width of its own.

The half width of a headline holds parts of two kinds. Noise and what is still to come are of each
case alone. What is left open of the laws of mesh, speed and window would be common to two cases if
the laws were off alike everywhere; it would then cancel in a difference. It is not: of the 24
random cases of `studies/held_out_default.csv` the errors have a mean of 0.01 and a standard
deviation of 0.03, so that two of them have a correlation of 0.03 (0.22 with `accuracy = "quick"`).
Parts are therefore added as squares, which is too much rather than too little wherever errors of
two cases have the same sign. All 276 differences of these cases, and all their ratios, are inside,
98 % within 0.8 of it.
"""

import itertools
import math

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    Role,
    is_there,
    over_cases,
    reasons_of,
    scenes_of,
    spoken,
    stated,
    uncertainty_of,
    varied_names,
    with_role,
)
from mpm_warp.scenes import scene_class, scene_names

PARTS = ("stretch_number", "stretch_count", "to_depth", "from_depth")
"""Parameters that name a part of one sounding."""
Known = tuple[float, float]
"""A value and its half width of 95 %, not a number where none is known."""


def difference(first: Known, second: Known) -> Known:
    """The first less the second."""
    return first[0] - second[0], math.hypot(first[1], second[1])


def ratio(first: Known, second: Known) -> Known:
    """The first over the second, which is not 0."""
    value = first[0] / second[0]
    return value, abs(value) * math.hypot(first[1] / first[0], second[1] / second[0])


def slope(places: np.ndarray, values: np.ndarray) -> Known:
    """Of the line by least squares through values with half widths, [n, 2], at places [n]."""
    number, half_width = values.T
    beside = places - places.mean()
    weights = beside / (beside @ beside)
    return float(weights @ number), float(np.linalg.norm(weights * half_width))


def ratio_notes(dataset: xr.Dataset) -> list[str]:
    """Each ratio of two scenes in one soil, with its half width; none of one scene."""
    values, reasons = _headlines(dataset), reasons_of(dataset)
    # What only some of the scenes have tells no soils apart.
    columns = {
        name: column
        for name in varied_names(dataset)
        if name != "scene" and all(map(is_there, column := over_cases(dataset, name).tolist()))
    }
    soils: dict[str, dict[str, int]] = {}
    for case, scene in enumerate(scenes_of(dataset)):
        label = ", ".join(f"{name}={column[case]}" for name, column in columns.items())
        soils.setdefault(label, {}).setdefault(scene, case)
    notes = []
    for label, cases in soils.items():
        for (one, first), (other, second) in itertools.combinations(cases.items(), 2):
            if np.isfinite([values[first][0], values[second][0]]).all() and values[second][0]:
                reason = "; ".join(filter(None, (reasons[first], reasons[second])))
                told = stated(*ratio(values[first], values[second]), reason)
                names = ", ".join(filter(None, [f"{spoken(one)} over {spoken(other)}", label]))
                notes.append(f"{names}: {told}")
    return notes


def change_notes(dataset: xr.Dataset) -> list[str]:
    """What changes from the least to the greatest of the only varied number, and the slope.

    Nothing of a parameter of the method, whose cases share their errors, and of the parts of a
    sounding.
    """
    names, values = varied_names(dataset), np.array(_headlines(dataset))
    scene = scenes_of(dataset)[0]
    method = scene_class(scene).method if scene in scene_names() else ()
    if len(names) != 1 or names[0] in (*method, *PARTS):
        return []
    (name,), places = names, over_cases(dataset, names[0])
    if places.dtype.kind not in "if" or not np.isfinite(values).all() or len(values) < 2:
        return []
    order = np.argsort(places)
    least, greatest = ((float(it[0]), float(it[1])) for it in values[order[[0, -1]]])
    told = [f"difference {stated(*difference(greatest, least))}"]
    told += [f"ratio {stated(*ratio(greatest, least))}"] if least[0] else []
    told += [f"slope of the straight line {stated(*slope(places, values))}"]
    return [f"{name} from {places.min():g} to {places.max():g}: {', '.join(told)}"]


def _headlines(dataset: xr.Dataset) -> list[Known]:
    """The headline of each case and its half width."""
    values, dims = np.full(dataset["status"].size, np.nan), set(dataset["status"].dims)
    for name in with_role(dataset, Role.HEADLINE):
        if set(dataset[name].dims) <= dims:
            values = np.where(np.isnan(values), over_cases(dataset, name).astype(float), values)
    return list(zip(values.tolist(), uncertainty_of(dataset).astype(float).tolist(), strict=True))
