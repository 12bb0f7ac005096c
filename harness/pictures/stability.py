"""The picture `stability`, and its table: where cases complete, with what margin, and what fails.

In a one-at-a-time study each parameter has a strip of single cases, from the default to the first
failure on either side. In a random study each parameter has bars: the shares of completed cases
over its range.
"""

import re
import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

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
    over_cases,
    spoken,
    varied_names,
)
from harness.pictures.drawing.caption import LINE, captioned
from harness.pictures.drawing.plot_parts import SHADES, STYLED
from harness.pictures.drawing.quantities import Floats, Texts, Values
from harness.pictures.studied import changing
from harness.study.designs import ONE_AT_A_TIME
from harness.study.study import STABILITY_MAP

PART_COUNT = 5
"""Intervals with equally many cases into which the range of a random parameter is divided."""
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
"""Marker and colour of any other status."""
SCALE = 0.6
"""Height of the scale of colours with its label [inch]."""
LEFT, RIGHT = 0.18, 0.6
"""Begin and end of the strips as a fraction of the page; names are to the left, notes right."""


def shows_stability(dataset: xr.Dataset) -> bool:
    """Whether a result has a stability map: the study asked for one, and cases were run."""
    if not dataset.attrs.get(STABILITY_MAP):
        return False
    ran = set(dataset["status"].values.flat) - {MISSING}
    return bool(ran and varied_names(dataset))


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
    names = sorted(varied_names(dataset), key=lambda name: places.get(name, len(order)))
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


class Outcomes(NamedTuple):
    """How cases ended, each field of shape [case]."""

    status: Texts
    reason: Texts  # cause of the failure in a few words; "" if the case completed
    limit_share: Floats  # greatest ratio of a result to its limit; NaN if none has a limit

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Self:
        """The outcomes of all cases of a result."""
        status = over_cases(dataset, "status").astype(str)
        reason = np.array([short_reason(str(value)) for value in over_cases(dataset, "message")])
        limits = limits_of(dataset).items()
        sizes = [np.abs(over_cases(dataset, name)) / limit for name, limit in limits]
        return cls(status, reason, np.fmax.reduce([np.full(status.shape, np.nan), *sizes]))

    def at(self, cases: np.ndarray) -> Self:
        """The outcomes of some cases."""
        return type(self)(*(field[cases] for field in self))

    @property
    def known_shares(self) -> Floats:
        """The shares of the limit that are known."""
        return self.limit_share[np.isfinite(self.limit_share)]

    @property
    def failures(self) -> str:
        """The number of cases of each status, and a reason for the most frequent failure."""
        failed = Counter(self.status[self.status != COMPLETED].tolist())
        if not failed:
            return "none"
        texts = ", ".join(f"{failed[status]} {status}" for status in sorted(failed))
        reason = self.reason[self.status == failed.most_common(1)[0][0]][0]
        return ": ".join(filter(None, (texts, str(reason))))


def short_reason(message: str) -> str:
    """The cause in a message, without the name of the exception, places, times and remedy."""
    text = re.sub(r"^\w+: ", "", message)
    text = re.sub(r" (at|is) \[[^]]*\]( m)?", "", text)
    return re.split(r", at |, more than |; |: ", text)[0]


@dataclass(frozen=True)
class Strip:
    """How the first case, with the defaults, and the cases that change one parameter ended."""

    heading = (
        *("parameter", "default", "stable"),
        *("first failure below", "first failure above", "limit"),
    )
    explanation = "Each case differs from the default in one parameter."

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
    def words(self) -> tuple[str, ...]:
        """The strip in words, under its heading."""
        values, known = self.values, self.outcomes.known_shares
        stable = [values.text(number) for number in self.stable] or ["none"]
        ends = dict.fromkeys([stable[0], stable[-1]])
        text = ", ".join(stable) if values.categories else " to ".join(ends)
        margins = "" if values.categories else self.margin(-1), self.margin(1)
        share = f"up to {known.max():.0%} of the limit" if known.size else ""
        return values.label, values.text(self.default), text, *margins, share

    @property
    def beside(self) -> tuple[str, ...]:
        """The notes beside the strip; a text is neither below nor above the default."""
        if self.values.categories:
            return (self.margin(1),)
        return f"below: {self.margin(-1)}", f"above: {self.margin(1)}"

    def margin(self, side: int) -> str:
        """The distance from the default to the first failure on a side, and its cause."""
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
        elif values.logarithmic and min(number, self.default) > 0.0:
            where += f" (factor {(number / self.default) ** side:.3g})"
        elif not values.categories:
            where += f" (difference {number - self.default:+.3g})"
        why = self.outcomes.status[place], self.outcomes.reason[place]
        return f"{where}, {': '.join(filter(None, map(str, why)))}"

    def draw(self, axes: Axes) -> None:
        """Draw a mark for each case, the default, and the span that is stable."""
        stable = self.stable
        if stable.size and not self.values.categories:
            ends = stable[[0, -1]]
            axes.plot(ends, [0, 0], color="0.8", lw=8, solid_capstyle="round", gid="stable")
        axes.axvline(self.default, color="black", lw=1, gid="default")
        for number, status, _, share in zip(self.values.numbers, *self.outcomes, strict=True):
            marker, colour = STATUSES.get(status, OTHER)
            if np.isfinite(share):
                colour = to_hex(SHADES(share))
            axes.plot(number, 0, marker, color=colour, mec="black", mew=0.5, ms=6, gid=status)
        self.values.dress(axes, room=6)
        axes.set_ylim(-1, 1)
        axes.set_yticks([])


