"""Pictures of interpreted cone tests by depth: what was measured, Nkt, su and its error."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.pictures.drawing.plot_parts import KILO, STYLED, runs, series, series_colour, shade
from mpm_warp.grid.fitted import Floats

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
    figure, (test, factor, strength, shares) = _panels(4)
    depth = found.depth.values
    for (name, label), line in zip(MEASURED.items(), series(len(MEASURED)), strict=True):
        scale, text = (10.0, f"{label} x 10") if name == "sleeve_friction" else (1.0, label)
        test.plot(scale * found[name] / KILO, depth, color=line.colour, lw=0.8, label=text)
    if "sharpened_resistance" in found:
        sharp, text = found.sharpened_resistance / KILO, f"{MEASURED['net_resistance']} sharpened"
        test.plot(sharp, depth, "k--", lw=0.8, label=text)
    test.set_xlabel("[kPa]")
    here = found.reason.values == 0
    shown = found.net_resistance.values[here if here.any() else ...]
    test.set_xlim(0.0, 1.2 * float(np.nanmax(shown)) / KILO)
    _band(factor, depth, found.resistance_factor.values, "$N_{\\mathrm{kt}}$ [-]", BAND)
    _band(strength, depth, found.strength.values / KILO, "$s_{\\mathrm{u}}$ [kPa]", BAND)
    if points:
        at, values = np.array(points).T
        strength.plot(values / KILO, at, "ko", ms=4, label="laboratory")
        _legend(strength, 1)
    _shares(shares, found)
    _shade(figure.axes, found)
    _legend(test, 3)
    return _finished(figure, [found], f"{found.attrs['title']}. Bands hold 90 %. {SHADES_MEAN}")


@STYLED
def check_figure(found: xr.Dataset) -> Figure:
    """Net resistance, sleeve and pore pressure, measured and simulated; the misfit, by depth."""
    figure, (*tests, misfit) = _panels(4)
    depth = found.depth.values
    for axes, (name, label) in zip(tests, MEASURED.items(), strict=True):
        axes.plot(found[name] / KILO, depth, "k", lw=1.0, label="measured")
        simulated, colour = found[f"simulated_{name}"] / KILO, series_colour(0, 2)
        axes.plot(simulated, depth, color=colour, lw=0.8, label="simulated")
        axes.set_xlabel(f"{label} [kPa]")
    net = tests[0]
    net.plot(found.expected_resistance / KILO, depth, "k--", lw=0.8, label="expected")
    net.legend(frameon=False, fontsize=7)
    low, high = (
        (found.net_resistance + side * found.total_resistance_error) / KILO for side in (-1, 1)
    )
    net.fill_betweenx(depth, low, high, color="0.8", lw=0)
    for axes in tests:
        axes.set_xlim(left=0.0)
    misfit.plot(100.0 * found.misfit, depth, "k", lw=0.8)
    misfit.axvline(0.0, color="k", lw=0.4)
    misfit.set_xlabel("misfit of $q_{\\mathrm{net}}$ [%]")
    _shade(figure.axes, found)
    words = (
        "Simulated: in the ground of the medians; misfit: over expected, less 1; band: test, 95 %."
    )
    return _finished(figure, [found], f"{found.attrs['title']}. {words} {SHADES_MEAN}")


@STYLED
def soundings_figure(found: Sequence[xr.Dataset]) -> Figure:
    """Several tests of a site: net resistance and su by depth, each su with its band of 90 %."""
    figure, (test, strength) = _panels(2)
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
    _legend(test, 3)
    return _finished(figure, found, "Bands hold 90 % of each test by itself.")


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=SIZE)
    return figure, list(figure.subplots(1, count, sharey=True))


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


def _finished(figure: Figure, found: Sequence[xr.Dataset], words: str) -> Figure:
    """With a caption; depth grows downward, around the layers that were asked for."""
    asked = np.concatenate([_asked(sounding) for sounding in found])
    deepest = max(float(sounding.depth.max()) for sounding in found)
    axes = figure.axes[0]
    axes.set_ylabel("depth of the tip [m]")
    axes.set_ylim(min(deepest, asked.max() + AROUND), max(0.0, asked.min() - AROUND))
    figure.supxlabel(words, fontsize=7)
    return figure


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
    shares = shares.sortby(-means)
    small = means.sortby(-means).values < LEAST_SHARE
    names = [str(cause).replace("_", " ") for cause in shares.cause.values[~small]]
    columns = list(shares.values.T[~small])
    if small.any():
        names.append("others")
        columns.append(shares.values.T[small].sum(axis=0))
    ends = 100.0 * np.cumsum([np.zeros(found.sizes["depth"]), *columns], axis=0)
    for name, begin, end, line in zip(
        names, ends, ends[1:], series(len(names), len(names)), strict=False
    ):
        axes.fill_betweenx(found.depth, begin, end, color=line.colour, lw=0, label=name)
    axes.set(xlim=(0.0, 100.0), xlabel="share of the error [%]")
    if names:
        _legend(axes, 2)


def _shade(panels: Sequence[Axes], found: xr.Dataset) -> None:
    """Shades over depths that feel another layer, and over those without a strength."""
    depth = found.depth.values
    for where, colour in ((found.near_border, NEAR_BORDER), (found.reason, NOT_READ)):
        for run in runs(where.values != 0):
            for axes in panels:
                bottom = depth[min(run.stop, len(depth) - 1)]
                axes.axhspan(depth[run.start], bottom, color=colour, lw=0, zorder=0)
