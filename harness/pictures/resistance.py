"""The picture of the penetration resistance: a curve for each case, few of them with a label."""

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from harness.archive.conventions import curves_over_cases, over_cases, scenes_of, spoken
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import (
    INK,
    MOST_LABELS,
    SHADES,
    STYLED,
    CurveEnd,
    empty_figure,
    label_ends,
    legend_above,
    series_colour,
    shade,
)
from harness.pictures.drawing.quantities import axis_label
from harness.pictures.studied import Studied
from harness.study.designs import ONE_AT_A_TIME

RESISTANCE, STRENGTH = "penetration_resistance", "undrained_shear_strength"
OVER_STRENGTH = r"net resistance over strength $(q_\mathrm{c} - σ_\mathrm{v0})/s_\mathrm{u}$ [-]"
LABELLED_CHANGES = 5
"""Curves of one parameter at a time that have a label: those that differ most from the first."""


def shows_resistance(dataset: xr.Dataset) -> bool:
    """Whether a result holds the resistance over the penetration."""
    return RESISTANCE in dataset and STRENGTH in dataset and "status" in dataset


@STYLED
def resistance_figure(dataset: xr.Dataset) -> Figure:
    """Penetration resistance over undrained shear strength, one curve a case.

    Up to eight curves have their values beside them. More have the colour of where they end, or of
    several scenes that of their scene; of one parameter at a time the first case is black, and
    those that differ most are labelled.
    """
    studied = Studied.of(dataset)
    curves = curves_over_cases(dataset, RESISTANCE) / over_cases(dataset, STRENGTH)[:, None]
    drawn = [case for case, curve in enumerate(curves) if np.isfinite(curve).any()]
    figure, axes = empty_figure()
    x = dataset["penetration"].values
    last = {case: int(np.flatnonzero(np.isfinite(curves[case]))[-1]) for case in drawn}
    ends = {case: float(curves[case][place]) for case, place in last.items()}
    labelled = _labelled(dataset, drawn, ends)
    few = len(drawn) <= MOST_LABELS
    scale = Normalize(min(ends.values(), default=0.0), max(ends.values(), default=1.0))
    scenes = scenes_of(dataset)
    kinds = list(dict.fromkeys(scenes))
    marks = []
    for rank, case in enumerate(drawn):
        if few:
            colour = series_colour(rank, len(drawn))
        elif len(kinds) > 1:
            colour = series_colour(kinds.index(scenes[case]), len(kinds))
        else:
            colour = shade(float(scale(ends[case])))
        is_start = not few and labelled[:1] == [case]
        width = 1.3 if few or case in labelled else 0.6
        axes.plot(x, curves[case], color=INK if is_start else colour, lw=1.8 if is_start else width)
        label = _label(studied, case) if case in labelled else ""
        if label:
            marks.append(CurveEnd(x[last[case]], ends[case], label, INK if is_start else colour))
    axes.set_xlabel(axis_label(dataset, "penetration"))
    axes.set_ylabel(OVER_STRENGTH)
    axes.set_xlim(0, float(x.max()))
    axes.set_ylim(bottom=0)
    label_ends(axes, marks, size=7)
    if not few and len(kinds) > 1:
        for number, kind in enumerate(kinds):
            axes.plot([], [], color=series_colour(number, len(kinds)), label=spoken(kind))
        legend_above(figure, axes)
    elif not few:
        colours = ScalarMappable(scale, SHADES)
        bar = figure.colorbar(colours, ax=axes, location="top", aspect=50, pad=0.02)
        bar.set_label("resistance over strength at the end of the curve [-]", fontsize=8)
    failed = len(curves) - len(drawn)
    approached = any(np.isnan(curves[case][1 : last[case]]).any() for case in drawn)
    write_caption(
        figure,
        dataset,
        f"{len(drawn)} cases." if not few else "",
        "Before the gap the cone approaches faster; that part is no result." if approached else "",
        f"{failed} of {len(curves)} cases have no curve: they did not complete." if failed else "",
    )
    return figure


def _labelled(dataset: xr.Dataset, drawn: list[int], ends: dict[int, float]) -> list[int]:
    """The cases whose curves have a label; where a design starts from one, that is the first."""
    if len(drawn) <= MOST_LABELS:
        return drawn
    if dataset.attrs.get("design") != ONE_AT_A_TIME or drawn[0] != 0:
        return []
    others = sorted(drawn[1:], key=lambda case: abs(ends[case] - ends[0]), reverse=True)
    return [0, *others[:LABELLED_CHANGES]]


def _label(studied: Studied | None, case: int) -> str:
    """What a case is called: the varied values, of one at a time that which differs."""
    if studied is None or not studied.varied:
        return ""
    differs = [name for name, it in studied.varied.items() if it.numbers[case] != it.numbers[0]]
    if studied.design == ONE_AT_A_TIME and not differs:
        return "start"
    return studied.label(case, differs if studied.design == ONE_AT_A_TIME else None)
