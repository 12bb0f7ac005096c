"""The picture of soundings: depth downward, strength, resistance and cone factor side by side.

The stretches of a sounding, cut at depths and run side by side, are joined to one curve. Where two
overlap the curve is their mean, and half of their difference, as a root mean square over the
overlap, is a part of its half width.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from harness.archive.conventions import by_case, case_dims
from harness.pictures.drawing.caption import captioned, left_out, of_half_widths
from harness.pictures.drawing.plot_parts import KILO, STYLED, panels, runs, series
from harness.pictures.studied import Studied

RESISTANCE, UNCERTAINTY = "net_resistance", "net_resistance_uncertainty"
DEPTH, STRETCH = "depth", "stretch_number"
LEFT_TO_ONE = (STRETCH, "to_depth")
"""Parameters of a stretch, which its sounding does not have."""
CURVES = (RESISTANCE, UNCERTAINTY, "cone_factor_at_tip", "strength")
JOINED = "Stretches run side by side are joined; where two overlap the curve is their mean."
HEIGHT = 5.0
"""Of the figure [inch]: depth needs room."""


def joined(dataset: xr.Dataset) -> xr.Dataset:
    """The curves that are drawn of a result, with stretches joined, by depth and a dim `sounding`.

    Beside them `overlap_difference` [Pa] of neighbours; the coordinate `case` holds the number of
    the first case of each sounding.
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
    mean = stretches.mean("case", keep_attrs=True)
    resistance = stretches[RESISTANCE]
    count = resistance.notnull().sum("case")
    half = 0.5 * (resistance.max("case") - resistance.min("case"))
    difference = np.zeros(count.size)
    # Neighbouring samples of an overlap share one number: single samples differ by noise.
    for overlap in runs(count.values > 1):
        difference[overlap] = np.sqrt(np.mean(half.values[overlap] ** 2))
    of_stretches = mean.get(UNCERTAINTY, xr.full_like(mean[RESISTANCE], np.nan))
    mean[UNCERTAINTY] = np.hypot(of_stretches, xr.DataArray(difference, dims=DEPTH))
    mean["overlap_difference"] = DEPTH, difference
    return mean.assign_coords(case=int(stretches["case"][0]))


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
    figure, (strength, resistance, factor) = panels(3, HEIGHT, sharey=True)
    count = soundings.sizes["sounding"]
    shown = series(count)
    names = [name for name in (studied.varied if studied else ()) if name not in LEFT_TO_ONE]
    for place, colour, _, _ in shown:
        sounding = soundings.isel(sounding=place)
        label = studied.label(int(sounding["case"]), names) if studied else ""
        depth = sounding[DEPTH]
        net, half_width = sounding[RESISTANCE] / KILO, sounding[UNCERTAINTY] / KILO
        strength.plot(sounding["strength"] / KILO, depth, color=colour, lw=0.8, label=label)
        resistance.plot(net, depth, color=colour, lw=0.8)
        band = depth, net - half_width, net + half_width
        resistance.fill_betweenx(*band, color=colour, alpha=0.25, lw=0)
        factor.plot(sounding["cone_factor_at_tip"], depth, color=colour, lw=0.8)
    for axes, label in (
        (strength, "strength $s_{\\mathrm{u}}$ [kPa]"),
        (resistance, "net resistance [kPa]"),
        (factor, "net resistance over\nstrength at the tip [-]"),
    ):
        axes.set(xlabel=label, xlim=(0.0, None))
    strength.set_ylabel("depth of the tip [m]")
    strength.invert_yaxis()
    has_band = bool(np.isfinite(soundings[UNCERTAINTY]).any())
    return captioned(
        figure,
        dataset,
        of_half_widths(dataset, "Bands hold the resistance", are_shown=has_band),
        JOINED if STRETCH in dataset["status"].dims else "",
        left_out(count - len(shown), "soundings"),
        legend=strength if count > 1 else None,
    )
