"""What was computed over one varied parameter, with bands and references; over two, a map."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.archive.conventions import Role, over_cases, parameter_of, with_role
from harness.compare.compared import (
    NothingToCompareError,
    conditions_of,
    stored_experience,
    stored_references,
)
from harness.pictures.convergence import refined
from harness.pictures.drawing.caption import captioned, left_out
from harness.pictures.drawing.literature import draw_experience, draw_literature, ranges_of_own
from harness.pictures.drawing.plot_parts import (
    FAILED,
    INK,
    MARKERS,
    SHADES,
    STYLED,
    CurveEnd,
    chosen,
    empty_figure,
    label_ends,
    legend_above,
    mark_failures,
    once,
    series_colour,
)
from harness.pictures.drawing.quantities import Floats, Values, axis_label
from harness.pictures.sounding import STRETCH
from harness.pictures.studied import Studied
from harness.references.cone_factors import COMPARED, NEEDED
from harness.study.compared import OwnReference

BY_COMPRESSION = f"{COMPARED}_by_compression"
"""Cone factors by su in triaxial compression."""
FINE = 400
"""Points of a literature curve."""
LEAST_VALUES = 3
"""Values of each of two parameters from which on there is a map."""
MOST_CURVES = 5
"""Curves beside a map."""
LEVELS = 7
MAP_HEIGHT = 3.6
"""Of a map, in inches."""
EDGE = 0.05
"""Of the axes: a contour's label that is nearer to their edge would be cut off, and is left out."""


@STYLED
def curve_figure(dataset: xr.Dataset) -> Figure | None:
    """What was computed over one parameter, or over two that make no map, as a series each.

    Cone factors have the envelope of the literature beside them, one alone too. The references have
    their curves where these hold for all series; otherwise each series has the envelope in its own
    colour. The stretches of a sounding are no curve: their picture joins them.
    """
    studied = Studied.of(dataset)
    if studied is None or not studied.is_combined or STRETCH in studied.varied:
        return None
    if refined(studied) or _is_map(studied) or len(studied.varied) > 2:
        return None
    if not studied.varied and studied.headline != COMPARED:
        return None
    name, other = _axis_and_series(studied)
    figure, axes = empty_figure()
    if studied.headline == COMPARED:
        draw_experience(axes, dataset)
    along = studied.varied.get(name) or Values.of(dataset, name)
    groups = studied.groups(other)
    shown = chosen(len(groups))
    ends: list[CurveEnd] = []
    shared = not any(_depends_on(dataset, one) for one in other)
    for rank, cases in enumerate(groups[place] for place in shown):
        colour = series_colour(rank, len(shown))
        ordered = cases[np.argsort(along.numbers[cases], kind="stable")]
        x, y = along.numbers[ordered], studied.computed[ordered]
        label = studied.label(cases[0], other)
        if studied.headline == COMPARED and (rank == 0 or not shared):
            ends += _literature(axes, studied, along, ordered, None if shared else colour)
        axes.errorbar(
            x,
            y,
            studied.widths(ordered),
            color=colour,
            label=label or "computed",
            ls="" if along.categories else "-",
            marker=MARKERS[rank],
            zorder=4,
        )
        mark_failures(axes, x[~np.isfinite(y)])
        _draw_exact(axes, studied, ordered, x)
        _draw_by_strength_of_bands(axes, studied, ordered, x, colour)
    along.dress(axes, room=10)
    axes.set(xlabel=axis_label(dataset, name), ylabel=axis_label(dataset, studied.headline))
    label_ends(axes, ends)
    return captioned(
        figure,
        dataset,
        studied.bars,
        ranges_of_own(dataset) if ends else "",
        left_out(len(groups) - len(shown), "series"),
        legend=axes,
    )


def _axis_and_series(studied: Studied) -> tuple[str, list[str]]:
    """The parameter along the axis, the number with most values, and those that make series."""
    if not studied.varied:
        return NEEDED[1], []
    names = studied.numbers or list(studied.varied)
    name = max(names, key=lambda it: studied.varied[it].different.size)
    return name, [other for other in studied.varied if other != name]


