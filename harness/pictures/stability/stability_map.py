"""The stability map: where a study is stable, by which margin, and what gives way first beyond."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

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

from harness.archive.conventions import COMPLETED, CRASHED, TIMED_OUT, UNFINISHED
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import SHADES, STYLED
from harness.pictures.drawing.quantities import Values
from harness.pictures.stability.outcomes import limit_label
from harness.pictures.stability.shares import SHARE_HEADING, Shares, share_row, shares
from harness.pictures.stability.strips import STRIP_HEADING, Strip, strip_row, strips
from harness.study.designs import ONE_AT_A_TIME

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
LIMIT_COLOURS = SHADES
"""Of a result's size over its limit, 0 to 1."""


@STYLED
def stability_figure(dataset: xr.Dataset) -> Figure:
    """A strip for each parameter: of single cases, or of the shares of random ones.

    Args:
        dataset: result for which :func:`harness.pictures.stability.outcomes.shows_stability` holds.
    """
    if dataset.attrs["design"] == ONE_AT_A_TIME:
        figure = _figure_of_strips(strips(dataset), limit_label(dataset))
        told = "One parameter at a time differs from the default."
    else:
        figure = _figure_of_shares(shares(dataset), limit_label(dataset))
        told = "Each range is cut into parts of equally many cases; bars are shares of a part."
    write_caption(figure, dataset, told)
    return figure


def stability_rows(dataset: xr.Dataset) -> list[tuple[str, ...]]:
    """The map in words: a heading, then a row for each parameter."""
    if dataset.attrs["design"] == ONE_AT_A_TIME:
        return [STRIP_HEADING, *map(strip_row, strips(dataset))]
    return [SHARE_HEADING, *map(share_row, shares(dataset))]


def _figure_of_strips(found: Sequence[Strip], limit: str) -> Figure:
    figure, rows = _rows([strip.values for strip in found])
    for axes, strip in zip(rows, found, strict=True):
        _draw_strip(axes, strip)
    shown = _in_order(name for strip in found for name in strip.status.tolist())
    is_scaled = any(np.isfinite(strip.limit_share).any() for strip in found)
    handles = [_mark(it, "white" if is_scaled and it == COMPLETED else None) for it in shown]
    handles.append(Line2D([], [], color="black", lw=1, label="default"))
    handles.append(Line2D([], [], color="0.8", lw=8, label="stable"))
    _legend(figure, handles)
    if is_scaled:
        height = figure.get_figheight()
        axes = figure.add_axes((LEFT, 0.85 / height, RIGHT - LEFT, 0.08 / height))
        scale = ScalarMappable(Normalize(0.0, 1.0), LIMIT_COLOURS)
        figure.colorbar(scale, cax=axes, orientation="horizontal")
        axes.set_xlabel(f"{limit}, of completed cases", fontsize=7)
        axes.tick_params(labelsize=6)
    return figure


def _mark(status: str, colour: str | None) -> Line2D:
    """The mark of a status in the legend."""
    marker, own = _look(status)
    return Line2D([], [], ls="", marker=marker, color=colour or own, mec="black", label=status)


def _draw_strip(axes: Axes, strip: Strip) -> None:
    stable, numbers = strip.stable, strip.values.numbers
    if stable.size and not strip.values.categories:
        axes.plot(stable[[0, -1]], [0, 0], color="0.8", lw=8, solid_capstyle="round", gid="stable")
    axes.axvline(strip.default, color="black", lw=1, gid="default")
    for number, status, share in zip(
        numbers, strip.status.tolist(), strip.limit_share, strict=True
    ):
        marker, colour = _look(status)
        if np.isfinite(share):
            colour = to_hex(LIMIT_COLOURS(share))
        axes.plot(number, 0, marker, color=colour, mec="black", mew=0.5, ms=6, gid=status)
    strip.values.dress(axes, room=6)
    axes.set_ylim(-1, 1)
    axes.set_yticks([])
    sides = [f"{name}: {strip.margin(side)}" for side, name in ((-1, "below"), (1, "above"))]
    _write_beside(axes, sides)


