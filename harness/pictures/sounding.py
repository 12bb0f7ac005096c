"""The picture of soundings: depth downward, strength, resistance and cone factor side by side."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.compare.soundings import DEPTH, RESISTANCE, STRETCH, UNCERTAINTY, is_sounding, joined
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import (
    MOST_LABELS,
    STYLED,
    chosen,
    legend_above,
    series_colour,
)
from harness.pictures.drawing.symbols import assigned
from harness.pictures.studied import Studied

KILO = 1e3
HEIGHT = 5.0
"""Of the figure [inch]: depth needs room."""


def shows_sounding(dataset: xr.Dataset) -> bool:
    """Whether a result holds soundings."""
    return is_sounding(dataset)


@STYLED
def sounding_figure(dataset: xr.Dataset) -> Figure:
    """Strength, net resistance and local cone factor of each sounding over depth.

    Stretches of one sounding are joined. The band holds the resistance with 95 % where its error is
    known.
    """
    studied = Studied.of(dataset)
    soundings = joined(dataset)
    figure = Figure()
    figure.set_figheight(HEIGHT)
    strength, resistance, factor = figure.subplots(1, 3, sharey=True)
    count = soundings.sizes["sounding"]
    shown = chosen(count, MOST_LABELS)
    for rank, number in enumerate(shown):
        sounding = soundings.isel(sounding=number)
        colour = series_colour(rank, len(shown))
        _draw(resistance, sounding, RESISTANCE, colour, KILO, UNCERTAINTY)
        _draw(strength, sounding, "strength", colour, KILO)
        _draw(factor, sounding, "cone_factor_at_tip", colour)
        strength.lines[-1].set_label(_label(dataset, studied, int(sounding["case"])))
    for axes, label in (
        (strength, "strength $s_{\\mathrm{u}}$ [kPa]"),
        (resistance, "net resistance [kPa]"),
        (factor, "over strength at the tip [-]"),
    ):
        axes.set_xlabel(label)
        axes.set_xlim(left=0.0)
    strength.set_ylabel("depth of the tip [m]")
    strength.invert_yaxis()
    if count > 1:
        legend_above(figure, strength)
    has_band = bool(np.isfinite(soundings[UNCERTAINTY]).any())
    write_caption(
        figure,
        dataset,
        "Bands hold the resistance with 95 %." if has_band else "",
        f"{count - len(shown)} more soundings are not shown." if count > len(shown) else "",
    )
    return figure


def _draw(
    axes: Axes,
    sounding: xr.Dataset,
    name: str,
    colour: str,
    scale: float = 1.0,
    half_width: str | None = None,
) -> None:
    depth, values = sounding[DEPTH].values, sounding[name].values / scale
    axes.plot(values, depth, color=colour, lw=1.0)
    if half_width is not None:
        width = sounding[half_width].values / scale
        axes.fill_betweenx(depth, values - width, values + width, color=colour, alpha=0.25, lw=0)


def _label(dataset: xr.Dataset, studied: Studied | None, case: int) -> str:
    """What a sounding is called: its varied values, beside the number of the stretch."""
    varied = {} if studied is None else studied.varied
    return ", ".join(
        assigned(dataset, name, it.value(float(it.numbers[case])))
        for name, it in varied.items()
        if name not in (STRETCH, "to_depth")
    )