def _depends_on(dataset: xr.Dataset, name: str) -> bool:
    """Whether the references, the literature's or the study's own, depend on a parameter."""
    try:
        conditions = vars(conditions_of(dataset))
    except NothingToCompareError:
        return False
    own = [
        reference for reference in stored_references(dataset) if isinstance(reference, OwnReference)
    ]
    if any(parameter_of(name) in reference.names for reference in own):
        return True
    column = over_cases(dataset, name)
    quantities = [condition for key, condition in conditions.items() if key != "parameters"]
    return any(np.array_equal(over_cases(dataset, quantity), column) for quantity in quantities)


def _literature(
    axes: Axes, studied: Studied, along: Values, cases: np.ndarray, colour: str | None
) -> list[CurveEnd]:
    name, dataset = along.name, studied.dataset
    follows = [
        parameter
        for parameter in with_role(dataset, Role.PARAMETER)
        if parameter in dataset.data_vars
    ]
    # What the scene derives from a varied parameter goes along with it: it is left to be derived.
    one = studied.case(int(cases[0])).drop_vars(
        [derived for derived in follows if dataset[derived].ndim]
    )
    if along.categories:
        # A text says nothing to the literature: its values stand side by side.
        places = np.linspace(-0.5, len(along.categories) - 0.5, FINE)
        return draw_literature(axes, one.assign({name: 0.0}), name, places, colour)
    fine, index = _fine(along), over_cases(dataset, "rigidity_index")[cases]
    if "rigidity_index" not in one:  # a law has its own, which changes along the axis
        place = np.log if along.scale == "log" else np.asarray
        between = np.interp(place(fine), place(along.numbers[cases]), np.log(index))
        return draw_literature(axes, one, name, fine, colour, np.exp(between))
    return draw_literature(axes, one, name, fine, colour)


def _fine(values: Values) -> Floats:
    """Where the literature's curves are drawn: from the first value to the last."""
    low, high = values.different[[0, -1]].tolist()
    if low == high:
        low, high = (0.0, 1.0) if 0 <= low <= 1 else (low / 2, low * 2)
    space = np.geomspace if values.scale == "log" else np.linspace
    return np.union1d(space(low, high, FINE), values.different)


def _draw_exact(axes: Axes, studied: Studied, cases: np.ndarray, x: Floats) -> None:
    """Draw the exact values of the headline, of scenes that have them."""
    dataset = studied.dataset
    for name in with_role(dataset, Role.EXACT):
        belongs = dataset[name].attrs.get("exact_of") == studied.headline
        if belongs and set(dataset[name].dims) <= set(dataset["status"].dims):
            exact = over_cases(dataset, name)[cases]
            axes.plot(x, exact, ls="--", lw=1, color="0.4", label=once(axes, "exact"))


def _draw_by_strength_of_bands(
    axes: Axes, studied: Studied, cases: np.ndarray, x: Floats, colour: str
) -> None:
    """Draw the factors by su in compression, as those of experience are, of a law with several."""
    if BY_COMPRESSION not in studied.dataset or not stored_experience(studied.dataset):
        return
    factors = over_cases(studied.dataset, BY_COMPRESSION)
    if not np.allclose(factors, studied.computed, equal_nan=True):
        label = once(axes, "by su in triaxial compression")
        axes.plot(x, factors[cases], ls=":", marker="o", mfc="white", color=colour, label=label)


def _is_map(studied: Studied) -> bool:
    """Whether two numbers vary, in all combinations of their values."""
    if not studied.is_combined or len(studied.varied) != 2 or len(studied.numbers) != 2:
        return False
    table = _table(studied, studied.computed)
    # Contours need neighbours: a map with holes says less than the curves.
    full = bool(np.isfinite(table).mean() > 0.5)
    return min(table.shape) >= LEAST_VALUES and studied.computed.size == table.size and full


