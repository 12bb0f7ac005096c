"""The picture `convergence`: a result over a refinement of the method, with order and limit."""

from collections.abc import Callable

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import over_cases
from harness.compare.convergence import LEAST_POINTS, approach, order_of_error
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import MOST_LABELS, panels, series
from harness.pictures.drawing.quantities import Floats, apart, axis_label, number
from harness.pictures.drawing.style import PAPER, STYLED
from harness.pictures.studied import Studied
from harness.study.compared import ERROR

OF_ERROR = "The order is that between the two finest."
OF_LIMIT = (
    "Order and limit are from the three finest values by Richardson's extrapolation; the dotted "
    "line leads to the limit, the hollow mark. No order: the values do not approach a limit "
    "evenly, and their distance to it is not known."
)
OF_CORRECTED = "Corrected values have no order: the known error of the mesh is taken off them."

Refinement = tuple[Callable[[Floats], Floats], str]
"""What goes to zero, as a function of a parameter, and the value of the parameter there."""
INVERSE: Refinement = (lambda value: 1.0 / value, "∞")
ITSELF: Refinement = (lambda value: value, "0")
COMPRESSIBILITY: Refinement = (lambda value: 1.0 - 2.0 * value, "0.5")
REFINED_BY: dict[str, tuple[str, Refinement]] = {
    "cells_per_radius": ("cell width over radius $h/R$", INVERSE),
    "cells_per_length": ("cell width over length $h/L$", INVERSE),
    "cell_count": ("cell width, 1 / cell count", INVERSE),
    "cell_growth": ("cell growth", ITSELF),
    "speed_ratio": (r"speed $v/v_\mathrm{s}$", ITSELF),
    "time_step_fraction": (r"time step $Δt/Δt_\mathrm{c}$", ITSELF),
    "domain_radius": ("cone radius over radius of the grid", INVERSE),
    "domain_above": ("cone radius over extent above", INVERSE),
    "domain_below": ("cone radius over extent below", INVERSE),
    "poissons_ratio_bound": (r"$1 - 2ν_\mathrm{max}$", COMPRESSIBILITY),
}
"""By parameter of a method: what goes to zero with refinement, in words, and as a function."""


def refined(studied: Studied) -> str | None:
    """The parameter that refines, the one with most values; None with too many cases beside it."""
    found = [
        name
        for name in studied.numbers
        if studied.is_combined
        and name in REFINED_BY
        and name in studied.method
        and studied.varied[name].different.size >= LEAST_POINTS
    ]
    name = max(found, key=lambda it: studied.varied[it].different.size, default=None)
    few = name is not None and len(studied.groups(name, studied.computed)) <= MOST_LABELS
    return name if few else None


@STYLED
def convergence_figure(dataset: xr.Dataset) -> Figure | None:
    """The headline over what goes to zero with refinement, and its limit there.

    An error against an exact solution, whose limit is zero, is drawn on logarithmic axes.
    """
    studied = Studied.of(dataset)
    name = None if studied is None else refined(studied)
    if studied is None or name is None:
        return None
    h = REFINED_BY[name][1][0](studied.varied[name].numbers)
    is_error = studied.headline == ERROR
    correction = np.nan_to_num(over_cases(dataset, f"{studied.headline}_correction").astype(float))
    simulated, is_corrected = studied.computed - correction, bool(correction.any())
    figure, (axes,) = panels()
    for (cases, label), line in series(studied.groups(name, h)):
        x, y = h[cases], simulated[cases]
        observed = _order(x, y) if is_error else _draw_limit(axes, x, y, line.colour)
        text, dashes = f"{label or 'computed'}: {observed}", "-" if is_error else ""
        if is_corrected:
            text = f"{label or 'computed'}, corrected"
            told = f"{label or 'computed'}, as simulated: {observed}"
            axes.plot(x, y, **line.style, mfc=PAPER, ls="", label=told)
        studied.draw(axes, h, cases, **line.style, ls=dashes, label=text)
    if is_error:
        axes.set(xscale="log", yscale="log")
    _dress(axes, studied, name, is_error)
    meaning = OF_ERROR if is_error else OF_LIMIT
    of_corrected = OF_CORRECTED if is_corrected else ""
    return captioned(figure, dataset, meaning, of_corrected, studied.bars, legend=axes)


def _order(h: Floats, error: Floats) -> str:
    """The order of errors in words."""
    order = order_of_error(h, error)
    return "no order" if order is None else f"order {order:.2f}"


def _draw_limit(axes: Axes, h: Floats, values: Floats, colour: str) -> str:
    """Draw the way to the limit of values that approach one; what was observed, in words."""
    found = approach(h, values)
    if found is None:
        return "no order"
    used = np.sort(h[np.isfinite(values)])[:LEAST_POINTS]
    fine = np.linspace(0.0, used[-1], 200)
    axes.plot(fine, found.at(fine), ":", color=colour)
    axes.plot([0.0], [found.limit], "o", mfc=PAPER, color=colour, clip_on=False, zorder=5)
    return f"order {found.order:.2f}, limit {number(found.limit)}"


def _dress(axes: Axes, studied: Studied, name: str, is_error: bool) -> None:
    """Ticks at what was computed, called by the parameter's values."""
    meaning, (refinement, limit) = REFINED_BY[name]
    values = studied.varied[name].different
    places = refinement(values)
    texts = {0.0: limit} | dict(zip(places.tolist(), map(number, values), strict=True))
    if is_error:
        shown = apart(np.sort(places), "log", room=12)
    else:
        axes.set_xlim(0.0, 1.06 * places.max())
        shown = apart(np.array([0.0, *np.sort(places)]), "linear", room=12)
    axes.set_xticks(shown, [texts[place] for place in shown])
    axes.set_xticks([], minor=True)
    axes.set_xlabel(f"{axis_label(studied.dataset, name)}, spaced by {meaning}")
    axes.set_ylabel(axis_label(studied.dataset, studied.headline))
