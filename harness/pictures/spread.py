"""The picture `spread`: a histogram, and the shares of the inputs in its variance."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from harness.archive.conventions import DISTRIBUTION, stated, varied_names
from harness.compare.spread import DEVIATIONS, Spread, spreads_of
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import panels
from harness.pictures.drawing.quantities import axis_label, named
from harness.pictures.drawing.style import ACCENT, BAND, INK, LIGHT, STYLED


@STYLED
def spread_figure(dataset: xr.Dataset) -> Figure | None:
    """A histogram of the first headline, and the shares of the inputs in its variance."""
    spread = next(iter(spreads_of(dataset)), None)
    if spread is None:
        return None
    figure, (counts, shares) = panels(2, width_ratios=(3, 2))
    _histogram(counts, spread)
    counts.set_xlabel(axis_label(dataset, spread.name))
    _bars(shares, dataset, spread)
    inputs = [
        f"{name.replace('_', ' ')}: {text}"
        for name in varied_names(dataset)
        if (text := dataset[name].attrs.get(DISTRIBUTION))
    ]
    below = ", and below it numerical U" if spread.numerical else ""
    return captioned(
        figure,
        dataset,
        f"{len(spread.values)} samples; {stated(spread.mean, spread.combined)} is the mean with "
        f"the {spread.called}.",
        f"Shade: 90 % of the samples; line: median; bar: mean, {spread.called}{below}.",
        f"Inputs: {'; '.join(inputs)}.",
    )


def _histogram(axes: Axes, spread: Spread) -> None:
    low, middle, high = spread.percentiles
    axes.hist(spread.values, bins="auto", color=ACCENT)
    axes.axvspan(low, high, color=LIGHT, zorder=0, **BAND)
    axes.axvline(middle, color=INK)
    top = axes.get_ylim()[1]
    for height, half in ((1.10, spread.combined), (1.03, DEVIATIONS * spread.numerical)):
        if half:
            axes.errorbar(spread.mean, height * top, xerr=half, fmt="o", color=INK)
    axes.set(ylim=(0.0, 1.17 * top), ylabel="samples")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _bars(axes: Axes, dataset: xr.Dataset, spread: Spread) -> None:
    shares = sorted(spread.shares.items(), key=lambda it: it[1])
    names = [named(dataset, cause) if cause in dataset else cause for cause, _ in shares]
    axes.barh(np.arange(len(shares)), [100.0 * share for _, share in shares], color=ACCENT)
    axes.set_yticks(np.arange(len(shares)), names)
    axes.set_xlabel("share of the variance [%]")
    if not shares:
        words = f"{spread.needed} cases are needed"
        axes.text(0.5, 0.5, words, ha="center", transform=axes.transAxes)
