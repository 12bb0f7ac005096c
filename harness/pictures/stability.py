"""The picture `stability` and its table: where cases complete, with what margin, what fails."""

import textwrap
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from harness.archive.conventions import (
    COMPLETED,
    MISSING,
    freely_varied,
    limits_of,
    spoken,
)
from harness.pictures.drawing.caption import LINE, captioned
from harness.pictures.drawing.plot_parts import SHADES, STYLED
from harness.pictures.drawing.quantities import Values
from harness.pictures.stability_strips import OTHER, STATUSES, Outcomes, Shares, Strip, in_order
from harness.pictures.studied import changing
from harness.study.designs import ONE_AT_A_TIME
from harness.study.study import STABILITY_MAP

SCALE = 0.6
"""Height of the scale of colours with its label [inch]."""
LEFT, RIGHT = 0.18, 0.6
"""Begin and end of the strips as a fraction of the page; names are to the left, notes right."""


def shows_stability(dataset: xr.Dataset) -> bool:
    """Whether a result has a stability map: the study asked for one, and cases were run."""
    if not dataset.attrs.get(STABILITY_MAP):
        return False
    ran = set(dataset["status"].values.flat) - {MISSING}
    return bool(ran and freely_varied(dataset))


def stability_rows(dataset: xr.Dataset) -> list[tuple[str, ...]]:
    """The map in words: a heading, then a row for each parameter."""
    strips = stability_strips(dataset)
    return [strips[0].heading, *(row.words for row in strips)]


def stability_strips(dataset: xr.Dataset) -> "Sequence[Strip | Shares]":
    """A strip for each varied parameter, from the cases that were run.

    In a one-at-a-time study a strip has the first case, which has the defaults, and those that
    change the parameter; strips are in the order of the study. In a random study a strip has all
    cases, and parameters over which the shares differ most come first.
    """
    outcomes = Outcomes.of(dataset)
    ran = outcomes.status != MISSING
    order = str(dataset.attrs[STABILITY_MAP]).split()
    places = {name: place for place, name in enumerate(order)}
    names = sorted(freely_varied(dataset), key=lambda name: places.get(name, len(order)))
    varied = [Values.of(dataset, name) for name in names]
    if dataset.attrs["design"] != ONE_AT_A_TIME:
        found = [Shares.of(values.at(ran), outcomes.at(ran)) for values in varied]
        return sorted(found, key=lambda it: np.ptp(it.completed), reverse=True)
    strips = []
    for values, changed in zip(varied, changing(dataset, varied), strict=True):
        own = ran & changed
        own[0] = ran[0]
        strips.append(Strip(values.at(own), float(values.numbers[0]), outcomes.at(own)))
    return strips


@STYLED
def stability_figure(dataset: xr.Dataset) -> Figure | None:
    """The picture, with a strip for each parameter: single cases, or shares of random ones."""
    if not shows_stability(dataset):
        return None
    rows, outcomes = stability_strips(dataset), Outcomes.of(dataset)
    with rc_context({"figure.constrained_layout.use": False}):
        figure = captioned(Figure(), dataset, rows[0].explanation)
    lines = 1 + figure.get_supxlabel().count("\n")
    # Heights of the legend, and of the scale of colours with the caption [inch].
    above, below = 0.45, SCALE + 0.35 + LINE * lines
    height = 0.62 * len(rows) + above + below
    figure.set_figheight(height)
    all_axes = figure.subplots(len(rows), 1, squeeze=False)[:, 0]
    top, bottom = 1 - above / height, below / height
    figure.subplots_adjust(left=LEFT, right=RIGHT, bottom=bottom, top=top, hspace=1.0)
    for axes, row in zip(all_axes, rows, strict=True):
        axes.spines[["top", "right", "left"]].set_visible(False)
        label = textwrap.fill(row.values.label, 17)
        axes.set_ylabel(label, rotation=0, ha="right", va="center", fontsize=7, labelpad=8)
        axes.tick_params(axis="x", labelsize=6, pad=1)
        row.draw(axes)
        text = "\n".join(textwrap.fill(line, 46, max_lines=2) for line in row.beside)
        axes.text(1.03, 0.5, text, transform=axes.transAxes, va="center", fontsize=6)
    is_scaled, is_strip = outcomes.known_shares.size > 0, isinstance(rows[0], Strip)
    handles: list[Artist] = []
    for status in in_order(outcomes.status):
        marker, own = STATUSES.get(status, OTHER)
        colour = "white" if is_scaled and status == COMPLETED else own
        mark = Line2D([], [], ls="", marker=marker, color=colour, mec="black", label=status)
        handles.append(mark if is_strip else Patch(color=own, label=status))
    limits = limits_of(dataset).items()
    limit = " or ".join(f"{spoken(name)} over its limit of {size:g}" for name, size in limits)
    if is_strip:
        handles.append(Line2D([], [], color="black", lw=1, label="default"))
        handles.append(Line2D([], [], color="0.8", lw=8, label="stable"))
        if is_scaled:
            _draw_scale(figure, (below - 0.35) / height, f"{limit}, of completed cases")
    elif is_scaled:
        label = f"{limit}, median of completed"
        handles.append(Line2D([], [], color="black", lw=2, label=label))
    figure.legend(handles=handles, loc="upper left", ncols=3, fontsize=7)
    return figure


def _draw_scale(figure: Figure, bottom: float, label: str) -> None:
    axes = figure.add_axes((LEFT, bottom, RIGHT - LEFT, 0.08 / figure.get_figheight()))
    scale = ScalarMappable(Normalize(0.0, 1.0), SHADES)
    figure.colorbar(scale, cax=axes, orientation="horizontal")
    axes.set_xlabel(label, fontsize=7)
    axes.tick_params(labelsize=6)
