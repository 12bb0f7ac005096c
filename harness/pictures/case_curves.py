"""Pictures of curves: `resistance` over penetration, `element_tests` and `cycles`.

Element tests are shown as stress over strain; for laws with effective stress the stress path and
the pore pressure follow. Cyclic tests are shown as loops of resistance over depth, and as
resistance over the number of cycles. If there are many cases, only a few get a label.
"""

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from harness.archive.conventions import (
    by_case,
    headlines_of,
    is_there,
    over_cases,
    scenes_of,
    spoken,
    varied_within,
)
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import (
    INK,
    KILO,
    MOST_LABELS,
    SHADES,
    STYLED,
    CurveEnd,
    Series,
    label_ends,
    panels,
    series_colour,
    shade,
)
from harness.pictures.drawing.quantities import (
    Floats,
    Values,
    assigned,
    axis_label,
    plain,
    spelt,
)
from harness.pictures.studied import Studied, case_labels, series_of
from harness.study.designs import ONE_AT_A_TIME
from mpm_warp.scenes.full_flow.degradation import Degradation

RESISTANCE, STRENGTH = "penetration_resistance", "undrained_shear_strength"
OVER_STRENGTH = r"net resistance over strength $(q_\mathrm{c} - σ_\mathrm{v0})/s_\mathrm{u}$ [-]"
APPROACHED = (
    "Before the gap the cone approaches faster; this part is no result. Its speed rises over the "
    "first radius and falls in the gap."
)


@STYLED
def resistance_figure(dataset: xr.Dataset) -> Figure | None:
    """Penetration resistance over undrained shear strength, one curve per case.

    Up to eight curves are labelled. If there are more, the colour of a curve shows the varied
    number that the ends of the curves follow most, or its scene if there are several. In a
    one-at-a-time study the first case is black, and the cases that differ most from it are
    labelled.
    """
    if not {RESISTANCE, STRENGTH} <= set(dataset.variables):
        return None
    resistance = by_case(dataset[["status", RESISTANCE]])[RESISTANCE].values
    curves = resistance / over_cases(dataset, STRENGTH)[:, None]
    drawn = np.flatnonzero(np.isfinite(curves).any(axis=1)).tolist()
    last = {case: int(np.flatnonzero(np.isfinite(curves[case]))[-1]) for case in drawn}
    ends = {case: float(curves[case][place]) for case, place in last.items()}
    scenes = scenes_of(dataset)
    kinds = list(dict.fromkeys(scenes))
    few, several = len(drawn) <= MOST_LABELS, len(kinds) > 1
    labelled = drawn if few else _furthest(dataset, ends)
    studied = Studied.of(dataset)
    along = None if few or several else _followed(studied, ends)
    figure, (axes,) = panels()
    if few:
        colours = {case: series_colour(rank, len(drawn)) for rank, case in enumerate(drawn)}
    elif along is not None:
        scale = _scale_above(figure, axes, dataset, along)
        colours = {
            case: shade(float(np.asarray(scale.norm(along.numbers[case])))) for case in drawn
        }
    else:
        of_kind = {kind: series_colour(rank, len(kinds)) for rank, kind in enumerate(kinds)}
        colours = {case: of_kind[scenes[case]] for case in drawn}
        for kind, colour in of_kind.items() if several else ():
            axes.plot([], [], color=colour, label=spelt(spoken(kind)))
    if not few:
        colours |= dict.fromkeys(labelled[:1], INK)
    x, marks = dataset["penetration"].values, []
    for case in drawn:
        named = _with_scene(dataset, case) if few and several else None
        width = 1.3 if case in labelled else 0.6
        axes.plot(x, curves[case], color=colours[case], lw=width, label=named)
        if case in labelled and studied and studied.varied:
            marks.append(CurveEnd(x[last[case]], ends[case], studied.label(case), colours[case]))
    axes.set(xlabel=axis_label(dataset, "penetration"), ylabel=OVER_STRENGTH)
    axes.set(xlim=(0, float(x.max())), ylim=(0, None))
    label_ends(axes, marks, size=7)
    failed = len(curves) - len(drawn)
    approached = any(np.isnan(curves[case][1 : last[case]]).any() for case in drawn)
    return captioned(
        figure,
        dataset,
        f"{len(drawn)} cases." if not few else "",
        _as_simulated(dataset),
        APPROACHED if approached else "",
        f"{failed} of {len(curves)} cases have no curve: they did not complete." if failed else "",
        legend=axes if several else None,
    )


