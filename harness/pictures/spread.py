"""The picture of what is not known: a histogram of the result, and what its spread comes from."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.archive.conventions import DISTRIBUTION, stated, varied_names
from harness.compare.spread import DEVIATIONS, Spread, spreads_of
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import ACCENT, INK, LIGHT, STYLED
from harness.pictures.drawing.quantities import axis_label, named

HEIGHT = 3.4
"""Inches of the figure."""


def shows_spread(dataset: xr.Dataset) -> bool:
    """Whether parameters of a study were drawn from distributions."""
    return bool(spreads_of(dataset))


@STYLED
def spread_figure(dataset: xr.Dataset) -> Figure:
    """A histogram of the first headline, and the shares of the inputs in its variance."""
    spread = spreads_of(dataset)[0]
    figure = Figure()
    figure.set_figheight(HEIGHT)
    counts, shares = figure.subplots(1, 2, width_ratios=(3, 2))
    _histogram(counts, spread)
    counts.set_xlabel(axis_label(dataset, spread.name))
    _bars(shares, dataset, spread)
    told = [f"{name}: {text}" for name, text in _distributions(dataset).items()]
    write_caption(
        figure,
        dataset,
        f"{len(spread.values)} cases; {stated(spread.mean, spread.combined)} is the mean with the "
        "combined U.",
        "Shade: 90 % of the cases; line: median; bar: mean, combined U, and below it numerical U.",
        f"Inputs: {'; '.join(told)}.",
    )
    return figure


def _distributions(dataset: xr.Dataset) -> dict[str, str]:
    """Each input's distribution in words, by its name in words."""
    texts = {name: dataset[name].attrs.get(DISTRIBUTION) for name in varied_names(dataset)}
    return {name.replace("_", " "): text for name, text in texts.items() if text}


def _histogram(axes: Axes, spread: Spread) -> None:
    low, middle, high = spread.percentiles
    axes.hist(spread.values, bins="auto", color=ACCENT, alpha=0.7)
    axes.axvspan(low, high, color=LIGHT, alpha=0.25, lw=0, zorder=0)
    axes.axvline(middle, color=INK, lw=1.0)
    top = axes.get_ylim()[1]
    for height, half in ((1.10, spread.combined), (1.03, DEVIATIONS * spread.numerical)):
        if half:
            axes.errorbar(spread.mean, height * top, xerr=half, fmt="o", color=INK, ms=3, capsize=3)
    axes.set_ylim(0.0, 1.17 * top)
    axes.set_ylabel("cases")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _bars(axes: Axes, dataset: xr.Dataset, spread: Spread) -> None:
    """A bar for each share, the largest on top."""
    shares = sorted(spread.shares.items(), key=lambda it: it[1])
    names = [named(dataset, it) if it in dataset else it for it, _ in shares]
    axes.barh(np.arange(len(shares)), [100.0 * it for _, it in shares], color=ACCENT, alpha=0.7)
    axes.set_yticks(np.arange(len(shares)), names, fontsize=8)
    axes.set_xlabel("share of the variance [%]")
    if not shares:
        axes.text(0.5, 0.5, f"told from {spread.needed} cases on", ha="center")
