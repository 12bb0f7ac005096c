"""The pictures `curve`, the result over one varied parameter, and `map`, over two.

Cone factors are shown with references of the literature and bands of experience.
"""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.archive.conventions import Role, over_cases, parameter_of, with_role
from harness.compare.compared import conditions_of, stored_experience, stored_references
from harness.pictures.convergence import refined
from harness.pictures.drawing.caption import captioned, left_out
from harness.pictures.drawing.plot_parts import (
    FAILED,
    INK,
    SHADES,
    STYLED,
    CurveEnd,
    end_of,
    label_ends,
    legend_above,
    once,
    panels,
    series,
)
from harness.pictures.drawing.quantities import Floats, Values, axis_label, plain
from harness.pictures.sounding import STRETCH
from harness.pictures.studied import Studied
from harness.references import cone_factors as literature
from harness.references.cone_factors import COMPARED, NEEDED, Conditions, ConeFactor, Quantity
from harness.references.experience import Factor
from harness.study.compared import OwnReference

BY_COMPRESSION = f"{COMPARED}_by_compression"
"""Cone factors by su in triaxial compression."""
MOST_CURVES = 5
"""Largest number of curves beside a map."""
HATCHES = ("///", "\\\\\\", "...", "---")
"""Hatches of bands, used in turn, so that overlapping bands can be told apart."""
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C564B", "#666666")
"""Colours of references, after Okabe and Ito, which colour-blind readers can tell apart."""
FINE = 400
"""Points of a curve of the literature."""


@STYLED
def curve_figure(dataset: xr.Dataset) -> Figure | None:
    """The headline over one parameter; a second one that gives no map makes several series.

    Cone factors are shown with the envelope of the literature if the scene has the parameters that
    it depends on, also for a single case. Curves of references are drawn if they are the same for
    all series; otherwise each series gets the envelope in its colour. Stretches of a sounding have
    no curve, because the picture `sounding` joins them.
    """
    studied = Studied.of(dataset)
    if studied is None or not studied.is_combined or STRETCH in studied.varied:
        return None
    if refined(studied) or _is_map(studied) or len(studied.varied) > 2:
        return None
    has_literature = studied.headline == COMPARED and all(name in dataset for name in NEEDED)
    if not (studied.varied or has_literature):
        return None
    name = max(
        studied.numbers or studied.varied,
        key=lambda it: studied.varied[it].different.size,
        default=NEEDED[1],
    )
    along = studied.varied.get(name) or Values.of(dataset, name)
    figure, (axes,) = panels()
    if studied.headline == COMPARED:
        draw_experience(axes, dataset)
    groups = studied.groups(name, along.numbers)
    shown = series(groups)
    ends: list[CurveEnd] = []
    others = [other for other in studied.varied if other != name]
    shared = has_literature and not any(_depends_on(dataset, other) for other in others)
    for (cases, label), line in shown:
        x = along.numbers[cases]
        if has_literature and (line.place == 0 or not shared):
            ends += _draw_literature(axes, studied, along, cases, None if shared else line.colour)
        style = {**line.style, "ls": "" if along.categories else "-", "zorder": 4}
        studied.draw(axes, along.numbers, cases, label=label or "computed", **style)
        _draw_exact(axes, studied, cases, x, are_texts=bool(along.categories))
        _draw_by_strength_of_bands(axes, studied, cases, x, line.colour)
    along.dress(axes, room=10)
    axes.set(xlabel=axis_label(dataset, name), ylabel=axis_label(dataset, studied.headline))
    label_ends(axes, ends)
    return captioned(
        figure,
        dataset,
        studied.bars,
        _ranges_of_own(dataset) if ends else "",
        left_out(len(groups) - len(shown), "series"),
        legend=axes,
    )


def _draw_exact(
    axes: Axes, studied: Studied, cases: np.ndarray, x: Floats, *, are_texts: bool
) -> None:
    """Draw exact values: a line over numbers, single marks over texts."""
    dataset = studied.dataset
    style: dict[str, Any] = {"ls": "", "marker": "_", "ms": 20} if are_texts else {"ls": "--"}
    for name in with_role(dataset, Role.EXACT):
        belongs = dataset[name].attrs.get("exact_of") == studied.headline
        if belongs and set(dataset[name].dims) <= set(dataset["status"].dims):
            exact = over_cases(dataset, name)[cases]
            axes.plot(x, exact, **style, lw=1, color="0.4", label=once(axes, "exact"))


def _draw_by_strength_of_bands(
    axes: Axes, studied: Studied, cases: np.ndarray, x: Floats, colour: str
) -> None:
    """Draw factors by su in compression beside bands of experience, which are by that su.

    Nothing is drawn if the headline is by this su already.
    """
    if BY_COMPRESSION not in studied.dataset or not stored_experience(studied.dataset):
        return
    factors = over_cases(studied.dataset, BY_COMPRESSION)
    if not np.allclose(factors, studied.computed, equal_nan=True):
        label = once(axes, "by su in triaxial compression")
        axes.plot(x, factors[cases], ls=":", marker="o", mfc="white", color=colour, label=label)