def _as_simulated(dataset: xr.Dataset) -> str:
    """A sentence on results that are corrected, which the curves are not; "" if there are none."""
    corrected = [
        plain(spelt(spoken(name)))
        for name in headlines_of(dataset)
        if np.nan_to_num(over_cases(dataset, f"{name}_correction")).any()
    ]
    told = "Curves are as simulated; for the known error of mesh, speed and window only"
    return f"{told} the {' and the '.join(corrected)} is corrected." if corrected else ""


def _followed(studied: Studied | None, ends: dict[int, float]) -> Values | None:
    """The varied number that the ends of curves follow most, or a text if no number varies."""
    from scipy.stats import spearmanr

    if studied is None or not studied.varied or studied.is_one_at_a_time:
        return None
    names = [
        name
        for name in studied.numbers or studied.varied
        if np.ptp(studied.varied[name].numbers[[*ends]]) > 0.0
    ]
    found = {
        name: abs(spearmanr(studied.varied[name].numbers[[*ends]], [*ends.values()]).statistic)
        for name in names
    }
    return studied.varied[max(found, key=lambda name: found[name])] if found else None


def _scale_above(figure: Figure, axes: Axes, dataset: xr.Dataset, along: Values) -> ScalarMappable:
    """A scale of colours for a parameter, above the axes."""
    ends = along.different[[0, -1]].tolist()
    scale = ScalarMappable((LogNorm if along.scale == "log" else Normalize)(*ends), SHADES)
    bar = figure.colorbar(scale, ax=axes, location="top", aspect=50, pad=0.02)
    along.dress(bar.ax, room=10)
    bar.ax.set_xlim(*ends)
    bar.set_label(axis_label(dataset, along.name), fontsize=8)
    return scale


def _furthest(dataset: xr.Dataset, ends: dict[int, float]) -> list[int]:
    """In a one-at-a-time study the first case and the five whose curves end furthest from its."""
    if dataset.attrs.get("design") != ONE_AT_A_TIME or 0 not in ends:
        return []
    others = sorted(ends, key=lambda case: abs(ends[case] - ends[0]), reverse=True)
    others.remove(0)
    return [0, *others[:5]]


def _with_scene(dataset: xr.Dataset, case: int) -> str:
    """The label of a case in a study of several scenes: scene and varied values."""
    values = {name: over_cases(dataset, name)[case] for name in varied_within(dataset)}
    own = [assigned(dataset, name, value) for name, value in values.items() if is_there(value)]
    return ", ".join([spelt(spoken(scenes_of(dataset)[case])), *own])


STRAIN, SHEAR, DEVIATOR = "shear_strain", "shear_stress", "deviator_stress"
EFFECTIVE, WATER, SLOPE = (
    "effective_mean_stress",
    "excess_pore_pressure",
    "material.critical_state_ratio",
)
LABELS = {
    STRAIN: r"shear strain $ε_1 - ε_3$ [-]",
    SHEAR: r"shear stress $(σ_1 - σ_3) / 2$ [kPa]",
    DEVIATOR: "deviator stress $q$ [kPa]",
    EFFECTIVE: "effective mean stress $p'$ [kPa]",
    WATER: "pore pressure of shear [kPa]",
}


@STYLED
def element_tests_figure(dataset: xr.Dataset) -> Figure | None:
    """Shear stress over shear strain; for laws with effective stress also q over p' and pressure.

    A dashed line shows the critical state in compression.
    """
    if not {STRAIN, SHEAR, DEVIATOR} <= set(dataset.variables):
        return None
    names = [name for name in (SHEAR, DEVIATOR, EFFECTIVE, WATER) if name in dataset]
    cases = by_case(dataset[["status", *names]])
    curves = {name: cases[name].values / KILO for name in names}
    stress = curves[SHEAR]
    lines, left_out = series_of(dataset, stress)
    shown = [line.place for line in lines]
    has_path = EFFECTIVE in curves and bool(np.isfinite(curves[EFFECTIVE][shown]).any())
    shown_over = {SHEAR: STRAIN} | ({DEVIATOR: EFFECTIVE, WATER: STRAIN} if has_path else {})
    figure, all_axes = panels(len(shown_over))
    strain = dataset[STRAIN].values
    curves[STRAIN] = np.broadcast_to(strain, stress.shape)
    for axes, (name, over) in zip(all_axes, shown_over.items(), strict=True):
        for line in lines:
            x, y = curves[over][line.place], curves[name][line.place]
            known = np.isfinite(x) & np.isfinite(y)
            axes.plot(x[known], y[known], color=line.colour, label=line.label)
        axes.set(xlabel=LABELS[over], ylabel=LABELS[name])
        if over == STRAIN:
            axes.set_xlim(0.0, _last_strain(strain, stress[shown]))
    all_axes[0].set_ylim(bottom=0.0)
    dashed = ""
    if has_path and SLOPE in dataset:
        path, dashed = all_axes[1], "Dashed: critical state in compression."
        high = path.get_xlim()[1]
        path.set(xlim=(0.0, high), ylim=(0.0, None))
        slopes = over_cases(dataset, SLOPE)[shown]
        for slope in np.unique(slopes[np.isfinite(slopes)]):
            ends = [0.0, high], [0.0, slope * high]
            path.plot(*ends, ls="--", lw=0.8, color="0.4", scaley=False)
    return captioned(figure, dataset, dashed, left_out, legend=all_axes[0])


