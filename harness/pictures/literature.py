"""The literature beside cone factors: curves and envelope of references, bands of experience."""

import itertools
from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from harness.archive.conventions import Role, parameter_of, with_role
from harness.compare.compared import conditions_of, stored_experience, stored_references
from harness.pictures.drawing.plot_parts import CurveEnd, end_of, once
from harness.pictures.drawing.quantities import MOST_LETTERS, Floats, Values, plain, shortened
from harness.pictures.drawing.style import BAND, COLOURS, FAINT, GREY, HATCHES, LARGE, OTHER_DASHES
from harness.pictures.studied import Studied
from harness.references import registry
from harness.references.band import Factor
from harness.references.reference import COMPARED, NEEDED, SYMBOL_OF, Reference
from harness.references.strength import Conditions, Quantity
from mpm_warp.materials.clay_law import PARAMETER

FINE = 400
"""Points of a curve of the literature."""


def draw_experience(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the bands of experience of a result over the whole width."""
    entries = [entry for entry in stored_experience(dataset) if entry.factor is Factor.RESISTANCE]
    for entry, hatch in zip(entries, itertools.cycle(HATCHES), strict=False):
        axes.axhspan(
            *entry.bounds,
            facecolor="none",
            edgecolor=GREY,
            hatch=hatch,
            zorder=0.5,
            **BAND,
            label=plain(
                f"experience, {entry.label}: {entry.band}, su {entry.strength.partition(',')[0]}"
            ),
        )


class _OverAxis(NamedTuple):
    """What the literature says along an axis, each array of shape [position]."""

    x: Floats
    envelope: np.ndarray  # lower and upper bound, and whether it holds, shape [3, position]
    # of each reference, whether it is valid, and has the criterion, shape [reference, 3, position]
    values: np.ndarray

    def is_as(self, other: Self) -> bool:
        """Whether another says the same."""
        pairs = zip(self, other, strict=True)
        return all(np.array_equal(one, two, equal_nan=True) for one, two in pairs)


def has_literature(studied: Studied) -> bool:
    """Whether the scene has the parameters that cone factors of the literature depend on."""
    return studied.headline == COMPARED and all(name in studied.dataset for name in NEEDED)


def draw_literature(
    axes: Axes, studied: Studied, along: Values, shown: Sequence[tuple[np.ndarray, str]]
) -> list[CurveEnd]:
    """Draw envelope and references beside series, each given by its cases and its colour.

    If they are the same for all series, each reference is a curve with a colour and a label: solid
    where it is valid and has the criterion of the case, dashed elsewhere; the ends of these curves
    are returned. Otherwise each series has its own envelope and references, in its colour, and pale
    where they are not valid or of another criterion.
    """
    references = stored_references(studied.dataset)
    found = [_over_axis(studied, along, cases, references) for cases, _ in shown]
    if any(not it.is_as(found[0]) for it in found[1:]):
        for here, (_, colour) in zip(found, shown, strict=True):
            _draw_envelope(axes, here, colour)
            for style, (value, applies, _) in zip(_styles(references), here.values, strict=True):
                for part, alpha in ((applies == 1.0, 1.0), (applies == 0.0, FAINT)):
                    if np.isfinite(value[part]).any():
                        y = np.where(part, value, np.nan)
                        axes.plot(here.x, y, color=colour, alpha=alpha, **style)
        alike = np.any([here.values[:, 2].any(axis=-1) for here in found], axis=0)
        for style, *named in zip(_styles(references), references, alike, strict=True):
            axes.plot([], [], color=GREY, **style, label=_named(*named))
        return []
    ends: list[CurveEnd] = []
    for here in found[:1]:
        _draw_envelope(axes, here, GREY)
        drawn = zip(references, here.values, colours_of(references), strict=True)
        for reference, (value, applies, is_alike), own in drawn:
            axes.plot(here.x, np.where(applies, value, np.nan), color=own, **_marks(reference))
            if not applies[np.isfinite(value)].all():
                style = {"ls": OTHER_DASHES[0], **_marks(reference)}
                label = once(axes, "outside its validity or criterion")
                axes.plot(here.x, value, color=own, label=label, **style)
            ends += end_of(here.x, value, _named(reference, bool(is_alike.any())), own)
    return ends


def _named(reference: Reference, has_criterion: bool) -> str:
    """The label of a reference, with its yield criterion if that is not the one of the cases."""
    other = "" if has_criterion else f" ({reference.criterion_name})"
    return plain(f"{shortened(reference.label, MOST_LETTERS)}{other}")


def _styles(references: Sequence[Reference]) -> list[dict[str, Any]]:
    """Dashes of references beside several series; points have marks instead."""
    pairs = zip(references, itertools.cycle(OTHER_DASHES), strict=False)
    return [_marks(it) or {"ls": dashes} for it, dashes in pairs]


def _marks(reference: Reference) -> dict[str, Any]:
    """The style of points, which have no line between them: wider than the marks of cases."""
    return {"ls": "", "marker": "D", "ms": LARGE, "mfc": "none"} if reference.points else {}


def _draw_envelope(axes: Axes, here: _OverAxis, colour: str) -> None:
    lower, upper, holds = here.envelope
    inside = holds.astype(bool)
    if not inside.any():
        return
    band = axes.fill_between(here.x, lower, upper, inside, color=colour, **BAND)
    band.set_label(once(axes, "envelope of the literature (no confidence interval)"))
    # Where the references are valid at a single value, such as an apex angle of 60 degrees, the
    # band has no width.
    padded = np.pad(inside, 1)
    alone = inside & ~padded[:-2] & ~padded[2:]
    if alone.any():
        axes.vlines(here.x[alone], lower[alone], upper[alone], color=colour, alpha=FAINT, lw=LARGE)


def _over_axis(
    studied: Studied, along: Values, cases: np.ndarray, references: Sequence[Reference]
) -> _OverAxis:
    """What the literature says along an axis, from its first to its last value, beside cases."""
    x, conditions = _conditions_over(studied, along, cases)

    def over(*quantities: Quantity) -> np.ndarray:
        return np.array([np.broadcast_to(np.asarray(it, float), x.shape) for it in quantities])

    envelope = over(*registry.envelope(conditions), registry.envelope_applies(conditions))
    values = [
        over(it.evaluate(conditions), it.applies(conditions), it.has_criterion(conditions))
        for it in references
    ]
    return _OverAxis(x, envelope, np.reshape(values, (len(references), 3, x.size)))


def _conditions_over(
    studied: Studied, along: Values, cases: np.ndarray
) -> tuple[Floats, Conditions]:
    """Positions along an axis, and the conditions there; `cases` differ in what it shows.

    Between cases, parameters that follow the one of the axis are interpolated.
    """
    name, dataset = along.name, studied.dataset
    if along.categories:
        x, attributes = np.linspace(-0.5, len(along.categories) - 0.5, FINE), {}
    else:
        x, attributes = _with_points(_fine(along), dataset, name), dataset[name].attrs
    following = {
        it: values
        for it in with_role(dataset, Role.PARAMETER)
        if it != name
        and not (values := Values.of(dataset, it).at(cases)).categories
        and values.different.size > 1
    }
    places = np.unravel_index(cases[0], dataset["status"].shape)
    first = dict(zip(dataset["status"].dims, map(int, places), strict=True))
    one = dataset.isel(first).drop_vars([*following, name])
    at = x
    if along.categories and parameter_of(name) == PARAMETER:  # references have a criterion
        nearest = np.rint(x).astype(int).clip(0, len(along.categories) - 1)
        at = np.array(along.categories)[nearest]
    one = one.assign_coords({name: xr.Variable(name, at, attributes)})
    for it, values in following.items():
        between = _interpolated(x, along, along.numbers[cases], values)
        one = one.assign_coords({it: (name, between, dataset[it].attrs)})
    return x, conditions_of(one)


def _interpolated(x: Floats, along: Values, at: Floats, values: Values) -> Floats:
    """Values of the cases at ascending positions `at`, at positions `x`; as their axes are."""
    between = np.interp(along.on_axis(x), along.on_axis(at), values.on_axis(values.numbers))
    return np.asarray(np.exp(between) if values.scale == "log" else between)


def _with_points(x: Floats, dataset: xr.Dataset, name: str) -> Floats:
    """Positions with those of points of references between them."""
    names = parameter_of(name), SYMBOL_OF.get(name, "")
    columns = (it.points.get(own, ()) for it in stored_references(dataset) for own in names)
    points = np.array([*itertools.chain(*columns)], dtype=float)
    return np.union1d(x, points[(points >= x[0]) & (points <= x[-1])])


def _fine(values: Values) -> Floats:
    """Positions at which curves of the literature are drawn, from the first value to the last."""
    low, high = values.different[[0, -1]].tolist()
    if low == high:
        low, high = (0.0, 1.0) if 0 <= low <= 1 else (low / 2, low * 2)
    space = np.geomspace if values.scale == "log" else np.linspace
    return np.union1d(space(low, high, FINE), values.different)


def colours_of(references: Sequence[Reference]) -> list[str]:
    """Colours of references. Those that ship have the same in all pictures; others get the rest."""
    shipped = dict(zip(registry.REFERENCES, itertools.cycle(COLOURS), strict=False))
    taken = {shipped.get(reference.id) for reference in references}
    left = itertools.cycle([colour for colour in COLOURS if colour not in taken] or COLOURS)
    return [shipped.get(reference.id) or next(left) for reference in references]


def ranges_of_own(dataset: xr.Dataset) -> str:
    """Sentences on the ranges in which references are drawn that have no value outside."""
    return " ".join(
        plain(shortened(f"{reference.label} is drawn within its range: {reference.validity}.", 200))
        for reference in stored_references(dataset)
        if reference.range and not reference.extrapolates
    )
