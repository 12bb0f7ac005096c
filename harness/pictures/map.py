"""The picture `map`: contours of the result over two varied parameters, and curves over one."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.pictures.curve import draw_over
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import panels
from harness.pictures.drawing.quantities import Floats, Values, axis_label
from harness.pictures.drawing.style import DOT, FAILED, INK, PAPER, SHADES, STYLED
from harness.pictures.literature import has_literature, ranges_of_own
from harness.pictures.method.convergence import refined
from harness.pictures.studied import Studied

MOST_CURVES = 5
"""Largest number of curves beside a map."""


@STYLED
def map_figure(dataset: xr.Dataset) -> Figure | None:
    """Contours of the headline over two parameters, and beside them curves over the first.

    The curves have the literature beside them.
    """
    studied = Studied.of(dataset)
    if studied is None or refined(studied) or not studied.is_map:
        return None
    figure, (left, right) = panels(2, width_ratios=(1.25, 1))
    x, y, table = studied.table
    _draw_contours(left, studied, x, y, np.ma.masked_invalid(table))
    draw_over(right, studied, x, MOST_CURVES, room=5, at_ends=True)
    sound = np.isfinite(studied.computed).all()
    crosses = "" if sound else ", crosses did not complete"
    return captioned(
        figure,
        dataset,
        f"Left: contours; dots are computed cases{crosses}. Right: the same over one parameter.",
        studied.bars,
        ranges_of_own(dataset) if has_literature(studied) else "",
        legend=right,
    )


def _draw_contours(axes: Axes, studied: Studied, x: Values, y: Values, table: Floats) -> None:
    levels: Sequence[float] = MaxNLocator(7).tick_values(table.min(), table.max())
    filled = axes.contourf(x.different, y.different, table, levels=levels, cmap=SHADES)
    lines = axes.contour(filled, colors=PAPER)
    # The axes need their scales before contour labels are placed.
    x.dress(axes, room=7)
    y.dress(axes, room=10, which="y")
    for label in axes.clabel(lines, fmt="%g"):  # at the edge it would be cut off
        place = (axes.transData - axes.transAxes).transform(label.get_position())
        label.set_visible(bool((np.abs(place - 0.5) < 0.45).all()))
    sound = np.isfinite(studied.computed)
    axes.plot(x.numbers[sound], y.numbers[sound], "o", color=INK, ms=DOT, clip_on=False)
    if not sound.all():
        axes.plot(x.numbers[~sound], y.numbers[~sound], "x", color=FAILED, clip_on=False)
    axes.grid(visible=False)
    axes.set(xlabel=axis_label(studied.dataset, x.name), ylabel=axis_label(studied.dataset, y.name))
    above = axes.inset_axes((0, 1.04, 1, 0.04))
    bar = axes.figure.colorbar(filled, cax=above, orientation="horizontal", ticklocation="top")
    bar.set_label(axis_label(studied.dataset, studied.headline))
