"""The traction of the soil along the surface of a penetrometer, from the tip up the shaft."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from harness.pictures.drawing.plot_parts import series_colour
from harness.pictures.fields.nodal_values import Floats
from harness.pictures.fields.sections import caption

MOST_CURVES = 6
"""Snapshots that are drawn, the last among them."""


def traction_figure(fields: xr.Dataset) -> Figure:
    """Normal and shear traction over the way along the surface, a curve a snapshot.

    Args:
        fields: the snapshots of a case.

    Raises:
        KeyError: the dataset has no snapshots of a cone test.
    """
    figure = Figure(figsize=(7.2, 5.6), dpi=150, layout="constrained")
    normal, shear = figure.subplots(2, 1, sharex=True)
    radius = fields.cone_radius.item()
    way = _way(fields) / radius
    parts = {part: fields.surface_part.values == part for part in ("face", "shaft")}
    shoulder = float(way[parts["face"]].max())
    count = fields.sizes["penetration"]
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_CURVES)).round().astype(int))
    for place, number in enumerate(chosen):
        snapshot = fields.isel(penetration=number)
        colour = series_colour(place, len(chosen))
        style = {"color": colour, "lw": 0.8 + 0.8 * (number == count - 1)}
        label = f"{snapshot.penetration.item():g} R"
        for axes, name in ((normal, "normal_traction"), (shear, "shear_traction")):
            traction = snapshot[name].values / fields.undrained_shear_strength.item()
            for part, there in parts.items():
                shown = label if part == "face" else None
                axes.plot(way[there], traction[there], label=shown, **style)
    for axes, text in ((normal, "normal traction / su [-]"), (shear, "shear traction / su [-]")):
        axes.axvline(shoulder, color="0.5", lw=0.8, ls="--")
        axes.axhline(0.0, color="0.5", lw=0.5)
        axes.set_ylabel(text)
        axes.spines[["top", "right"]].set_visible(False)
    for x, text in ((0.5 * shoulder, "face"), (1.15 * shoulder, "shaft")):
        where = normal.get_xaxis_transform()
        normal.text(x, 1.0, text, transform=where, ha="left" if x > shoulder else "center")
    shear.set_xlabel("way along the surface from the tip / R [-]")
    shear.set_xlim(0.0, float(way.max()))
    normal.legend(title="penetration", fontsize=8, title_fontsize=8, frameon=False)
    figure.suptitle(caption(fields.isel(penetration=-1)), x=0.01, ha="left", fontsize=8)
    return figure


def _way(fields: xr.Dataset) -> Floats:
    """The way along the surface from the tip to each of its nodes [m]."""
    steps = np.hypot(np.diff(fields.surface_r.values), np.diff(fields.surface_z.values))
    way: Floats = np.concatenate([[0.0], np.cumsum(steps)])
    return way
