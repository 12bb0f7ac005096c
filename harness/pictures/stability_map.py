"""The stability map: a strip for each parameter, of single cases or of shares of random ones."""

import textwrap

import numpy as np
import xarray as xr
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from harness.archive.conventions import (
    COMPLETED,
    CRASHED,
    MISSING,
    TIMED_OUT,
    UNFINISHED,
    limits_of,
    spoken,
)
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import SHADES, STYLED
from harness.pictures.drawing.quantities import Texts
from harness.pictures.stability import Outcomes, Shares, Strip, shows_stability, stability_strips

STATUSES = {
    COMPLETED: ("o", "#009E73"),
    "inaccurate": ("^", "#E69F00"),
    UNFINISHED: ("p", "#F0E442"),
    "diverged": ("X", "#D55E00"),
    "refused": ("s", "#666666"),
    TIMED_OUT: ("D", "#56B4E9"),
    CRASHED: ("P", "#CC79A7"),
    "failed": ("v", "#0072B2"),
}
"""Marker and colour of each status, in Okabe and Ito's colours."""
OTHER = ("*", "black")
"""Those of any other status."""
STRIP_HEIGHT, LEGEND_HEIGHT, SCALE_HEIGHT = 0.62, 0.45, 0.6
"""Inches of a strip, of the legend above, and of the scale of colours and the caption each."""
LEFT, RIGHT = 0.18, 0.6
"""Where strips begin and end, of the page's width: names stand before them, words behind."""
BESIDE = 46
"""Letters of a line beside a strip."""


@STYLED
def stability_figure(dataset: xr.Dataset) -> Figure | None:
    """A strip for each parameter: of single cases, or of the shares of random ones."""
    if not shows_stability(dataset):
        return None
    rows = stability_strips(dataset)
    height = STRIP_HEIGHT * len(rows) + LEGEND_HEIGHT + 2 * SCALE_HEIGHT
    with rc_context({"figure.constrained_layout.use": False}):
        figure = Figure(figsize=(Figure().get_figwidth(), height))
    all_axes = figure.subplots(len(rows), 1, squeeze=False)[:, 0]
    top, bottom = 1 - LEGEND_HEIGHT / height, 2 * SCALE_HEIGHT / height
    figure.subplots_adjust(left=LEFT, right=RIGHT, bottom=bottom, top=top, hspace=1.0)
    for axes, row in zip(all_axes, rows, strict=True):
        axes.spines[["top", "right", "left"]].set_visible(False)
        label = textwrap.fill(row.values.label, 17)
        axes.set_ylabel(label, rotation=0, ha="right", va="center", fontsize=7, labelpad=8)
        axes.tick_params(axis="x", labelsize=6, pad=1)
        if isinstance(row, Strip):
            _draw_strip(axes, row)
        else:
            _draw_shares(axes, row)
        text = "\n".join(textwrap.fill(line, BESIDE, max_lines=2) for line in row.beside)
        axes.text(1.03, 0.5, text, transform=axes.transAxes, va="center", fontsize=6)
    limits = limits_of(dataset).items()
    limit = " or ".join(f"{spoken(name)} over its limit of {size:g}" for name, size in limits)
    outcomes = Outcomes.of(dataset)
    if isinstance(rows[0], Strip):
        handles = _explain_strips(figure, outcomes, limit)
        explanation = "One parameter at a time differs from the default."
    else:
        handles = _explain_shares(outcomes, limit)
        explanation = (
            "Each range is cut into parts of equally many cases; bars are shares of a part."
        )
    figure.legend(handles=handles, loc="upper left", ncols=3, fontsize=7)
    return captioned(figure, dataset, explanation)


def _draw_strip(axes: Axes, strip: Strip) -> None:
    """Draw a mark for each case, the default, and the span that is stable."""
    stable = strip.stable
    if stable.size and not strip.values.categories:
        ends = stable[[0, -1]]
        axes.plot(ends, [0, 0], color="0.8", lw=8, solid_capstyle="round", gid="stable")
    axes.axvline(strip.default, color="black", lw=1, gid="default")
    for number, status, _, share in zip(strip.values.numbers, *strip.outcomes, strict=True):
        marker, colour = STATUSES.get(status, OTHER)
        if np.isfinite(share):
            colour = to_hex(SHADES(share))
        axes.plot(number, 0, marker, color=colour, mec="black", mew=0.5, ms=6, gid=status)
    strip.values.dress(axes, room=6)
    axes.set_ylim(-1, 1)
    axes.set_yticks([])


def _draw_shares(axes: Axes, shares: Shares) -> None:
    """Draw a bar for each part, in the colours of how its cases ended."""
    places, base = np.arange(len(shares.parts)), np.zeros(len(shares.parts))
    for status in _in_order(np.concatenate([part.status for part in shares.parts])):
        height = shares.share(status)
        axes.bar(places, height, 0.9, base, color=STATUSES.get(status, OTHER)[1], gid=status)
        base += height
    known = [part.known_shares for part in shares.parts]
    medians = [np.median(numbers) if numbers.size else np.nan for numbers in known]
    axes.hlines(medians, places - 0.45, places + 0.45, color="black", lw=2)
    if np.array_equal(shares.bounds[:, 0], shares.bounds[:, 1]):
        axes.set_xticks(places, shares.texts)
    else:
        edges = [*shares.bounds[:, 0], shares.bounds[-1, 1]]
        # Three digits, without an exponent where the number is not long.
        texts = [f"{float(f'{edge:.3g}'):g}" for edge in edges]
        axes.set_xticks(np.arange(len(edges)) - 0.5, texts)
    axes.set(xlim=(-0.5, places.size - 0.5), ylim=(0, 1))
    axes.set_yticks([0, 0.5, 1], ["0", "", "1"], fontsize=6)


def _explain_strips(figure: Figure, outcomes: Outcomes, limit: str) -> list[Artist]:
    """The legend's entries; where results have a limit, the scale of colours as well."""
    is_scaled = outcomes.known_shares.size > 0
    handles: list[Artist] = []
    for status in _in_order(outcomes.status):
        marker, own = STATUSES.get(status, OTHER)
        colour = "white" if is_scaled and status == COMPLETED else own
        mark = Line2D([], [], ls="", marker=marker, color=colour, mec="black", label=status)
        handles.append(mark)
    handles.append(Line2D([], [], color="black", lw=1, label="default"))
    handles.append(Line2D([], [], color="0.8", lw=8, label="stable"))
    if is_scaled:
        height = figure.get_figheight()
        axes = figure.add_axes((LEFT, 0.85 / height, RIGHT - LEFT, 0.08 / height))
        scale = ScalarMappable(Normalize(0.0, 1.0), SHADES)
        figure.colorbar(scale, cax=axes, orientation="horizontal")
        axes.set_xlabel(f"{limit}, of completed cases", fontsize=7)
        axes.tick_params(labelsize=6)
    return handles


def _explain_shares(outcomes: Outcomes, limit: str) -> list[Artist]:
    """The legend's entries."""
    handles: list[Artist] = [
        Patch(color=STATUSES.get(status, OTHER)[1], label=status)
        for status in _in_order(outcomes.status)
    ]
    if outcomes.known_shares.size:
        handles.append(Line2D([], [], color="black", lw=2, label=f"{limit}, median of completed"))
    return handles


def _in_order(statuses: Texts) -> list[str]:
    """Each status of cases that were run once, in the order of `STATUSES`, others last."""
    present = set(statuses.tolist()) - {MISSING}
    return [*(status for status in STATUSES if status in present), *sorted(present - set(STATUSES))]