def _figure_of_shares(found: Sequence[Shares], limit: str) -> Figure:
    figure, rows = _rows([it.values for it in found])
    for axes, it in zip(rows, found, strict=True):
        _draw_shares(axes, it)
    handles: list[Artist] = [
        Patch(color=_look(name)[1], label=name) for name in _in_order(found[0].counts)
    ]
    if any(np.isfinite(it.limit_share).any() for it in found):
        handles.append(Line2D([], [], color="black", lw=2, label=f"{limit}, median of completed"))
    _legend(figure, handles)
    return figure


def _draw_shares(axes: Axes, it: Shares) -> None:
    places, base = np.arange(it.case_count.size), np.zeros(it.case_count.size)
    for status in _in_order(it.counts):
        height = it.counts[status] / it.case_count
        axes.bar(places, height, 0.9, base, color=_look(status)[1], gid=status)
        base += height
    axes.hlines(it.limit_share, places - 0.45, places + 0.45, color="black", lw=2)
    if np.array_equal(it.bounds[:, 0], it.bounds[:, 1]):
        axes.set_xticks(places, [it.text(part) for part in places.tolist()])
    else:
        edges = [*it.bounds[:, 0], it.bounds[-1, 1]]
        axes.set_xticks(np.arange(len(edges)) - 0.5, [_short(edge) for edge in edges])
    axes.set_xlim(-0.5, places.size - 0.5)
    axes.set_ylim(0, 1)
    axes.set_yticks([0, 0.5, 1], ["0", "", "1"], fontsize=6)
    _write_beside(axes, _told_of(it))


def _told_of(it: Shares) -> list[str]:
    """How many complete over the range of a parameter, and where the fewest do."""
    least = int(np.argmin(it.completed))
    if it.completed[least] == 1.0:
        return [f"all {it.case_count.sum()} complete"]
    return [
        f"{it.completed.min():.0%} to {it.completed.max():.0%} complete",
        f"least at {it.text(least)}: {it.failures(least)}",
    ]


def _short(number: float) -> str:
    """Three digits of a number, without an exponent where it is not long."""
    return f"{float(f'{number:.3g}'):g}"


def _rows(all_values: Sequence[Values]) -> tuple[Figure, list[Axes]]:
    """Axes one below the other, each with a parameter's name."""
    count = len(all_values)
    height = STRIP_HEIGHT * count + LEGEND_HEIGHT + 2 * SCALE_HEIGHT
    with rc_context({"figure.constrained_layout.use": False}):
        figure = Figure(figsize=(Figure().get_figwidth(), height))
    rows = list(figure.subplots(count, 1, squeeze=False)[:, 0])
    top, bottom = 1 - LEGEND_HEIGHT / height, 2 * SCALE_HEIGHT / height
    figure.subplots_adjust(left=LEFT, right=RIGHT, bottom=bottom, top=top, hspace=1.0)
    for axes, values in zip(rows, all_values, strict=True):
        axes.spines[["top", "right", "left"]].set_visible(False)
        label = textwrap.fill(values.label, 17)
        axes.set_ylabel(label, rotation=0, ha="right", va="center", fontsize=7, labelpad=8)
        axes.tick_params(axis="x", labelsize=6, pad=1)
    return figure, rows


def _write_beside(axes: Axes, lines: Iterable[str]) -> None:
    text = "\n".join(textwrap.fill(line, BESIDE, max_lines=2) for line in lines)
    axes.text(1.03, 0.5, text, transform=axes.transAxes, va="center", fontsize=6)


def _legend(figure: Figure, handles: Sequence[Artist]) -> None:
    figure.legend(handles=handles, loc="upper left", ncols=5, fontsize=7)


def _look(status: str) -> tuple[str, str]:
    return STATUSES.get(status, OTHER)


def _in_order(statuses: Iterable[str]) -> list[str]:
    """Each status once, in the order of `STATUSES`, others last."""
    present = set(statuses)
    return [*(it for it in STATUSES if it in present), *sorted(present - set(STATUSES))]
