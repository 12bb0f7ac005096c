"""The picture of the penetration resistance: a curve for each case."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from harness.pictures.plot_parts import (
    CurveEnd,
    axis_label,
    empty_figure,
    fixed_note,
    label_ends,
    series_colour,
    series_of,
)

MOST_LABELS = 20
"""Curves whose labels find room beside a picture."""


def shows_resistance(dataset: xr.Dataset) -> bool:
    """Whether a result holds the resistance over the penetration."""
    return "penetration_resistance" in dataset


def resistance_figure(dataset: xr.Dataset) -> Figure:
    """Penetration resistance over undrained shear strength, one curve a case."""
    resistance = dataset["penetration_resistance"] / dataset["undrained_shear_strength"]
    figure, axes = empty_figure()
    curves = xr.Dataset({"curve": resistance})
    series = series_of(curves, [dim for dim in resistance.dims if dim != "penetration"])
    ends, failed = [], []
    for index, (label, one) in enumerate(series):
        curve = one["curve"].dropna("penetration")
        if curve.size == 0:
            failed.append(label)
            continue
        colour = series_colour(index, len(series))
        axes.plot(curve["penetration"], curve, color=colour, lw=1.2, label=label)
        ends.append(CurveEnd(float(curve["penetration"][-1]), float(curve[-1]), label, colour))
    axes.set_xlabel(axis_label(dataset["penetration"]))
    axes.set_ylabel("resistance / undrained shear strength [-]")
    axes.set_xlim(0, float(dataset["penetration"].max()))
    axes.set_ylim(bottom=0)
    if len(ends) <= MOST_LABELS:
        label_ends(axes, ends)
    notes = [fixed_note(dataset), *(["failed: " + "; ".join(failed)] if failed else [])]
    axes.set_title("\n".join(filter(None, notes)), loc="left", fontsize=8)
    return figure
