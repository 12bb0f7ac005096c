"""The stability map: where a study is stable, by which margin, and what gives way first beyond.

One parameter at a time: a strip of single cases for each parameter, from the default to the first
failure on either side. At random: the share that completed over the range of each parameter.
"""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

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
from numpy.typing import NDArray

from harness.archive.conventions import (
    COMPLETED,
    CRASHED,
    MISSING,
    TIMED_OUT,
    UNFINISHED,
    limits_of,
    over_cases,
    spoken,
    varied_names,
)
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import SHADES, STYLED
from harness.pictures.drawing.quantities import Floats, Texts, Values
from harness.study.designs import LATIN_HYPERCUBE, ONE_AT_A_TIME

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
PART_COUNT = 5
"""Parts of equally many cases that the range of a random parameter is cut into."""
STRIP_HEADING = (
    *("parameter", "default", "stable"),
    *("first failure below", "first failure above", "limit"),
)
SHARE_HEADING = ("parameter", "completed", "spread", "least", "what gives way there")


def shows_stability(dataset: xr.Dataset) -> bool:
    """Whether a study's result shows where it is stable.

    It does where it varies parameters of one scene one at a time or at random, and a case that was
    run did not complete or a result has a limit.
    """
    if dataset.attrs.get("design") not in (ONE_AT_A_TIME, LATIN_HYPERCUBE):
        return False
    if len(str(dataset.attrs["scene"]).split()) > 1 or not varied_names(dataset):
        return False
    ended = set(dataset["status"].values.tolist()) - {MISSING}
    return bool(ended) and (limits_of(dataset) != {} or ended != {COMPLETED})


@STYLED
def stability_figure(dataset: xr.Dataset) -> Figure:
    """A strip for each parameter: of single cases, or of the shares of random ones."""
    limits = limits_of(dataset).items()
    limit = " or ".join(f"{spoken(name)} over its limit of {size:g}" for name, size in limits)
    if dataset.attrs["design"] == ONE_AT_A_TIME:
        cases = strips(dataset)
        figure = _figure(cases)
        handles = _explain_strips(figure, cases, limit)
        explanation = "One parameter at a time differs from the default."
    else:
        parts = shares(dataset)
        figure = _figure(parts)
        handles = _explain_shares(parts, limit)
        explanation = (
            "Each range is cut into parts of equally many cases; bars are shares of a part."
        )
    figure.legend(handles=handles, loc="upper left", ncols=5, fontsize=7)
    write_caption(figure, dataset, explanation)
    return figure


def stability_rows(dataset: xr.Dataset) -> list[tuple[str, ...]]:
    """The map in words: a heading, then a row for each parameter."""
    if dataset.attrs["design"] == ONE_AT_A_TIME:
        return [STRIP_HEADING, *(strip.row for strip in strips(dataset))]
    return [SHARE_HEADING, *(share.row for share in shares(dataset))]


class Outcomes(NamedTuple):
    """How cases ended, each field of shape [case].

    Attributes:
        status: of each case.
        reason: what gave way, in a few words; empty where the case completed.
        limit_share: size of results over their limit, of several the one nearest to it; not a
            number where nothing has a limit.
    """

    status: Texts
    reason: Texts
    limit_share: Floats

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Outcomes:
        """Those of all cases of a result."""
        status = over_cases(dataset, "status").astype(str)
        reason = np.array([short_reason(str(value)) for value in over_cases(dataset, "message")])
        limits = limits_of(dataset).items()
        sizes = [np.abs(over_cases(dataset, name)) / limit for name, limit in limits]
        return cls(status, reason, np.fmax.reduce([np.full(status.shape, np.nan), *sizes]))

    def at(self, cases: np.ndarray) -> Outcomes:
        """Those of some cases."""
        return Outcomes(*(field[cases] for field in self))

    @property
    def known_shares(self) -> Floats:
        """The shares of the limit that are known."""
        return self.limit_share[np.isfinite(self.limit_share)]


def short_reason(message: str) -> str:
    """What gave way, out of a message: without the exception's name, places, times and remedy."""
    text = re.sub(r"^\w+: ", "", message)
    text = re.sub(r" (at|is) \[[^]]*\]( m)?", "", text)
    return re.split(r", at |, more than |; |: ", text)[0]