def _table(studied: Studied) -> tuple[Values, Values, Floats]:
    """The parameters of a map, that with more values first, and the headline [second, first]."""
    x, y = sorted(studied.varied.values(), key=lambda it: it.different.size, reverse=True)
    table = np.full((y.different.size, x.different.size), np.nan)
    row, column = (np.searchsorted(it.different, it.numbers) for it in (y, x))
    table[row, column] = studied.computed
    return x, y, table


def _is_map(studied: Studied) -> bool:
    """Whether two numbers vary in all combinations, with at least three values each."""
    if not studied.is_combined or len(studied.varied) != 2 or len(studied.numbers) != 2:
        return False
    table = _table(studied)[2]
    # Contours need neighbours; with many failed cases curves show more than a map.
    full = bool(np.isfinite(table).mean() > 0.5)
    return min(table.shape) >= 3 and studied.computed.size == table.size and full


@STYLED
def map_figure(dataset: xr.Dataset) -> Figure | None:
    """Contours of the headline over two parameters, and beside them curves over the first."""
    studied = Studied.of(dataset)
    if studied is None or refined(studied) or not _is_map(studied):
        return None
    figure, (left, right) = panels(2, height=3.6, width_ratios=(1.25, 1))
    x, y, table = _table(studied)
    _draw_contours(left, studied, x, y, np.ma.masked_invalid(table))
    if studied.headline == COMPARED:
        draw_experience(right, dataset)
        legend_above(figure, right)
    _draw_curves(right, studied, x)
    sound = np.isfinite(studied.computed).all()
    crosses = "" if sound else ", crosses did not complete"
    return captioned(
        figure,
        dataset,
        f"Left: contours; dots are computed cases{crosses}. Right: the same over one parameter.",
        studied.bars,
    )


def _draw_contours(axes: Axes, studied: Studied, x: Values, y: Values, table: Floats) -> None:
    levels: Sequence[float] = MaxNLocator(7).tick_values(table.min(), table.max())
    filled = axes.contourf(x.different, y.different, table, levels=levels, cmap=SHADES)
    lines = axes.contour(filled, colors="white", linewidths=0.8)
    # The axes need their scales before contour labels are placed.
    x.dress(axes, room=7)
    y.dress(axes, room=10, which="y")
    for label in axes.clabel(lines, fontsize=7, fmt="%g"):  # at the edge it would be cut off
        place = (axes.transData - axes.transAxes).transform(label.get_position())
        label.set_visible(bool((np.abs(place - 0.5) < 0.45).all()))
    sound = np.isfinite(studied.computed)
    axes.plot(x.numbers[sound], y.numbers[sound], ".", color=INK, ms=3, clip_on=False)
    if not sound.all():
        axes.plot(x.numbers[~sound], y.numbers[~sound], "x", color=FAILED, clip_on=False)
    axes.grid(visible=False)
    axes.set(xlabel=axis_label(studied.dataset, x.name), ylabel=axis_label(studied.dataset, y.name))
    above = axes.inset_axes((0, 1.04, 1, 0.04))
    bar = axes.figure.colorbar(filled, cax=above, orientation="horizontal", ticklocation="top")
    bar.set_label(axis_label(studied.dataset, studied.headline), fontsize=8)
    bar.ax.tick_params(labelsize=7)


def _draw_curves(axes: Axes, studied: Studied, x: Values) -> None:
    ends: list[CurveEnd] = []
    for (cases, label), line in series(studied.groups(x.name, x.numbers), MOST_CURVES):
        along, computed = x.numbers[cases], studied.computed[cases]
        axes.errorbar(along, computed, studied.widths(cases), **line.style, ms=4)
        ends += end_of(along, computed, label, line.colour)
    x.dress(axes, room=5)
    label, headline = (axis_label(studied.dataset, it) for it in (x.name, studied.headline))
    axes.set(xlabel=label, ylabel=headline)
    label_ends(axes, ends, size=7)


