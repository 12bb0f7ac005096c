"""The picture `map`: contours of the result over two varied parameters, and curves over one."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.pictures.convergence import refined
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import (
    FAILED,
    INK,
    SHADES,
    STYLED,
    CurveEnd,
    end_of,
    label_ends,
    legend_above,
    panels,
    series,
)
from harness.pictures.drawing.quantities import Floats, Values, axis_label
from harness.pictures.literature import (
    draw_experience,
    draw_literature,
    has_literature,
    ranges_of_own,
)
from harness.pictures.studied import Studied
from harness.references.reference import COMPARED

MOST_CURVES = 5
"""Largest number of curves beside a map."""


def _table(studied: Studied) -> tuple[Values, Values, Floats]:
    """The parameters of a map, that with more values first, and the headline [second, first]."""
    x, y = sorted(studied.varied.values(), key=lambda it: it.different.size, reverse=True)
    table = np.full((y.different.size, x.different.size), np.nan)
    row, column = (np.searchsorted(it.different, it.numbers) for it in (y, x))
    table[row, column] = studied.computed
    return x, y, table


def is_map(studied: Studied) -> bool:
    """Whether two numbers vary in all combinations, with at least three values each."""
    if not studied.is_combined or len(studied.varied) != 2 or len(studied.numbers) != 2:
        return False
    table = _table(studied)[2]
    # Contours need neighbours; with many failed cases curves show more than a map.
    full = bool(np.isfinite(table).mean() > 0.5)
    return min(table.shape) >= 3 and studied.computed.size == table.size and full


@STYLED
def map_figure(dataset: xr.Dataset) -> Figure | None:
    """Contours of the headline over two parameters, and beside them curves over the first.

    The curves have the literature beside them.
    """
    studied = Studied.of(dataset)
    if studied is None or refined(studied) or not is_map(studied):
        return None
    figure, (left, right) = panels(2, height=3.6, width_ratios=(1.25, 1))
    x, y, table = _table(studied)
    _draw_contours(left, studied, x, y, np.ma.masked_invalid(table))
    _draw_curves(right, studied, x)
    legend_above(figure, right)
    sound = np.isfinite(studied.computed).all()
    crosses = "" if sound else ", crosses did not complete"
    return captioned(
        figure,
        dataset,
        f"Left: contours; dots are computed cases{crosses}. Right: the same over one parameter.",
        studied.bars,
        ranges_of_own(dataset) if has_literature(studied) else "",
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
    shown = series(studied.groups(x.name, x.numbers), MOST_CURVES)
    ends: list[CurveEnd] = []
    if studied.headline == COMPARED:
        draw_experience(axes, studied.dataset)
    if has_literature(studied):
        drawn = [(cases, line.colour) for (cases, _), line in shown]
        ends += draw_literature(axes, studied, x, drawn)
    for (cases, label), line in shown:
        along, computed = x.numbers[cases], studied.computed[cases]
        axes.errorbar(along, computed, studied.widths(cases), **line.style, ms=4)
        ends += end_of(along, computed, label, line.colour)
    x.dress(axes, room=5)
    label, headline = (axis_label(studied.dataset, it) for it in (x.name, studied.headline))
    axes.set(xlabel=label, ylabel=headline)
    label_ends(axes, ends, size=7)