@dataclass(frozen=True)
class Strip:
    """How the case of defaults ended, and those that differ from it in one parameter.

    Attributes:
        values: of the parameter.
        default: its value in the case from which all others start; the first of categories.
        outcomes: of these cases.
    """

    values: Values
    default: float
    outcomes: Outcomes

    def failure(self, side: int) -> int | None:
        """The failed case nearest to the default, below it (-1) or above (1), itself included."""
        distance = side * (self.values.numbers - self.default)
        failed = np.flatnonzero((distance >= 0.0) & (self.outcomes.status != COMPLETED))
        return int(failed[np.argmin(distance[failed])]) if failed.size else None

    @property
    def stable(self) -> Floats:
        """The completed values, ascending, up to the first failure on either side."""
        numbers = self.values.numbers
        held = self.outcomes.status == COMPLETED
        for side in (-1, 1):
            failure = self.failure(side)
            if failure is not None and not self.values.categories:
                held &= side * numbers < side * numbers[failure]
        return np.unique(numbers[held])

    @property
    def stable_text(self) -> str:
        """The values in words."""
        texts = [self.values.text(number) for number in self.stable]
        if not self.values.categories:
            return " to ".join(dict.fromkeys([*texts[:1], *texts[-1:]])) or "none"
        return ", ".join(texts) or "none"

    @property
    def row(self) -> tuple[str, ...]:
        """The strip in words, under `STRIP_HEADING`."""
        known = self.outcomes.known_shares
        share = f"up to {known.max():.0%} of the limit" if known.size else ""
        default = self.values.text(self.default)
        return (
            *(self.values.label, default, self.stable_text),
            *(self.margin(-1), self.margin(1), share),
        )

    def margin(self, side: int) -> str:
        """How far it is from the default to the first failure on a side, and what gives way."""
        values, place = self.values, self.failure(side)
        if place is None:
            beyond = side * (values.numbers - self.default)
            if values.categories or not (beyond > 0.0).any():
                return "none failed" if (beyond > 0.0).any() else "no case"
            furthest = values.text(values.numbers[np.argmax(beyond)])
            return f"none failed {'up' if side > 0 else 'down'} to {furthest}"
        number = float(values.numbers[place])
        where = values.text(number)
        if number == self.default:
            where = "the default itself"
        elif not values.categories:
            is_ratio = values.logarithmic and min(number, self.default) > 0.0
            factor = f"factor {(number / self.default) ** side:.3g}" if is_ratio else ""
            where += f" ({factor or f'difference {number - self.default:+.3g}'})"
        why = self.outcomes.status[place], self.outcomes.reason[place]
        return f"{where}, {': '.join(filter(None, map(str, why)))}"

    def draw(self, axes: Axes) -> None:
        """Draw a mark for each case, the default, and the span that is stable."""
        stable, outcomes = self.stable, self.outcomes
        if stable.size and not self.values.categories:
            ends = stable[[0, -1]]
            axes.plot(ends, [0, 0], color="0.8", lw=8, solid_capstyle="round", gid="stable")
        axes.axvline(self.default, color="black", lw=1, gid="default")
        for number, status, share in zip(
            self.values.numbers, outcomes.status.tolist(), outcomes.limit_share, strict=True
        ):
            marker, colour = STATUSES.get(status, OTHER)
            if np.isfinite(share):
                colour = to_hex(SHADES(share))
            axes.plot(number, 0, marker, color=colour, mec="black", mew=0.5, ms=6, gid=status)
        self.values.dress(axes, room=6)
        axes.set_ylim(-1, 1)
        axes.set_yticks([])
        _write_beside(axes, f"below: {self.margin(-1)}", f"above: {self.margin(1)}")


def strips(dataset: xr.Dataset) -> list[Strip]:
    """A strip for each parameter of a design of one at a time, in the order of the dataset.

    The first case has the defaults. What is derived from a varied parameter has a strip too. Cases
    that were not run yet are left out.
    """
    outcomes, found = Outcomes.of(dataset), []
    for name in varied_names(dataset):
        values = Values.of(dataset, name)
        own = values.numbers != values.numbers[0]
        own[0] = True
        own &= outcomes.status != MISSING
        part = replace(values, numbers=values.numbers[own])
        found.append(Strip(part, float(values.numbers[0]), outcomes.at(own)))
    return found


