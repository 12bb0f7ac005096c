"""The picture of cyclic tests: loops of resistance over depth, and resistance over cycles."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import case_dims, curves_over_cases, over_cases
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import (
    MARKERS,
    MOST_LABELS,
    STYLED,
    chosen,
    legend_above,
    series_colour,
)
from harness.pictures.drawing.quantities import axis_label
from harness.pictures.studied import Studied
from mpm_warp.scenes.full_flow.cyclic import Degradation

LOOPS, FACTOR, STRENGTH = (
    "cyclic_resistance",
    "cyclic_resistance_factor",
    "undrained_shear_strength",
)
FITTED = {
    "intact": "fitted_resistance_factor",
    "remoulded_share": "fitted_remoulded_ratio",
    "cycles": "fitted_cycles",
    "misfit": "fit_misfit",
}
"""Where a result has the numbers of a `Degradation`."""
FINE = 200
"""Points of a fitted curve."""


def shows_cycles(dataset: xr.Dataset) -> bool:
    """Whether a result holds loops of resistance."""
    return {LOOPS, FACTOR, STRENGTH, "status"} <= set(dataset)


@STYLED
def cycles_figure(dataset: xr.Dataset) -> Figure:
    """The loops of the case that loses most resistance, and all cases over cycles with their fits.

    Depth goes downward; resistance is below 0 where the body is pulled up.
    """
    studied = Studied.of(dataset)
    cases = _by_case(dataset)
    figure = Figure()
    loops, factors = figure.subplots(1, 2, width_ratios=(2, 3))
    drawn = np.flatnonzero(np.isfinite(cases[FACTOR].values).any(axis=1))
    shown = [int(drawn[place]) for place in chosen(drawn.size, MOST_LABELS)]
    for rank, number in enumerate(shown):
        label = "" if studied is None else studied.label(number)
        _draw_factor(factors, cases.isel(case=number), rank, len(shown), label)
    factors.set_xlabel("number of the cycle [-]")
    factors.set_ylabel(r"resistance factor $q/s_\mathrm{u}$ [-]")
    factors.set_xlim(left=0.0)
    factors.set_ylim(bottom=0.0)
    known = [row[np.isfinite(row)] for row in cases[FACTOR].values]
    most = min(drawn.tolist(), key=lambda it: known[it][-1] / known[it][0], default=None)
    if most is not None:
        _draw_loops(loops, cases.isel(case=most))
    loops.set_xlabel(r"resistance over strength $q/s_\mathrm{u}$ [-]")
    loops.set_ylabel(axis_label(dataset, "penetration"))
    loops.invert_yaxis()
    legend_above(figure, factors)
    of_one = "" if most is None or studied is None else studied.label(most)
    write_caption(
        figure,
        dataset,
        f"Loops: {of_one}, from light to dark." if of_one else "",
        "Curves over cycles: fits.",
        f"{drawn.size - len(shown)} more cases are not shown." if drawn.size > len(shown) else "",
    )
    return figure


def _by_case(dataset: xr.Dataset) -> xr.Dataset:
    """What is drawn, the resistance over the strength, over one dim of cases."""
    dims = case_dims(dataset)
    names = [LOOPS, FACTOR, *FITTED.values()]
    strength = over_cases(dataset, STRENGTH)
    kept = {}
    for name in names:
        if name in dataset:
            own = [dim for dim in dataset[name].dims if dim not in dims]
            kept[name] = ("case", *own), curves_over_cases(dataset, name)
    coordinates = {name: dataset[name].values for name in ("cycle", "penetration")}
    cases = xr.Dataset(kept, coords=coordinates)
    cases[LOOPS] = cases[LOOPS] / xr.DataArray(strength, dims="case")
    return cases


def _draw_factor(axes: Axes, case: xr.Dataset, rank: int, count: int, label: str) -> None:
    colour = series_colour(rank, count)
    cycle = case["cycle"].values
    factor, marker = case[FACTOR].values, MARKERS[rank]
    axes.errorbar(cycle, factor, color=colour, label=label, ls="", marker=marker, ms=4)
    fit = Degradation(**{name: float(case.get(stored, np.nan)) for name, stored in FITTED.items()})
    if np.isfinite(fit.cycles):
        along = np.linspace(0.0, float(cycle[-1]), FINE)
        axes.plot(along, fit.resistance_factor(along), color=colour, lw=0.8)


def _draw_loops(axes: Axes, case: xr.Dataset) -> None:
    passages = [it for it in case[LOOPS].values if np.isfinite(it).any()]
    for number, resistance in enumerate(passages):
        # From the last shade to the first: what is remoulded is dark.
        colour = series_colour(len(passages) - 1 - number, max(2, len(passages)))
        axes.plot(resistance, case["penetration"].values, color=colour, lw=0.9)
