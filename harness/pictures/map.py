"""The picture of two varied numbers: contours over both, and a few curves over one of them."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.pictures.convergence import shows_convergence
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import (
    FAILED,
    INK,
    MARKERS,
    SHADES,
    STYLED,
    CurveEnd,
    chosen,
    draw_series,
    label_ends,
    series_colour,
)
from harness.pictures.drawing.quantities import Floats, assigned, axis_label
from harness.pictures.studied import Studied

LEAST_VALUES = 3
"""Values of each parameter from which on there is a map."""
MOST_CURVES = 5
LEVELS = 7
HEIGHT = 3.6
"""Of the picture, in inches."""
EDGE = 0.05
"""Of the axes: a contour's label that is nearer to their edge would be cut off, and is left out."""


def shows_map(dataset: xr.Dataset) -> bool:
    """Whether a result is that of two varied numbers, of all combinations of their values."""
    studied = Studied.of(dataset)
    if studied is None or not studied.is_combined or shows_convergence(dataset):
        return False
    if len(studied.varied) != 2 or len(studied.numbers) != 2:
        return False
    counts = [values.different.size for values in studied.varied.values()]
    table = _table(studied, *_axes_of(studied))
    # Contours need neighbours: a map with holes says less than the curves.
    full = np.isfinite(table).mean() > 0.5
    return min(counts) >= LEAST_VALUES and studied.computed.size == np.prod(counts) and bool(full)


@STYLED
def map_figure(dataset: xr.Dataset) -> Figure:
    """Contours of what was computed over two parameters; beside them curves over the first."""
    studied = Studied.known(dataset)
    across, up = _axes_of(studied)
    figure = Figure(figsize=(Figure().get_figwidth(), HEIGHT))
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    _draw_contours(figure, left, studied, across, up)
    _draw_curves(right, studied, across, up)
    bars = "error bars hold the value with 95 %" if studied.half_width is not None else ""
    sound = np.isfinite(studied.computed).all()
    crosses = "" if sound else ", crosses did not complete"
    write_caption(
        figure,
        dataset,
        f"Left: contours; dots are computed cases{crosses}. "
        f"Right: the same over one parameter{'; ' if bars else ''}{bars}.",
    )
    return figure


def _axes_of(studied: Studied) -> tuple[str, str]:
    """The parameter along the horizontal axis, the one with more values, and the other."""
    first, second = studied.varied
    sizes = [studied.varied[name].different.size for name in (first, second)]
    return (first, second) if sizes[0] >= sizes[1] else (second, first)


def _table(studied: Studied, across: str, up: str, values: Floats | None = None) -> Floats:
    """Values of the cases over both parameters, shape [up, across]; else not a number."""
    columns, rows = studied.varied[across], studied.varied[up]
    table = np.full((rows.different.size, columns.different.size), np.nan)
    row = np.searchsorted(rows.different, rows.numbers)
    column = np.searchsorted(columns.different, columns.numbers)
    table[row, column] = studied.computed if values is None else values
    return table


def _draw_contours(figure: Figure, axes: Axes, studied: Studied, across: str, up: str) -> None:
    x, y = studied.varied[across], studied.varied[up]
    table = np.ma.masked_invalid(_table(studied, across, up))
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
    axes.set_xlabel(axis_label(studied.dataset, across))
    axes.set_ylabel(axis_label(studied.dataset, up))
    bar = figure.colorbar(filled, cax=axes.inset_axes((0, 1.04, 1, 0.04)), orientation="horizontal")
    bar.ax.xaxis.set_ticks_position("top")
    bar.ax.xaxis.set_label_position("top")
    bar.set_label(axis_label(studied.dataset, studied.headline), fontsize=8)
    bar.ax.tick_params(labelsize=7)


def _draw_curves(axes: Axes, studied: Studied, across: str, up: str) -> None:
    x, y = studied.varied[across], studied.varied[up]
    table = _table(studied, across, up)
    widths = None if studied.half_width is None else _table(studied, across, up, studied.half_width)
    rows = chosen(y.different.size, MOST_CURVES)
    ends = []
    for rank, row in enumerate(rows):
        colour = series_colour(rank, len(rows))
        width = None if widths is None else widths[row]
        draw_series(axes, x.different, table[row], width, color=colour, marker=MARKERS[rank], ms=4)
        known = np.flatnonzero(np.isfinite(table[row]))
        if known.size:
            last = known[-1]
            label = assigned(studied.dataset, up, float(y.different[row]))
            ends.append(CurveEnd(x.different[last], table[row, last], label, colour))
    x.dress(axes, room=5)
    axes.set_xlabel(axis_label(studied.dataset, across))
    axes.set_ylabel(axis_label(studied.dataset, studied.headline))
    label_ends(axes, ends, size=7)