@dataclass(frozen=True)
class Shares:
    """How random cases ended in each part of a parameter's range.

    Attributes:
        values: of the parameter.
        bounds: lowest and highest value of each part, shape [part_count, 2].
        parts: how the cases of each part ended.
    """

    values: Values
    bounds: Floats
    parts: Sequence[Outcomes]

    def count(self, status: str) -> NDArray[np.intp]:
        """Cases of each part that ended so, shape [part_count]."""
        return np.array([np.sum(part.status == status) for part in self.parts])

    @property
    def case_count(self) -> NDArray[np.intp]:
        """Cases of each part."""
        return np.array([part.status.size for part in self.parts])

    @property
    def completed(self) -> Floats:
        """Share of the cases that completed, of each part."""
        share: Floats = self.count(COMPLETED) / self.case_count
        return share

    @property
    def spread(self) -> float:
        """Largest share less the smallest: how much the parameter matters."""
        return float(np.ptp(self.completed))

    @property
    def limit_share(self) -> Floats:
        """Median size of results over their limit, of each part; else not a number."""
        known = [part.known_shares for part in self.parts]
        return np.array([np.median(value) if value.size else np.nan for value in known])

    @property
    def row(self) -> tuple[str, ...]:
        """The shares in words, under `SHARE_HEADING`."""
        least = int(np.argmin(self.completed))
        told = ", ".join(
            f"{self.text(part)}: {share:.0%} of {count}"
            for part, (share, count) in enumerate(zip(self.completed, self.case_count, strict=True))
        )
        worst = self.text(least), self.failures(least)
        return self.values.label, told, f"{self.spread:.0%}", *worst

    def text(self, part: int) -> str:
        """The values of a part in words."""
        low, high = self.bounds[part].tolist()
        if low == high:
            return self.values.text(low)
        return " to ".join(self.values.text(float(f"{end:.3g}")) for end in (low, high))

    def failures(self, part: int) -> str:
        """What gave way in a part: cases of each status, and a reason of the most frequent one."""
        outcomes = self.parts[part]
        failed = Counter(outcomes.status[outcomes.status != COMPLETED].tolist())
        if not failed:
            return "none"
        texts = ", ".join(f"{failed[status]} {status}" for status in sorted(failed))
        reason = outcomes.reason[outcomes.status == failed.most_common(1)[0][0]][0]
        return ": ".join(filter(None, (texts, str(reason))))

    def draw(self, axes: Axes) -> None:
        """Draw a bar for each part, in the colours of how its cases ended."""
        counts, bounds = self.case_count, self.bounds
        places, base = np.arange(counts.size), np.zeros(counts.size)
        for status in _in_order(self.parts):
            height = self.count(status) / counts
            axes.bar(places, height, 0.9, base, color=STATUSES.get(status, OTHER)[1], gid=status)
            base += height
        axes.hlines(self.limit_share, places - 0.45, places + 0.45, color="black", lw=2)
        if np.array_equal(bounds[:, 0], bounds[:, 1]):
            axes.set_xticks(places, [self.text(part) for part in places.tolist()])
        else:
            edges = [*bounds[:, 0], bounds[-1, 1]]
            # Three digits, without an exponent where the number is not long.
            texts = [f"{float(f'{edge:.3g}'):g}" for edge in edges]
            axes.set_xticks(np.arange(len(edges)) - 0.5, texts)
        axes.set_xlim(-0.5, places.size - 0.5)
        axes.set_ylim(0, 1)
        axes.set_yticks([0, 0.5, 1], ["0", "", "1"], fontsize=6)
        least, most = self.completed.min(), self.completed.max()
        if least == 1.0:
            _write_beside(axes, f"all {counts.sum()} complete")
            return
        worst = int(np.argmin(self.completed))
        failures = f"least at {self.text(worst)}: {self.failures(worst)}"
        _write_beside(axes, f"{least:.0%} to {most:.0%} complete", failures)


def shares(dataset: xr.Dataset) -> list[Shares]:
    """The shares over each parameter of random cases, those first over which they differ most.

    Parts are single values where there are few of them, else hold about as many cases each. Cases
    that were not run yet are left out.
    """
    ran = dataset.isel(case=dataset["status"].values != MISSING)
    outcomes = Outcomes.of(ran)
    found = []
    for name in varied_names(ran):
        values = Values.of(ran, name)
        numbers, edges = values.numbers, values.different
        if not values.categories and edges.size > PART_COUNT:
            quantiles = np.quantile(numbers, np.linspace(0.0, 1.0, PART_COUNT + 1))
            edges = np.unique(quantiles)[1:-1]
        part = np.searchsorted(edges, numbers)
        members = [np.flatnonzero(part == value) for value in np.unique(part)]
        bounds = np.array([[numbers[cases].min(), numbers[cases].max()] for cases in members])
        found.append(Shares(values, bounds, [outcomes.at(cases) for cases in members]))
    return sorted(found, key=lambda it: it.spread, reverse=True)


def _figure(rows: Sequence[Strip | Shares]) -> Figure:
    """A row for each parameter, with its name before it."""
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
        row.draw(axes)
    return figure


def _explain_strips(figure: Figure, found: Sequence[Strip], limit: str) -> list[Artist]:
    """The legend's entries; where results have a limit, the scale of colours as well."""
    outcomes = [strip.outcomes for strip in found]
    is_scaled = any(it.known_shares.size for it in outcomes)
    handles: list[Artist] = []
    for status in _in_order(outcomes):
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


def _explain_shares(found: Sequence[Shares], limit: str) -> list[Artist]:
    """The legend's entries."""
    handles: list[Artist] = [
        Patch(color=STATUSES.get(status, OTHER)[1], label=status)
        for status in _in_order(found[0].parts)
    ]
    if any(np.isfinite(entry.limit_share).any() for entry in found):
        handles.append(Line2D([], [], color="black", lw=2, label=f"{limit}, median of completed"))
    return handles


def _write_beside(axes: Axes, *lines: str) -> None:
    text = "\n".join(textwrap.fill(line, BESIDE, max_lines=2) for line in lines)
    axes.text(1.03, 0.5, text, transform=axes.transAxes, va="center", fontsize=6)


def _in_order(outcomes: Iterable[Outcomes]) -> list[str]:
    """Each status once, in the order of `STATUSES`, others last."""
    present = {status for it in outcomes for status in it.status.tolist()}
    return [*(status for status in STATUSES if status in present), *sorted(present - set(STATUSES))]