def draw_experience(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the bands of experience of a result over the whole width."""
    entries = [entry for entry in stored_experience(dataset) if entry.factor is Factor.RESISTANCE]
    for entry, hatch in zip(entries, itertools.cycle(HATCHES), strict=False):
        axes.axhspan(
            *entry.bounds,
            facecolor="none",
            edgecolor="#8C8C8C",
            hatch=hatch,
            linewidth=0,
            alpha=0.5,
            zorder=0.5,
            label=plain(
                f"experience, {entry.label}: {entry.band}, su {entry.strength.partition(',')[0]}"
            ),
        )


def _draw_literature(
    axes: Axes, studied: Studied, along: Values, cases: np.ndarray, colour: str | None
) -> list[CurveEnd]:
    """Draw envelope and references for a series of cases; return the labelled ends of the curves.

    A curve is solid where its reference is valid, and dashed elsewhere. If a colour is given, only
    the envelope is drawn, in this colour.
    """
    x, conditions = _over(studied, along, cases)

    def over(value: Quantity) -> np.ndarray:
        return np.broadcast_to(np.asarray(value), x.shape)

    lower, upper = (over(bound) for bound in literature.envelope(conditions))
    inside = over(literature.envelope_applies(conditions))
    if inside.any():
        own = colour or "0.6"
        band = axes.fill_between(x, lower, upper, inside, color=own, alpha=0.2, lw=0)
        band.set_label(once(axes, "envelope of the literature (no confidence interval)"))
        # Where the references are valid at a single value, such as an apex angle of 60 degrees, the
        # band has no width.
        padded = np.pad(inside, 1)
        alone = inside & ~padded[:-2] & ~padded[2:]
        if alone.any():
            axes.vlines(x[alone], lower[alone], upper[alone], color=own, alpha=0.4, lw=5)
    ends: list[CurveEnd] = []
    references = stored_references(studied.dataset) if colour is None else ()
    for reference, own in zip(references, _colours(references), strict=True):
        value, applies = over(reference.evaluate(conditions)), over(reference.applies(conditions))
        axes.plot(x, np.where(applies, value, np.nan), color=own)
        if not applies[np.isfinite(value)].all():
            label = once(axes, "outside its validity")
            axes.plot(x, value, color=own, lw=0.9, ls=(0, (4, 3)), alpha=0.7, label=label)
        ends += end_of(x, value, plain(reference.label), own)
    return ends


def _over(studied: Studied, along: Values, cases: np.ndarray) -> tuple[Floats, Conditions]:
    """Positions along an axis from its first to its last value, and the conditions there."""
    name, dataset = along.name, studied.dataset
    # Parameters that the scene derives from the varied one are dropped, so that they follow it.
    parameters = [it for it in with_role(dataset, Role.PARAMETER) if it in dataset.data_vars]
    follows = [it for it in parameters if dataset[it].ndim]
    places = np.unravel_index(cases[0], dataset["status"].shape)
    first = dict(zip(dataset["status"].dims, map(int, places), strict=True))
    one = dataset.isel(first).drop_vars([*follows, name])
    if along.categories:
        # References do not depend on texts, so their values are constant along this axis.
        x, attributes = np.linspace(-0.5, len(along.categories) - 0.5, FINE), {}
    else:
        x, attributes = _fine(along), dataset[name].attrs
    one = one.assign_coords({name: xr.Variable(name, x, attributes)})
    if "rigidity_index" not in one:  # a law derives it, and it changes along the axis
        place = np.log if along.scale == "log" else np.asarray
        index = np.log(over_cases(dataset, "rigidity_index")[cases])
        between = np.interp(place(x), place(along.numbers[cases]), index)
        one = one.assign_coords(rigidity_index=(name, np.exp(between)))
    return x, conditions_of(one)


def _fine(values: Values) -> Floats:
    """Positions at which curves of the literature are drawn, from the first value to the last."""
    low, high = values.different[[0, -1]].tolist()
    if low == high:
        low, high = (0.0, 1.0) if 0 <= low <= 1 else (low / 2, low * 2)
    space = np.geomspace if values.scale == "log" else np.linspace
    return np.union1d(space(low, high, FINE), values.different)


def _colours(references: Sequence[ConeFactor]) -> list[str]:
    """Colours of references. Those that ship have the same in all pictures; others get the rest."""
    ids = [reference.id for reference in literature.CONE_FACTORS]
    shipped = dict(zip(ids, itertools.cycle(COLOURS), strict=False))
    taken = {shipped.get(reference.id) for reference in references}
    left = itertools.cycle([colour for colour in COLOURS if colour not in taken] or COLOURS)
    return [shipped.get(reference.id) or next(left) for reference in references]


def _depends_on(dataset: xr.Dataset, name: str) -> bool:
    """Whether any reference depends on a parameter."""
    if any(parameter_of(name) in reference.names for reference in _own(dataset)):
        return True
    column, conditions = over_cases(dataset, name), vars(conditions_of(dataset))
    quantities = [condition for key, condition in conditions.items() if key != "parameters"]
    return any(np.array_equal(over_cases(dataset, quantity), column) for quantity in quantities)


def _own(dataset: xr.Dataset) -> list[OwnReference]:
    return [it for it in stored_references(dataset) if isinstance(it, OwnReference)]


def _ranges_of_own(dataset: xr.Dataset) -> str:
    """Sentences on the ranges in which the study's own references are drawn."""
    return " ".join(
        plain(f"{reference.label} is drawn within its range: {reference.validity}.")
        for reference in _own(dataset)
        if reference.ranges
    )
