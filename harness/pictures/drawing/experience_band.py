"""Experience in a picture of cone factors: hatched bands behind what was computed."""

from __future__ import annotations

import xarray as xr
from matplotlib.axes import Axes

from harness.compare.experience import stored_experience
from harness.references.experience import Factor

HATCHES = ("///", "\\\\\\", "...", "---")
"""Hatches of bands, one after the other: a reader can tell them apart where they overlap."""
COLOUR = "#8C8C8C"


def draw_experience(axes: Axes, dataset: xr.Dataset) -> None:
    """Draw the bands of cone factors that a result is set beside.

    They span the whole width, since the field has no value along the axis, and stand in the legend
    with their bounds.

    Args:
        axes: where to; the cone factor is along its vertical axis.
        dataset: the result of a study.
    """
    entries = [it for it in stored_experience(dataset) if it.factor is Factor.RESISTANCE]
    for rank, entry in enumerate(entries):
        axes.axhspan(
            *entry.bounds,
            facecolor="none",
            edgecolor=COLOUR,
            hatch=HATCHES[rank % len(HATCHES)],
            linewidth=0,
            alpha=0.5,
            zorder=0.5,
            label=f"experience, {entry.label}: {entry.band}",
        )
