"""The picture of the measured sites: Nkt as measured, and as computed, of each."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from harness.pictures.drawing.caption import caption
from harness.pictures.drawing.plot_parts import legend_above, panels
from harness.pictures.drawing.style import ACCENT, FAINT, INK, LIGHT, STYLED

BANDS = (
    ("predicted", "with the model factor by the other sites", LIGHT),
    ("computed", "computed, before it", ACCENT),
)
"""Bands, the wide ones first, with label and colour."""
CAPTION = (
    "A dot is the mean of ln Nkt at a site, its bar 1.645 deviations over the depths. Sites by "
    "their number in the database CLAY/10/7490 (Ching & Phoon 2014). Bands hold 90 %: of the "
    "depths; before the model factor, of the mean."
)


@STYLED
def evidence_figure(found: xr.Dataset) -> Figure:
    """Nkt of each site with its bar, before two bands. `found` is by site and percentile."""
    figure, (axes,) = panels()
    at = np.arange(found.sizes["site"])
    for name, label, colour in BANDS:
        low, middle, high = found[name].values.T
        axes.bar(at, high - low, 0.9, low, color=colour, alpha=FAINT, lw=0, label=label)
        axes.hlines(middle, at - 0.45, at + 0.45, color=colour)
    low, middle, high = found.measured.values.T
    bars = np.stack([middle - low, high - middle])
    axes.errorbar(at, middle, bars, fmt="o", color=INK, label="measured")
    axes.set_xticks(at, found.site.values)
    axes.set(
        yscale="log",
        xlabel="site",
        ylabel="$N_{\\mathrm{kt}}$ by the mobilised $s_{\\mathrm{u}}$ [-]",
    )
    axes.set_yticks([5, 10, 20, 50, 100])
    axes.yaxis.set_major_formatter(ScalarFormatter())
    axes.minorticks_off()
    axes.grid(visible=False, axis="x")
    legend_above(figure, axes)
    caption(figure, CAPTION)
    return figure
