"""The pictures that a result declares: its curves by case, in the units of readers.

A scene says of a curve where it is drawn (`mpm_warp.Drawn`). Pieces of a curve that are cases of
their own are joined: where two overlap the curve is their mean, and half of their difference, as a
root mean square over the overlap, is added in squares to its half width ``<curve>_uncertainty``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import CASE, by_case, case_dims, over_cases, spoken
from harness.pictures.drawing.plot_parts import runs
from harness.pictures.drawing.quantities import Floats, named, readable, symbol, unit_of
from mpm_warp.results import Drawn

HALF_WIDTH = "_uncertainty"
"""End of the name of a variable that holds the half width of another one."""


@dataclass(frozen=True)
class Curve:
    """One variable of a picture, with the lines of each case."""

    name: str  # in words
    place: Drawn
    x: Floats  # places on the other axis, [case, sample]; NaN where a case has no such sample
    values: Floats  # shape [case, sample], or [case, line, sample] with a further dim
    label: str  # of the axis of values
    over: str  # label of the other axis
    along: str  # the further dim in words; "" without one
    description: str  # how it was found; "" if nothing is said

    @property
    def ends(self) -> dict[int, float]:
        """The last value of each case that has one."""
        known = {case: row[np.isfinite(row)] for case, row in enumerate(self.values)}
        return {case: float(row[-1]) for case, row in known.items() if row.size}

    @property
    def described(self) -> str:
        """A sentence on how it was found, if something is said of it."""
        return (
            f"{self.name[:1].upper()}{self.name[1:]} ({self.description})."
            if self.description
            else ""
        )

    @property
    def changes_most(self) -> int:
        """The case whose size changes most along the further dim, from its first to its last."""
        change = {}
        for case in self.ends:
            sizes = [np.abs(line[np.isfinite(line)]).mean() for line in self.lines(case)]
            change[case] = abs(sizes[-1] / sizes[0] - 1.0)
        return max(change, key=lambda case: change[case])

    def lines(self, case: int) -> list[Floats]:
        """The lines of a case that have a value, along the further dim if there is one."""
        return [line for line in np.atleast_2d(self.values[case]) if np.isfinite(line).any()]


@dataclass(frozen=True)
class Picture:
    """A picture that a result declares."""

    cases: np.ndarray  # the case of the result of each line; of joined ones the first
    panels: Sequence[Sequence[Curve]]

    @property
    def curves(self) -> list[Curve]:
        """The curves of all panels; those with a line per case first."""
        every = (curve for panel in self.panels for curve in panel)
        return sorted(every, key=lambda curve: curve.values.ndim)


def declared(dataset: xr.Dataset) -> dict[str, list[str]]:
    """By name of a picture: its curves in the order of panels."""
    found: dict[str, list[str]] = {}
    for name, place in sorted(_places(dataset).items(), key=lambda it: it[1].panel):
        found.setdefault(place.picture, []).append(name)
    return found


def pieces_of(dataset: xr.Dataset) -> set[str]:
    """The varied parameters whose cases are pieces of one curve."""
    return {it.joined_over for it in _places(dataset).values()}.intersection(case_dims(dataset))


def picture_of(dataset: xr.Dataset, names: Sequence[str]) -> Picture:
    """The picture of these curves."""
    every = [str(name) for name, it in dataset.data_vars.items() if _is_curve(dataset, it)]
    cases = by_case(dataset[["status", *every]]).drop_vars("status")
    for parameter in pieces_of(dataset):
        cases = joined(dataset, cases, parameter)
    panels: dict[int, list[Curve]] = {}
    for name in names:
        curve = _curve(dataset, cases, name)
        panels.setdefault(curve.place.panel, []).append(curve)
    return Picture(cases[CASE].values, list(panels.values()))


def joined(dataset: xr.Dataset, cases: xr.Dataset, parameter: str) -> xr.Dataset:
    """Curves over the dim `case`, with the cases that differ only in a parameter as one."""
    shape, dims = dataset["status"].shape, case_dims(dataset)
    numbers = np.arange(dataset["status"].size).reshape(shape)
    groups = np.moveaxis(numbers, dims.index(parameter), -1).reshape(
        -1, shape[dims.index(parameter)]
    )
    return xr.concat([_as_one(cases.isel({CASE: group})) for group in groups], dim=CASE)


def _as_one(pieces: xr.Dataset) -> xr.Dataset:
    whole = pieces.mean(CASE, keep_attrs=True)
    for name in map(str, pieces):
        if (half_width := f"{name}{HALF_WIDTH}") in pieces:
            values = pieces[name]
            half = 0.5 * (values.max(CASE) - values.min(CASE)).values
            difference = np.zeros(half.shape)
            # All samples of an overlap have its root mean square: single ones contain noise.
            for overlap in runs(values.notnull().sum(CASE).values > 1):
                difference[overlap] = np.sqrt(np.mean(half[overlap] ** 2))
            whole[half_width] = np.hypot(whole[half_width], difference)
    return whole.assign_coords({CASE: int(pieces[CASE][0])})


def _places(dataset: xr.Dataset) -> dict[str, Drawn]:
    """Where the curves of a result are drawn that say so."""
    found = {}
    for name, variable in dataset.data_vars.items():
        if (place := Drawn.of(variable)) is not None and _is_curve(dataset, variable):
            others = filter(None, (place.over, place.divided_by))
            if all(other in dataset for other in others):  # a file lacks what no case has
                found[str(name)] = place
    return found


def _is_curve(dataset: xr.Dataset, variable: xr.DataArray) -> bool:
    return set(dataset["status"].dims) < set(variable.dims) and variable.dtype.kind == "f"


def _curve(dataset: xr.Dataset, cases: xr.Dataset, name: str) -> Curve:
    place, own = Drawn.of(dataset[name]), cases[name]
    assert place is not None, name
    over = place.over or str(own.dims[-1])
    factor, label = _axis(dataset, name)
    values = factor * own.values
    if place.divided_by:
        share, label = _divided(dataset, name, place.divided_by)
        values = share * own.values / _divisor(dataset, cases, place.divided_by, own.ndim)
    of_other, label_of_other = _axis(dataset, over)
    samples = own.dims[-1]
    # A case may lack samples that others have; a value that is missing among its own is a gap.
    of_samples = (it.values for it in cases.data_vars.values() if it.dims[-1] == samples)
    known = [np.isfinite(it).any(axis=tuple(range(1, it.ndim - 1))) for it in of_samples]
    present = np.any(known, axis=0)
    return Curve(
        name=named(dataset, name),
        place=place,
        x=np.where(present, of_other * cases[over].values, np.nan),
        values=values,
        label=label,
        over=label_of_other,
        along=" ".join(spoken(dim) for dim in own.dims[1:-1]),
        description=str(own.attrs.get("description", "")),
    )


def _axis(dataset: xr.Dataset, name: str) -> tuple[float, str]:
    """The factor of a variable in the unit of readers, and its label."""
    factor, unit = readable(unit_of(dataset, name))
    return factor, f"{named(dataset, name)} [{unit or '-'}]"


def _divided(dataset: xr.Dataset, name: str, by: str) -> tuple[float, str]:
    """The factor and the label of a quotient, which is in percent of a curve of the same unit."""
    own, other = unit_of(dataset, name), unit_of(dataset, by)
    divisor = symbol(by) or named(dataset, by)
    if own == other and _is_curve(dataset, dataset[by]):
        of_what = "" if name == f"{by}{HALF_WIDTH}" else f" of {divisor}"
        return 100.0, f"{named(dataset, name)} [%{of_what}]"
    unit = "-" if own == other else f"{own or '1'}/({other or '1'})"
    return 1.0, f"{named(dataset, name)} / {divisor} [{unit}]"


def _divisor(dataset: xr.Dataset, cases: xr.Dataset, name: str, ndim: int) -> Floats:
    """What a curve is divided by: another one, or a scalar of each case."""
    if name in cases.data_vars:
        return np.asarray(cases[name].values)
    scalars = over_cases(dataset, name)[cases[CASE].values].astype(float)
    return np.asarray(scalars.reshape(-1, *[1] * (ndim - 1)))
