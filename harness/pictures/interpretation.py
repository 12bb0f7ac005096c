"""Pictures of interpreted cone tests by depth: what was measured, Nkt, su and its error."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.pictures.drawing.plot_parts import STYLED, series_colour, shade
from mpm_warp.grid.fitted import Floats

KILO = 1e3
MEASURED = {
    "net_resistance": "$q_{\\mathrm{net}}$",
    "sleeve_friction": "$f_{\\mathrm{s}}$",
    "pore_pressure": "$u_2$",
}
"""Symbols of what is measured."""
SIZE = 9.0, 6.0
"""Of the figure [inch]: depth needs room."""
NOT_READ = "0.92"
"""Shade of depths that have no strength."""
NEAR_BORDER = "#f6e6c8"
"""Shade of depths that feel another layer."""
SHADES_MEAN = "Grey: no strength, the table says why; brown: feels another layer."
LEAST_SHARE = 0.03
"""Causes with less of the error on average are drawn as one."""
BAND = shade(0.3)
"""Colour of medians and bands."""
GAP = 5.0
"""Steps of depth that are a gap, over the usual one."""
AROUND = 1.0
"""Length above and below the layers that is shown [m]."""


@STYLED
def interpretation_figure(found: xr.Dataset, points: Sequence[tuple[float, float]] = ()) -> Figure:
    """Four panels by depth: net resistance, sleeve and pore pressure; Nkt; su; shares of its error.

    Bands hold 90 %. Depths without a strength are grey, those that feel another layer brown.

    Args:
        found: what `interpret` gives.
        points: depth [m] and strength [Pa] of a laboratory, beside it.
    """
    found = _broken(found)
    figure = Figure(figsize=SIZE, layout="constrained")
    test, factor, strength, shares = figure.subplots(1, 4, sharey=True)
    depth = found.depth.values
    for place, (name, label) in enumerate(MEASURED.items()):
        scale, text = (10.0, f"{label} x 10") if name == "sleeve_friction" else (1.0, label)
        colour = series_colour(place, len(MEASURED))
        test.plot(scale * found[name] / KILO, depth, color=colour, lw=0.8, label=text)
    if "sharpened_resistance" in found:
        sharp, text = found.sharpened_resistance / KILO, f"{MEASURED['net_resistance']} sharpened"
        test.plot(sharp, depth, "k--", lw=0.8, label=text)
    test.set_xlabel("[kPa]")
    here = found.reason.values == 0
    if not here.any():
        here[:] = True
    test.set_xlim(0.0, 1.2 * float(np.nanmax(found.net_resistance[here])) / KILO)
    _band(factor, depth, found.resistance_factor.values, "$N_{\\mathrm{kt}}$ [-]", BAND)
    _band(strength, depth, found.strength.values / KILO, "$s_{\\mathrm{u}}$ [kPa]", BAND)
    if points:
        at, values = np.array(points).T
        strength.plot(values / KILO, at, "ko", ms=4, label="laboratory")
        _legend(strength, 1)
    _shares(shares, found)
    _shade(figure.axes, found)
    _downward(test, [found])
    _legend(test, 3)
    words = f"{found.attrs['title']}. Bands hold 90 %. {SHADES_MEAN}"
    figure.supxlabel(words, fontsize=7)
    return figure


@STYLED
def check_figure(found: xr.Dataset) -> Figure:
    """Net resistance, sleeve and pore pressure, measured and simulated; the misfit, by depth."""
    figure = Figure(figsize=SIZE, layout="constrained")
    *panels, misfit = figure.subplots(1, 4, sharey=True)
    depth = found.depth.values
    for axes, (name, label) in zip(panels, MEASURED.items(), strict=True):
        axes.plot(found[name] / KILO, depth, "k", lw=1.0, label="measured")
        simulated, colour = found[f"simulated_{name}"] / KILO, series_colour(0, 2)
        axes.plot(simulated, depth, color=colour, lw=0.8, label="simulated")
        axes.set_xlabel(f"{label} [kPa]")
    panels[0].plot(found.expected_resistance / KILO, depth, "k--", lw=0.8, label="expected")
    panels[0].legend(frameon=False, fontsize=7)
    net, error = found.net_resistance, found.total_resistance_error
    panels[0].fill_betweenx(depth, (net - error) / KILO, (net + error) / KILO, color="0.8", lw=0)
    for axes in panels:
        axes.set_xlim(left=0.0)
    misfit.plot(100.0 * found.misfit, depth, "k", lw=0.8)
    misfit.axvline(0.0, color="k", lw=0.4)
    misfit.set_xlabel("misfit of $q_{\\mathrm{net}}$ [%]")
    _shade(figure.axes, found)
    _downward(panels[0], [found])
    words = (
        "Simulated: in the ground of the medians; misfit: over expected, less 1; band: test, 95 %."
    )
    figure.supxlabel(f"{found.attrs['title']}. {words} {SHADES_MEAN}", fontsize=7)
    return figure


@STYLED
def soundings_figure(found: Sequence[xr.Dataset]) -> Figure:
    """Several tests of a site: net resistance and su by depth, each su with its band of 90 %."""
    figure = Figure(figsize=SIZE, layout="constrained")
    test, strength = figure.subplots(1, 2, sharey=True)
    for place, one in enumerate(map(_broken, found)):
        colour = series_colour(place, max(len(found), 2))
        own = one.net_resistance.where(one.reason == 0) / KILO
        test.plot(own, one.depth, color=colour, lw=0.8, label=one.attrs["title"])
        _band(strength, one.depth.values, one.strength.values / KILO, "", colour)
    test.set_xlabel(f"{MEASURED['net_resistance']} [kPa]")
    strength.set_xlabel("$s_{\\mathrm{u}}$ [kPa]")
    for axes in (test, strength):
        axes.autoscale(axis="x")
        axes.set_xlim(left=0.0)
    _downward(test, found)
    _legend(test, 3)
    figure.supxlabel("Bands hold 90 % of each test by itself.", fontsize=7)
    return figure


def _broken(found: xr.Dataset) -> xr.Dataset:
    """With a depth without values at the top of each gap: no line is drawn across it."""
    depth = found.depth.values
    step = np.diff(depth, append=depth[-1])
    tops = depth[step > GAP * float(np.median(step))]
    return found.reindex(depth=np.union1d(depth, np.nextafter(tops, np.inf)))


def _legend(axes: Axes, columns: int) -> None:
    """Above the panel, where it hides nothing."""
    axes.legend(
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        frameon=False,
        fontsize=6,
        ncols=columns,
        columnspacing=1.0,
    )


def _downward(axes: Axes, found: Sequence[xr.Dataset]) -> None:
    """Depth grows downward, around the layers that were asked for."""
    asked = np.concatenate([_asked(sounding) for sounding in found])
    axes.set_ylabel("depth of the tip [m]")
    deepest = max(float(sounding.depth.max()) for sounding in found)
    axes.set_ylim(min(deepest, asked.max() + AROUND), max(0.0, asked.min() - AROUND))


def _asked(found: xr.Dataset) -> Floats:
    """Depths that are in a layer; all where none is."""
    meanings = found.reason.attrs["flag_meanings"].split()
    inside: Floats = found.depth.values[found.reason.values != meanings.index("no_layer")]
    return inside if len(inside) else np.asarray(found.depth.values)


def _band(axes: Axes, depth: Floats, values: Floats, label: str, colour: str) -> None:
    """The median of three percentiles, and a band between the outer ones."""
    low, middle, high = values.T
    axes.fill_betweenx(depth, low, high, color=colour, alpha=0.25, lw=0)
    axes.plot(middle, depth, color=colour, lw=1.0)
    axes.set(xlabel=label, xlim=(0.0, 1.1 * float(np.nanmax(high, initial=1e-9))))


def _shares(axes: Axes, found: xr.Dataset) -> None:
    """Shares of the error, side by side to 100 %, the largest first."""
    shares = found.error_share.dropna("cause", how="all").fillna(0.0).where(found.reason == 0)
    means = shares.mean("depth")
    order = list(means.sortby(-means).cause.values)
    large = [cause for cause in order if float(means.sel(cause=cause)) >= LEAST_SHARE]
    small = [cause for cause in order if cause not in large]
    columns = [shares.sel(cause=cause).values for cause in large]
    if small:
        columns.append(shares.sel(cause=small).sum("cause", skipna=False).values)
    names = [cause.replace("_", " ") for cause in large] + (["others"] if small else [])
    begin = np.zeros(found.sizes["depth"])
    for place, (name, column) in enumerate(zip(names, columns, strict=True)):
        end = begin + 100.0 * column
        colour = series_colour(place, len(names))
        axes.fill_betweenx(found.depth, begin, end, color=colour, lw=0, label=name)
        begin = end
    axes.set(xlim=(0.0, 100.0), xlabel="share of the error [%]")
    if names:
        _legend(axes, 2)


def _shade(panels: Sequence[Axes], found: xr.Dataset) -> None:
    """Shades over depths that feel another layer, and over those without a strength."""
    depth = found.depth.values
    for where, colour in ((found.near_border, NEAR_BORDER), (found.reason, NOT_READ)):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], where.values != 0, [0]]).astype(int)))
        for begin, end in edges.reshape(-1, 2):
            top, bottom = depth[begin], depth[min(end, len(depth) - 1)]
            for axes in panels:
                axes.axhspan(top, bottom, color=colour, lw=0, zorder=0)
