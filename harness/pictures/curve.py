"""What was computed over one varied parameter, with bands and references; over two, a map."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.archive.conventions import Role, over_cases, with_role
from harness.compare.compared import stored_experience
from harness.pictures.convergence import refined
from harness.pictures.drawing.caption import captioned, left_out
from harness.pictures.drawing.plot_parts import (
    FAILED,
    INK,
    SHADES,
    STYLED,
    CurveEnd,
    label_ends,
    legend_above,
    mark_failures,
    once,
    panels,
    series,
)
from harness.pictures.drawing.quantities import Floats, Values, axis_label
from harness.pictures.literature import depends_on, draw_experience, draw_literature, ranges_of_own
from harness.pictures.sounding import STRETCH
from harness.pictures.studied import Studied
from harness.references.cone_factors import COMPARED, NEEDED

BY_COMPRESSION = f"{COMPARED}_by_compression"
"""Cone factors by su in triaxial compression."""
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
    has_literature = studied.headline == COMPARED
    if not (studied.varied or has_literature):
        return None
    name = max(
        studied.numbers or studied.varied,
        key=lambda it: studied.varied[it].different.size,
        default=NEEDED[1],
    )
    along = studied.varied.get(name) or Values.of(dataset, name)
    other = [parameter for parameter in studied.varied if parameter != name]
    figure, (axes,) = panels()
    if has_literature:
        draw_experience(axes, dataset)
    groups = studied.groups(other, along.numbers)
    shown = series(len(groups))
    ends: list[CurveEnd] = []
    shared = not any(depends_on(dataset, one) for one in other)
    for line in shown:
        cases = groups[line.place]
        x, y = along.numbers[cases], studied.computed[cases]
        if has_literature and (line is shown[0] or not shared):
            ends += draw_literature(axes, studied, along, cases, None if shared else line.colour)
        axes.errorbar(
            x,
            y,
            studied.widths(cases),
            color=line.colour,
            label=studied.label(cases[0], other) or "computed",
            ls="" if along.categories else "-",
            marker=line.marker,
            zorder=4,
        )
        mark_failures(axes, x[~np.isfinite(y)])
        _draw_exact(axes, studied, cases, x)
        _draw_by_strength_of_bands(axes, studied, cases, x, line.colour)
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


def _across_and_up(studied: Studied) -> list[Values]:
    """The parameter along the horizontal axis of a map, the one with more values; the other."""
    return sorted(studied.varied.values(), key=lambda it: it.different.size, reverse=True)


def _table(studied: Studied) -> Floats:
    """What was computed over both parameters of a map, shape [up, across]; else not a number."""
    across, up = _across_and_up(studied)
    table = np.full((up.different.size, across.different.size), np.nan)
    row, column = (np.searchsorted(it.different, it.numbers) for it in (up, across))
    table[row, column] = studied.computed
    return table


def _is_map(studied: Studied) -> bool:
    """Whether two numbers vary, in all combinations of their values."""
    if not studied.is_combined or len(studied.varied) != 2 or len(studied.numbers) != 2:
        return False
    table = _table(studied)
    # Contours need neighbours: a map with holes says less than the curves.
    full = bool(np.isfinite(table).mean() > 0.5)
    return min(table.shape) >= LEAST_VALUES and studied.computed.size == table.size and full


@STYLED
def map_figure(dataset: xr.Dataset) -> Figure | None:
    """Contours of what was computed over two parameters; beside them curves over the first."""
    studied = Studied.of(dataset)
    if studied is None or refined(studied) or not _is_map(studied):
        return None
    figure, (left, right) = panels(2, MAP_HEIGHT, width_ratios=(1.25, 1))
    x, y = _across_and_up(studied)
    _draw_contours(left, studied, x, y)
    if studied.headline == COMPARED:
        draw_experience(right, dataset)
        legend_above(figure, right)
    _draw_curves(right, studied, x, y)
    sound = np.isfinite(studied.computed).all()
    crosses = "" if sound else ", crosses did not complete"
    return captioned(
        figure,
        dataset,
        f"Left: contours; dots are computed cases{crosses}. Right: the same over one parameter.",
        studied.bars,
    )


def _draw_contours(axes: Axes, studied: Studied, x: Values, y: Values) -> None:
    table = np.ma.masked_invalid(_table(studied))
    levels: Sequence[float] = MaxNLocator(LEVELS).tick_values(table.min(), table.max())
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
    place_of_bar = axes.inset_axes((0, 1.04, 1, 0.04))
    bar = axes.figure.colorbar(
        filled, cax=place_of_bar, orientation="horizontal", ticklocation="top"
    )
    bar.set_label(axis_label(studied.dataset, studied.headline), fontsize=8)
    bar.ax.tick_params(labelsize=7)


def _draw_curves(axes: Axes, studied: Studied, x: Values, y: Values) -> None:
    groups = studied.groups([y.name], x.numbers)
    ends = []
    for place, colour, marker, _ in series(len(groups), MOST_CURVES):
        cases = groups[place]
        along, computed = x.numbers[cases], studied.computed[cases]
        axes.errorbar(along, computed, studied.widths(cases), color=colour, marker=marker, ms=4)
        known = np.flatnonzero(np.isfinite(computed))
        if known.size:
            label = studied.label(cases[0], [y.name])
            ends.append(CurveEnd(along[known[-1]], computed[known[-1]], label, colour))
    x.dress(axes, room=5)
    axes.set_xlabel(axis_label(studied.dataset, x.name))
    axes.set_ylabel(axis_label(studied.dataset, studied.headline))
    label_ends(axes, ends, size=7)
