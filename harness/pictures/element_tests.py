"""The picture of element tests: stress over strain, the path of effective stress, pore pressure."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import curves_over_cases, over_cases
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import (
    MOST_LABELS,
    STYLED,
    chosen,
    legend_above,
    series_colour,
)
from harness.pictures.drawing.quantities import Floats
from harness.pictures.studied import Studied

STRAIN, SHEAR, DEVIATOR = "shear_strain", "shear_stress", "deviator_stress"
EFFECTIVE, WATER, SLOPE = "effective_mean_stress", "excess_pore_pressure", "critical_state_ratio"
LABELS = {
    STRAIN: r"shear strain $ε_1 - ε_3$ [-]",
    SHEAR: r"shear stress $(σ_1 - σ_3) / 2$ [kPa]",
    DEVIATOR: "deviator stress $q$ [kPa]",
    EFFECTIVE: "effective mean stress $p'$ [kPa]",
    WATER: "pore pressure of shear [kPa]",
}
KILO = 1e-3
SHOWN_STRENGTH = 0.99
"""The strain axis ends where every case has this share of the stress at its end, and twice that."""


def shows_element_tests(dataset: xr.Dataset) -> bool:
    """Whether a result holds stresses over the strain of element tests."""
    return {STRAIN, SHEAR, DEVIATOR, "status"} <= set(dataset.variables)


@STYLED
def element_tests_figure(dataset: xr.Dataset) -> Figure:
    """Shear stress over shear strain; of laws with effective stress q over p', and pore pressure.

    A dashed line is the critical state in compression. Few of many cases are drawn.
    """
    studied = Studied.of(dataset)
    names = [it for it in (SHEAR, DEVIATOR, EFFECTIVE, WATER) if it in dataset]
    curves = {name: KILO * curves_over_cases(dataset, name) for name in names}
    stress = curves[SHEAR]
    drawn = np.flatnonzero(np.isfinite(stress).any(axis=1))
    shown = [int(drawn[place]) for place in chosen(drawn.size, MOST_LABELS)]
    has_path = EFFECTIVE in curves and bool(np.isfinite(curves[EFFECTIVE][shown]).any())
    figure = Figure()
    panels = figure.subplots(1, 3 if has_path else 1, squeeze=False)[0]
    strain = dataset[STRAIN].values
    over_strain = {0: SHEAR, 2: WATER} if has_path else {0: SHEAR}
    for rank, case in enumerate(shown):
        colour = series_colour(rank, len(shown))
        label = "" if studied is None else studied.label(case)
        for place, name in over_strain.items():
            _draw(panels[place], strain, curves[name][case], colour, label)
        if has_path:
            _draw(panels[1], curves[EFFECTIVE][case], curves[DEVIATOR][case], colour, label)
    for place, name in over_strain.items():
        panels[place].set_xlabel(LABELS[STRAIN])
        panels[place].set_ylabel(LABELS[name])
        panels[place].set_xlim(0.0, _last_strain(strain, stress[shown]))
    panels[0].set_ylim(bottom=0.0)
    if has_path:
        panels[1].set_xlabel(LABELS[EFFECTIVE])
        panels[1].set_ylabel(LABELS[DEVIATOR])
        if SLOPE in dataset:
            _draw_critical_states(panels[1], over_cases(dataset, SLOPE)[shown])
    legend_above(figure, panels[0])
    left_out = drawn.size - len(shown)
    write_caption(
        figure,
        dataset,
        "Dashed: critical state in compression." if has_path and SLOPE in dataset else "",
        f"{left_out} more cases are not shown." if left_out else "",
    )
    return figure


def _draw(axes: Axes, x: Floats, y: Floats, colour: str, label: str) -> None:
    known = np.isfinite(x) & np.isfinite(y)
    axes.plot(x[known], y[known], color=colour, label=label)


def _last_strain(strain: Floats, stress: Floats) -> float:
    """Where the strain axis ends: beyond it nothing is to be seen."""
    last = np.array([row[np.isfinite(row)][-1] for row in stress])
    near = np.abs(stress - last[:, None]) <= (1.0 - SHOWN_STRENGTH) * np.abs(last)[:, None]
    far = [np.flatnonzero(row) for row in ~near & np.isfinite(stress)]
    reached = max((strain[it[-1]] for it in far if it.size), default=strain[-1])
    return float(min(strain[-1], 2.0 * reached))


def _draw_critical_states(axes: Axes, slopes: Floats) -> None:
    high = axes.get_xlim()[1]
    axes.set_xlim(0.0, high)
    axes.set_ylim(bottom=0.0)
    for slope in np.unique(slopes[np.isfinite(slopes)]):
        axes.plot([0.0, high], [0.0, slope * high], ls="--", lw=0.8, color="0.4", scaley=False)
