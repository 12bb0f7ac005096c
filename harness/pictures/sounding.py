"""The picture of soundings: depth downward, strength, resistance and cone factor side by side.

The stretches of a sounding, cut at depths and run side by side, are joined to one curve. Where two
overlap the curve is their mean, and half of their difference, as a root mean square over the
overlap, is a part of its half width.
"""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import by_case, case_dims
from harness.pictures.drawing.caption import captioned, left_out, of_half_widths
from harness.pictures.drawing.plot_parts import STYLED, chosen, legend_above, series_colour
from harness.pictures.studied import Studied

RESISTANCE, UNCERTAINTY = "net_resistance", "net_resistance_uncertainty"
DEPTH, STRETCH = "depth", "stretch_number"
CURVES = (
    RESISTANCE,
    UNCERTAINTY,
    "total_resistance",
    "sleeve_friction",
    "excess_pore_pressure",
    "cone_factor_at_tip",
    "cone_factor_around_tip",
    "strength",
    "vertical_stress",
)


def joined(dataset: xr.Dataset) -> xr.Dataset:
    """The curves of a result with stretches joined, over depth and a dim `sounding`.

    Returns:
        The curves, and `overlap_difference` [Pa] of neighbours; the coordinate `case` holds the
        number of the first case of each sounding.
    """
    # A collected file leaves out what no case has, a half width say.
    cases = by_case(dataset[[name for name in ("status", *CURVES) if name in dataset]])
    groups = [cases.drop_vars("status").isel(case=group) for group in _groups(dataset)]
    return xr.concat([_as_one(group) for group in groups], dim="sounding")


def _groups(dataset: xr.Dataset) -> list[np.ndarray]:
    """The numbers of the cases that are stretches of one sounding, for each sounding."""
    numbers, dims = np.arange(dataset["status"].size), case_dims(dataset)
    if STRETCH in dims:
        by_dim = np.moveaxis(numbers.reshape(dataset["status"].shape), dims.index(STRETCH), -1)
        return list(by_dim.reshape(-1, by_dim.shape[-1]))
    return list(numbers[:, None])


def _as_one(stretches: xr.Dataset) -> xr.Dataset:
    """One sounding of its stretches, over the depths that one of them has."""
    mean = stretches.mean("case", skipna=True)
    resistance = stretches[RESISTANCE]
    count = resistance.notnull().sum("case")
    half = 0.5 * (resistance.max("case") - resistance.min("case"))
    overlaps = (count > 1).values
    difference = np.zeros(overlaps.size)
    # Neighbouring samples of an overlap share one number: single samples differ by noise.
    edges = np.flatnonzero(np.diff(np.concatenate([[False], overlaps, [False]])))
    for begin, end in edges.reshape(-1, 2):
        difference[begin:end] = np.sqrt(np.mean(half.values[begin:end] ** 2))
    of_stretches = mean.get(UNCERTAINTY, xr.full_like(mean[RESISTANCE], np.nan))
    mean[UNCERTAINTY] = np.hypot(of_stretches, xr.DataArray(difference, dims=DEPTH))
    mean["overlap_difference"] = DEPTH, difference
    for name in mean.data_vars:
        mean[name].attrs = stretches.get(name, mean[name]).attrs
    return mean.assign_coords(case=int(stretches["case"][0]))


KILO = 1e3
JOINED = "Stretches run side by side are joined; where two overlap the curve is their mean."
HEIGHT = 5.0
"""Of the figure [inch]: depth needs room."""


@STYLED
def sounding_figure(dataset: xr.Dataset) -> Figure | None:
    """Strength, net resistance and local cone factor of each sounding over depth.

    Stretches of one sounding are joined. The band holds the resistance with 95 % where its error is
    known.
    """
    if not ({RESISTANCE, "status"} <= set(dataset) and DEPTH in dataset.dims):
        return None
    studied = Studied.of(dataset)
    soundings = joined(dataset)
    figure = Figure()
    figure.set_figheight(HEIGHT)
    strength, resistance, factor = figure.subplots(1, 3, sharey=True)
    count = soundings.sizes["sounding"]
    shown = chosen(count)
    # The stretches of a sounding, each to a depth, are one curve.
    names = [
        name for name in (studied.varied if studied else ()) if name not in (STRETCH, "to_depth")
    ]
    for rank, number in enumerate(shown):
        sounding = soundings.isel(sounding=number)
        colour = series_colour(rank, len(shown))
        _draw(resistance, sounding, RESISTANCE, colour, KILO, UNCERTAINTY)
        _draw(strength, sounding, "strength", colour, KILO)
        _draw(factor, sounding, "cone_factor_at_tip", colour)
        strength.lines[-1].set_label(
            "" if studied is None else studied.label(int(sounding["case"]), names)
        )
    for axes, label in (
        (strength, "strength $s_{\\mathrm{u}}$ [kPa]"),
        (resistance, "net resistance [kPa]"),
        (factor, "net resistance over\nstrength at the tip [-]"),
    ):
        axes.set(xlabel=label, xlim=(0.0, None))
    strength.set_ylabel("depth of the tip [m]")
    strength.invert_yaxis()
    if count > 1:
        legend_above(figure, strength)
    has_band = bool(np.isfinite(soundings[UNCERTAINTY]).any())
    return captioned(
        figure,
        dataset,
        of_half_widths(dataset, "Bands hold the resistance", are_shown=has_band),
        JOINED if STRETCH in dataset["status"].dims else "",
        left_out(count - len(shown), "soundings"),
    )


def _draw(
    axes: Axes,
    sounding: xr.Dataset,
    name: str,
    colour: str,
    scale: float = 1.0,
    half_width: str | None = None,
) -> None:
    depth, values = sounding[DEPTH].values, sounding[name].values / scale
    axes.plot(values, depth, color=colour, lw=0.8)
    if half_width is not None:
        width = sounding[half_width].values / scale
        axes.fill_betweenx(depth, values - width, values + width, color=colour, alpha=0.25, lw=0)