def _last_strain(strain: Floats, stress: Floats) -> float:
    """End of the strain axis: twice the strain at which each stress is within 1 % of its last."""
    last = np.array([[row[np.isfinite(row)][-1]] for row in stress])
    far = (np.abs(stress - last) > 0.01 * np.abs(last)).any(axis=0)
    reached = strain[far][-1] if far.any() else strain[-1]
    return float(min(strain[-1], 2.0 * reached))


LOOPS, FACTOR = "cyclic_resistance", "cyclic_resistance_factor"
FITTED = {
    "intact": "fitted_resistance_factor",
    "remoulded_share": "fitted_remoulded_ratio",
    "cycles": "fitted_cycles",
    "misfit": "fit_misfit",
}
"""Variables of a result that hold the fields of a `Degradation`."""


@STYLED
def cycles_figure(dataset: xr.Dataset) -> Figure | None:
    """Loops of the case that loses most resistance, and resistance over cycles of all cases.

    Depth increases downward. The resistance is negative while the body is pulled up.
    """
    if not {LOOPS, FACTOR, STRENGTH} <= set(dataset):
        return None
    names = [LOOPS, FACTOR, STRENGTH, *FITTED.values()]
    cases = by_case(dataset[[name for name in ("status", *names) if name in dataset]])
    lines, left_out = series_of(dataset, cases[FACTOR].values)
    figure, (loops, factors) = panels(2, width_ratios=(2, 3))
    fitted = [_draw_factor(factors, cases.isel(case=line.place), line) for line in lines]
    factors.set(xlabel="number of the cycle [-]", ylabel=r"resistance factor $q/s_\mathrm{u}$ [-]")
    # If no case softens, all values are nearly equal, and automatic limits would be too narrow.
    factors.set(xlim=(0.0, None), ylim=(0.0, 1.05 * factors.dataLim.ymax if lines else None))
    kept = {
        place: known[-1] / known[0]
        for place, row in enumerate(cases[FACTOR].values)
        if (known := row[np.isfinite(row)]).size
    }
    label = ""
    if kept:
        most = min(kept, key=lambda it: kept[it])
        _draw_loops(loops, cases.isel(case=most))
        label = case_labels(dataset)[most]
    of_one = f"Loops: {label}, from light to dark." if label else ""
    loops.set_xlabel(r"resistance over strength $q/s_\mathrm{u}$ [-]")
    loops.set_ylabel(axis_label(dataset, "penetration"))
    loops.invert_yaxis()
    fits = "Curves over cycles: fits." if any(fitted) else ""
    return captioned(figure, dataset, of_one, fits, left_out, legend=factors)


def _draw_factor(axes: Axes, case: xr.Dataset, line: Series) -> bool:
    """Draw a case over its cycles, with its fit; return whether it has one."""
    cycle = case["cycle"].values
    axes.errorbar(cycle, case[FACTOR].values, **line.style, label=line.label, ls="", ms=4)
    fit = Degradation(**{name: float(case.get(stored, np.nan)) for name, stored in FITTED.items()})
    is_fitted = math.isfinite(fit.cycles)
    if is_fitted:
        along = np.linspace(0.0, float(cycle[-1]), 200)
        axes.plot(along, fit.resistance_factor(along), color=line.colour, lw=0.8)
    return is_fitted


def _draw_loops(axes: Axes, case: xr.Dataset) -> None:
    strength = case[STRENGTH].item()
    passages = [value / strength for value in case[LOOPS].values if np.isfinite(value).any()]
    for number, resistance in enumerate(passages):
        # From light to dark, so that remoulded soil is dark.
        colour = series_colour(len(passages) - 1 - number, max(2, len(passages)))
        axes.plot(resistance, case["penetration"].values, color=colour, lw=0.9)