@STYLED
def map_figure(dataset: xr.Dataset) -> Figure | None:
    """Contours of what was computed over two parameters; beside them curves over the first."""
    studied = Studied.of(dataset)
    if studied is None or refined(studied) or not _is_map(studied):
        return None
    figure = Figure(figsize=(Figure().get_figwidth(), MAP_HEIGHT))
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    _draw_contours(figure, left, studied)
    if studied.headline == COMPARED:
        draw_experience(right, dataset)
        legend_above(figure, right)
    _draw_curves(right, studied)
    sound = np.isfinite(studied.computed).all()
    crosses = "" if sound else ", crosses did not complete"
    return captioned(
        figure,
        dataset,
        f"Left: contours; dots are computed cases{crosses}. Right: the same over one parameter.",
        studied.bars,
    )


def _across_and_up(studied: Studied) -> list[Values]:
    """The parameter along the horizontal axis, the one with more values, and the other."""
    return sorted(studied.varied.values(), key=lambda it: it.different.size, reverse=True)


def _table(studied: Studied, values: Floats) -> Floats:
    """Values of the cases over both parameters, shape [up, across]; else not a number."""
    columns, rows = _across_and_up(studied)
    table = np.full((rows.different.size, columns.different.size), np.nan)
    row = np.searchsorted(rows.different, rows.numbers)
    column = np.searchsorted(columns.different, columns.numbers)
    table[row, column] = values
    return table


def _draw_contours(figure: Figure, axes: Axes, studied: Studied) -> None:
    x, y = _across_and_up(studied)
    table = np.ma.masked_invalid(_table(studied, studied.computed))
    levels = MaxNLocator(LEVELS).tick_values(table.min(), table.max())
    filled = axes.contourf(x.different, y.different, table, levels=levels, cmap=SHADES)
    lines = axes.contour(filled, colors="white", linewidths=0.8)
    # Labels are placed on the page: the axes need their scales before.
    x.dress(axes, room=7)
    y.dress(axes, room=10, which="y")
    for label in axes.clabel(lines, fontsize=7, fmt="%g"):
        place = (axes.transData - axes.transAxes).transform(label.get_position())
        label.set_visible(bool((np.abs(place - 0.5) < 0.5 - EDGE).all()))
    sound = np.isfinite(studied.computed)
    axes.plot(x.numbers[sound], y.numbers[sound], ".", color=INK, ms=3, clip_on=False)
    if not sound.all():
        axes.plot(x.numbers[~sound], y.numbers[~sound], "x", color=FAILED, clip_on=False)
    axes.grid(visible=False)
    axes.set(xlabel=axis_label(studied.dataset, x.name), ylabel=axis_label(studied.dataset, y.name))
    bar = figure.colorbar(filled, cax=axes.inset_axes((0, 1.04, 1, 0.04)), orientation="horizontal")
    bar.ax.xaxis.set_ticks_position("top")
    bar.ax.xaxis.set_label_position("top")
    bar.set_label(axis_label(studied.dataset, studied.headline), fontsize=8)
    bar.ax.tick_params(labelsize=7)


def _draw_curves(axes: Axes, studied: Studied) -> None:
    x, y = _across_and_up(studied)
    groups = studied.groups([y.name])
    rows = chosen(len(groups), MOST_CURVES)
    ends = []
    for rank, cases in enumerate(groups[row] for row in rows):
        colour = series_colour(rank, len(rows))
        ordered = cases[np.argsort(x.numbers[cases])]
        along, computed = x.numbers[ordered], studied.computed[ordered]
        width = studied.widths(ordered)
        axes.errorbar(along, computed, width, color=colour, marker=MARKERS[rank], ms=4)
        known = np.flatnonzero(np.isfinite(computed))
        if known.size:
            label = studied.label(cases[0], [y.name])
            ends.append(CurveEnd(along[known[-1]], computed[known[-1]], label, colour))
    x.dress(axes, room=5)
    axes.set_xlabel(axis_label(studied.dataset, x.name))
    axes.set_ylabel(axis_label(studied.dataset, studied.headline))
    label_ends(axes, ends, size=7)
