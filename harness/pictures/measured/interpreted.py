"""Pictures of interpreted cone tests by depth, downward."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.pictures.drawing.caption import caption
from harness.pictures.drawing.plot_parts import once, panels, runs, series
from harness.pictures.drawing.quantities import Floats
from harness.pictures.drawing.style import ACCENT, BAND, BOLD, FAILED, INK, LIGHT, PALE, STYLED

KILO = 1e3
MEASURED = {
    "net_resistance": "$q_{\\mathrm{net}}$",
    "sleeve_friction": "$f_{\\mathrm{s}}$",
    "pore_pressure": "$u_2$",
}
BESIDE = {"sleeve_friction": "sleeve", "pore_pressure": "pore_pressure"}
"""Measured quantities that are compared with what the inputs allow, and their names there."""
MARK: Mapping[str, Any] = {"color": FAILED, "lw": BOLD, "solid_capstyle": "round", "zorder": 3}
"""Style of measured values beyond what the inputs allow."""
SHADES = (
    "Grey: no strength, the table says why, and lines may leave the panel; hatched: feels another "
    "layer; red and thick: beyond what the inputs allow."
)
CHECKED = (
    "Simulated: in the ground of the medians; misfit: simulated over expected, less 1; band: "
    "95 % of the test."
)
INDEX_SCALE, RATIO_LIMITS = 4.0, (-0.3, 1.4)
"""Ic over the first is drawn beside Bq, within the limits of Bq of clay."""


@STYLED
def interpretation_figure(found: xr.Dataset, points: Sequence[tuple[float, float]] = ()) -> Figure:
    """Five panels by depth: the measured test, Bq and Ic, Nkt, su, and the shares of its error.

    Bands hold 90 %, that of Bq what the inputs allow. `found` is the result of `interpret`;
    `points` are depths [m] and strengths [Pa] by a laboratory.
    """
    found = _with_gaps(found)
    figure, (test, ratios, factor, strength, shares) = panels(5, by_depth=True, sharey=True)
    depth = found.depth.values
    for (name, label), line in series(MEASURED.items()):
        scale, text = (10.0, f"{label} x 10") if name == "sleeve_friction" else (1.0, label)
        entry = text if found[name].notnull().any() else ""
        test.plot(scale * found[name] / KILO, depth, **line.line, label=entry)
        if name in BESIDE:
            test.plot(scale * _beyond(found, name) / KILO, depth, **MARK)
    test.plot(found.water_pressure / KILO, depth, color=INK, ls=":", label="$u_0$")
    if "sharpened_resistance" in found:
        sharp, text = found.sharpened_resistance / KILO, f"{MEASURED['net_resistance']} sharpened"
        test.plot(sharp, depth, color=INK, ls="--", label=text)
    test.set_xlabel("measured [kPa]")
    here = found.reason.values == 0
    shown = np.array([line.get_xdata() for line in test.get_lines()], dtype=float)
    shown = shown[:, here] if here.any() else shown
    test.set_xlim(*(1.05 * np.array([min(0.0, np.nanmin(shown)), np.nanmax(shown)])))
    _ratios(ratios, found)
    _band(factor, depth, found.resistance_factor.values, "$N_{\\mathrm{kt}}$ [-]")
    _band(strength, depth, found.strength.values / KILO, "$s_{\\mathrm{u}}$ [kPa]")
    for title in found.layer.values:
        own = found.sel(layer=title)
        low, middle, high = own.line_strength.values.T / KILO
        strength.plot(middle, own.line_depth, color=INK, label=once(strength, "line"))
        for end in (low, high):
            strength.plot(end, own.line_depth, color=INK, ls=":")
    if points:
        at, values = np.array(points).T
        strength.plot(values / KILO, at, "o", color=INK, label="laboratory", clip_on=False)
        strength.set_xlim(right=max(strength.get_xlim()[1], 1.05 * float(values.max()) / KILO))
    _legend(strength)
    _shares(shares, found)
    _shade(figure.axes, found)
    _legend(test)
    words = (
        f"{found.attrs['title']}. Bands hold 90 %, that of Bq 98 %, dotted lines that of the line. "
        f"{SHADES}"
    )
    return _finished(figure, [found], words, [depth for depth, _ in points])


@STYLED
def check_figure(found: xr.Dataset) -> Figure:
    """Net resistance, sleeve and pore pressure by depth, measured and simulated, and the misfit."""
    figure, (*tests, misfit) = panels(4, by_depth=True, sharey=True)
    depth = found.depth.values
    for axes, (name, label) in zip(tests, MEASURED.items(), strict=True):
        axes.plot(found[name] / KILO, depth, color=INK, label="measured")
        simulated = found[f"simulated_{name}"] / KILO
        axes.plot(simulated, depth, color=LIGHT, ls="--", label="simulated")
        axes.set_xlabel(f"{label} [kPa]")
    net = tests[0]
    net.plot(found.expected_resistance / KILO, depth, color=INK, ls=":", label="expected")
    _legend(net)
    measured, error = found.net_resistance / KILO, found.total_resistance_error / KILO
    net.fill_betweenx(depth, measured - error, measured + error, color=INK, **BAND)
    for axes in tests[:2]:  # u2 may be below 0
        axes.set_xlim(left=0.0)
    misfit.plot(100.0 * found.misfit, depth, color=INK)
    misfit.axvline(0.0, color=INK)
    misfit.set_xlabel("misfit of $q_{\\mathrm{net}}$ [%]")
    _shade(figure.axes, found)
    return _finished(figure, [found], f"{found.attrs['title']}. {CHECKED} {SHADES}")


@STYLED
def soundings_figure(
    found: Sequence[xr.Dataset], points: Sequence[Sequence[tuple[float, float]]]
) -> Figure:
    """Several tests of a site: net resistance and su over depth, su with a band of 90 %.

    `points` are depths [m] and strengths [Pa] by a laboratory, beside each of the tests.
    """
    figure, (test, strength) = panels(2, by_depth=True, sharey=True)
    titles = [one.attrs["title"] for one in found]
    for one, line in series(map(_with_gaps, found), None):
        title, site = one.attrs["title"], one.attrs["site"]
        name = title if titles.count(title) == 1 else f"{title} ({site})"
        resistance = one.net_resistance.where(one.reason == 0) / KILO
        test.plot(resistance, one.depth, **line.line, label=name)
        _band(strength, one.depth.values, one.strength.values / KILO, "", **line.line)
        for depth, value in points[line.place]:
            strength.plot(value / KILO, depth, **line.style, clip_on=False)
    test.set_xlabel(f"{MEASURED['net_resistance']} [kPa]")
    strength.set_xlabel("$s_{\\mathrm{u}}$ [kPa]")
    for axes in (test, strength):
        axes.autoscale(axis="x")
        axes.set_xlim(left=0.0)
    _legend(test)
    words = "Bands hold 90 % of each test by itself; points are laboratory tests beside it."
    depths = [depth for own in points for depth, _ in own]
    return _finished(figure, found, words if depths else words.partition(";")[0] + ".", depths)


def _with_gaps(found: xr.Dataset) -> xr.Dataset:
    """A result with NaN at the top of each gap of more than five steps, so that lines end there."""
    depth = found.depth.values
    step = np.diff(depth, append=depth[-1])
    tops = depth[step > 5.0 * float(np.median(step))]
    return found.reindex(depth=np.union1d(depth, np.nextafter(tops, np.inf)))


def _legend(axes: Axes) -> None:
    """Put the legend above the panel, where it hides nothing."""
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0))


def _finished(
    figure: Figure, found: Sequence[xr.Dataset], words: str, others: Sequence[float] = ()
) -> Figure:
    """Add a caption; limit the depth, downward, to 1 m above and below the layers of the sites.

    `others` are more depths [m] that have to be in the picture.
    """
    inside = np.concatenate([*(_depths_in_layers(sounding) for sounding in found), others])
    deepest = max([*(float(sounding.depth.max()) for sounding in found), *others])
    axes = figure.axes[0]
    axes.set_ylabel("depth of the tip [m]")
    axes.set_ylim(min(deepest or 1.0, inside.max() + 1.0), max(0.0, inside.min() - 1.0))
    caption(figure, words)
    return figure


def _depths_in_layers(found: xr.Dataset) -> Floats:
    """The depths that are in a layer of the site; all depths if none is."""
    meanings = found.reason.attrs["flag_meanings"].split()
    inside = found.depth.values[found.reason.values != meanings.index("no_layer")]
    return np.asarray(inside if len(inside) else found.depth.values)


def _band(
    axes: Axes, depth: Floats, values: Floats, label: str, color: str = ACCENT, ls: str = "-"
) -> None:
    """Draw the second of three percentiles as a line, and a band between the others."""
    low, middle, high = values.T
    axes.fill_betweenx(depth, low, high, color=color, **BAND)
    axes.plot(middle, depth, color=color, ls=ls)
    axes.set_xlabel(label)
    if np.isfinite(high).any():
        axes.set_xlim(0.0, 1.1 * float(np.nanmax(high)))


def _beyond(found: xr.Dataset, name: str) -> xr.DataArray:
    """A measured quantity where it is beyond what the inputs allow, NaN elsewhere."""
    beside = found.measure_at_depth.sel(measure=BESIDE[name])
    measured, least, largest = (beside.isel(bound=place) for place in range(3))
    return found[name].where((measured < least) | (measured > largest))


def _ratios(axes: Axes, found: xr.Dataset) -> None:
    """Draw Bq, with what the inputs allow, and Ic."""
    depth, net = found.depth.values, found.net_resistance
    beside = found.measure_at_depth.sel(measure="pore_pressure") / net
    low, high = beside.sel(bound="least"), beside.sel(bound="largest")
    axes.fill_betweenx(depth, low, high, color=ACCENT, **BAND)
    axes.plot(found.pore_pressure_ratio, depth, color=ACCENT, label="$B_{\\mathrm{q}}$")
    excess = _beyond(found, "pore_pressure") - found.water_pressure
    axes.plot(excess / net, depth, **MARK)
    index, text = found.soil_index / INDEX_SCALE, "$I_{\\mathrm{c}}$ / 4"
    axes.plot(index, depth, color=INK, ls="--", label=text)
    axes.set(xlim=RATIO_LIMITS, xlabel="measured [-]")
    _legend(axes)


def _shares(axes: Axes, found: xr.Dataset) -> None:
    """Draw the shares of the error, the largest first; causes below 3 % are added up."""
    shares = found.error_share.dropna("cause", how="all").fillna(0.0).where(found.reason == 0)
    means = shares.mean("depth")
    shares = shares.sortby(-means)
    small = means.sortby(-means).values < 0.03
    names = [str(cause).replace("_", " ") for cause in shares.cause.values[~small]]
    columns = list(shares.values.T[~small])
    if small.any():
        names.append("others")
        columns.append(shares.values.T[small].sum(axis=0))
    ends = 100.0 * np.cumsum([np.zeros(found.sizes["depth"]), *columns], axis=0)
    for name, line in series(names, None):
        begin, end = ends[line.place : line.place + 2]
        axes.fill_betweenx(found.depth, begin, end, color=line.colour, lw=0, label=name)
    axes.set(xlim=(0.0, 100.0), xlabel="share of the error [%]")
    if names:
        _legend(axes)


def _shade(all_axes: Sequence[Axes], found: xr.Dataset) -> None:
    """Shade the depths that feel another layer, and those without a strength."""
    depth = found.depth.values
    hatched = {"fc": "none", "ec": LIGHT, "hatch": "///", **BAND}
    for where, look in ((found.near_border, hatched), (found.reason, {"color": PALE})):
        for run in runs(where.values != 0):
            for axes in all_axes:
                bottom = depth[min(run.stop, len(depth) - 1)]
                axes.axhspan(depth[run.start], bottom, zorder=0, **look)