@dataclass(frozen=True)
class Shares:
    """How random cases ended in each part of a parameter's range."""

    heading = ("parameter", "completed", "spread", "least", "what fails there")
    explanation = (
        "Each range is divided into parts of equally many cases; bars are shares of these."
    )

    values: Values
    bounds: Floats  # lowest and highest value of each part, shape [part_count, 2]
    parts: Sequence[Outcomes]

    @classmethod
    def of(cls, values: Values, outcomes: Outcomes) -> Self:
        """Intervals of single values if there are few, otherwise with about equally many cases."""
        numbers, edges = values.numbers, values.different
        if not values.categories and edges.size > PART_COUNT:
            edges = np.unique(np.quantile(numbers, np.linspace(0.0, 1.0, PART_COUNT + 1)))[1:-1]
        part = np.searchsorted(edges, numbers)
        members = [np.flatnonzero(part == value) for value in np.unique(part)]
        bounds = np.array([[numbers[cases].min(), numbers[cases].max()] for cases in members])
        return cls(values, bounds, [outcomes.at(cases) for cases in members])

    def share(self, status: str) -> Floats:
        """Share of the cases in each interval that ended with a status, shape [part_count]."""
        return np.array([np.mean(part.status == status) for part in self.parts])

    @property
    def completed(self) -> Floats:
        """Share of the cases in each interval that completed."""
        return self.share(COMPLETED)

    @property
    def texts(self) -> list[str]:
        """The values of each part in words."""
        ends = [dict.fromkeys(value) for value in self.bounds.tolist()]
        return [
            " to ".join(
                self.values.text(end if len(own) == 1 else float(f"{end:.3g}")) for end in own
            )
            for own in ends
        ]

    @property
    def words(self) -> tuple[str, ...]:
        """The shares in words, under their heading."""
        completed, texts = self.completed, self.texts
        shares = [
            f"{text}: {share:.0%} of {part.status.size}"
            for text, share, part in zip(texts, completed, self.parts, strict=True)
        ]
        least, spread = int(np.argmin(completed)), f"{np.ptp(completed):.0%}"
        worst = texts[least], self.parts[least].failures
        return self.values.label, ", ".join(shares), spread, *worst

    @property
    def beside(self) -> tuple[str, ...]:
        """The notes beside the bars."""
        least, most = self.completed.min(), self.completed.max()
        if least == 1.0:
            return (f"all {sum(part.status.size for part in self.parts)} complete",)
        failures = f"fewest at {self.words[-2]}: {self.words[-1]}"
        return f"{least:.0%} to {most:.0%} complete", failures

    def draw(self, axes: Axes) -> None:
        """Draw a bar for each interval, in the colours of the statuses of its cases."""
        places, base = np.arange(len(self.parts)), np.zeros(len(self.parts))
        for status in _in_order(np.concatenate([part.status for part in self.parts])):
            height = self.share(status)
            axes.bar(places, height, 0.9, base, color=STATUSES.get(status, OTHER)[1], gid=status)
            base += height
        known = [part.known_shares for part in self.parts]
        medians = [np.median(numbers) if numbers.size else np.nan for numbers in known]
        axes.hlines(medians, places - 0.45, places + 0.45, color="black", lw=2)
        if np.array_equal(self.bounds[:, 0], self.bounds[:, 1]):
            axes.set_xticks(places, self.texts)
        else:
            edges = [*self.bounds[:, 0], self.bounds[-1, 1]]
            # Three digits, without an exponent where the number is not long.
            texts = [f"{float(f'{edge:.3g}'):g}" for edge in edges]
            axes.set_xticks(np.arange(len(edges)) - 0.5, texts)
        axes.set(xlim=(-0.5, places.size - 0.5), ylim=(0, 1))
        axes.set_yticks([0, 0.5, 1], ["0", "", "1"], fontsize=6)


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
    for status in _in_order(outcomes.status):
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


def _in_order(statuses: Texts) -> list[str]:
    """The statuses of the cases that were run, in the order of `STATUSES`, others last."""
    present = set(statuses.tolist()) - {MISSING}
    return [*(status for status in STATUSES if status in present), *sorted(present - set(STATUSES))]
