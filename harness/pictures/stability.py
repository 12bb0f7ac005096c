"""The picture `stability` and its table: where cases complete, with what margin, what fails.

One at a time, each parameter has a strip of single cases, from the default to the first failure on
either side. At random, each has bars: shares of completed cases over parts of its range.
"""

import re
import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_hex
from matplotlib.figure import Figure

from harness.archive import conventions
from harness.archive.conventions import COMPLETED, MISSING, over_cases
from harness.pictures.drawing.caption import captioned
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
    conventions.UNFINISHED: ("p", "#F0E442"),
    "diverged": ("X", "#D55E00"),
    "refused": ("s", "#666666"),
    conventions.TIMED_OUT: ("D", "#56B4E9"),
    conventions.CRASHED: ("P", "#CC79A7"),
    "failed": ("v", "#0072B2"),
}
"""Marker and colour of each status, in Okabe and Ito's colours."""
OTHER = ("*", "black")
"""Marker and colour of any other status."""


class Outcomes(NamedTuple):
    """How cases ended, each field of shape [case]."""

    status: Texts
    reason: Texts  # cause of the failure in a few words; "" if the case completed
    share: Floats  # greatest ratio of a result to its limit; NaN if none has a limit

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Self:
        """The outcomes of all cases of a result."""
        status = over_cases(dataset, "status").astype(str)
        reason = np.array([short_reason(str(value)) for value in over_cases(dataset, "message")])
        limits = conventions.limits_of(dataset).items()
        sizes = [np.abs(over_cases(dataset, name)) / limit for name, limit in limits]
        return cls(status, reason, np.fmax.reduce([np.full(status.shape, np.nan), *sizes]))

    def at(self, cases: np.ndarray) -> Self:
        """The outcomes of some cases."""
        return type(self)(*(field[cases] for field in self))


def in_order(statuses: Texts) -> list[str]:
    """The statuses of the cases that were run, in the order of `STATUSES`, others last."""
    present = {*statuses.tolist()} - {MISSING}
    return sorted(present, key=lambda it: ([*STATUSES, it].index(it), it))


def short_reason(message: str) -> str:
    """The cause in a message, without the name of the exception, places, times and remedy."""
    text = re.sub(r" (at|is) \[[^]]*\]( m)?", "", re.sub(r"^\w+: ", "", message))
    return re.split(r", at |, more than |; |: ", text)[0]


@dataclass(frozen=True)
class Strip:
    """How the first case, with the defaults, and the cases that change one parameter ended."""

    heading: ClassVar[tuple[str, ...]] = (
        *("parameter", "default", "stable"),
        *("first failure below", "first failure above", "limit"),
    )
    explanation: ClassVar[str] = "Each case differs from the default in one parameter."

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
        numbers, held = self.values.numbers, self.outcomes.status == COMPLETED
        for side in (-1, 1):
            failure = self.failure(side)
            if failure is not None and not self.values.categories:
                held &= side * numbers < side * numbers[failure]
        return np.unique(numbers[held])

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

    def words(self) -> tuple[str, ...]:
        """The strip in words, under its heading."""
        values, known = self.values, self.outcomes.share[np.isfinite(self.outcomes.share)]
        stable = [values.text(number) for number in self.stable] or ["none"]
        ends = dict.fromkeys([stable[0], stable[-1]])
        text = ", ".join(stable) if values.categories else " to ".join(ends)
        margins = "" if values.categories else self.margin(-1), self.margin(1)
        share = f"up to {known.max():.0%} of the limit" if known.size else ""
        return values.label, values.text(self.default), text, *margins, share

    def draw(self, axes: Axes) -> tuple[str, ...]:
        """Draw a mark for each case, the default, and the span that is stable; return notes."""
        stable = self.stable
        if stable.size and not self.values.categories:
            style: dict[str, Any] = {"color": "0.8", "lw": 8, "solid_capstyle": "round"}
            axes.plot(stable[[0, -1]], [0, 0], gid="stable", **style)
        axes.axvline(self.default, color="black", lw=1, gid="default")
        for number, status, _, share in zip(self.values.numbers, *self.outcomes, strict=True):
            marker, colour = STATUSES.get(status, OTHER)
            colour = to_hex(SHADES(share)) if np.isfinite(share) else colour
            axes.plot(number, 0, marker, color=colour, mec="black", mew=0.5, ms=6, gid=status)
        self.values.dress(axes, room=6)
        axes.set(ylim=(-1, 1), yticks=[])
        if self.values.categories:  # a text is neither below nor above the default
            return (self.margin(1),)
        return f"below: {self.margin(-1)}", f"above: {self.margin(1)}"


@dataclass(frozen=True)
class Shares:
    """How random cases ended in each part of a parameter's range."""

    heading: ClassVar[tuple[str, ...]] = (
        "parameter",
        "completed",
        "spread",
        "least",
        "what fails there",
    )
    explanation: ClassVar[str] = (
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

    def share(self, status: str = COMPLETED) -> Floats:
        """Share of the cases in each interval that ended with a status, shape [part_count]."""
        return np.array([np.mean(part.status == status) for part in self.parts])

    def texts(self) -> list[str]:
        """The values of each part in words."""
        text = self.values.text
        return [
            text(low)
            if low == high
            else " to ".join(text(float(f"{it:.3g}")) for it in (low, high))
            for low, high in self.bounds.tolist()
        ]

    def words(self) -> tuple[str, ...]:
        """The shares in words, under their heading."""
        completed, texts = self.share(), self.texts()
        of_parts = zip(texts, completed, self.parts, strict=True)
        shares = [f"{text}: {share:.0%} of {part.status.size}" for text, share, part in of_parts]
        place = int(np.argmin(completed))
        least, worst = texts[place], self.parts[place]
        failed = Counter(worst.status[worst.status != COMPLETED].tolist())
        counts = ", ".join(f"{failed[status]} {status}" for status in sorted(failed)) or "none"
        why = worst.reason[worst.status == failed.most_common(1)[0][0]][0] if failed else ""
        failures = ": ".join(filter(None, (counts, str(why))))
        return self.values.label, ", ".join(shares), f"{np.ptp(completed):.0%}", least, failures

    def draw(self, axes: Axes) -> tuple[str, ...]:
        """Draw a bar for each interval, coloured by the statuses of its cases; return notes."""
        places, base = np.arange(len(self.parts)), np.zeros(len(self.parts))
        for status in in_order(np.concatenate([part.status for part in self.parts])):
            colour = STATUSES.get(status, OTHER)[1]
            axes.bar(places, self.share(status), 0.9, base, color=colour, gid=status)
            base += self.share(status)
        known = [part.share[np.isfinite(part.share)] for part in self.parts]
        medians = [np.median(numbers) if numbers.size else np.nan for numbers in known]
        axes.hlines(medians, places - 0.45, places + 0.45, color="black", lw=2)
        if np.array_equal(*self.bounds.T):
            axes.set_xticks(places, self.texts())
        else:  # three digits, without an exponent where the number is not long
            edges = [f"{float(f'{it:.3g}'):g}" for it in (*self.bounds[:, 0], self.bounds[-1, 1])]
            axes.set_xticks(np.arange(len(edges)) - 0.5, edges)
        axes.set(xlim=(-0.5, places.size - 0.5), ylim=(0, 1))
        axes.set_yticks([0, 0.5, 1], ["0", "", "1"], fontsize=6)
        if (completed := self.share()).min() == 1.0:
            return (f"all {sum(part.status.size for part in self.parts)} complete",)
        *_, least, failures = self.words()
        shares = f"{completed.min():.0%} to {completed.max():.0%} complete"
        return shares, f"fewest at {least}: {failures}"


def shows_stability(dataset: xr.Dataset) -> bool:
    """Whether a result has a stability map: the study asked for one, and cases were run."""
    ran = set(dataset["status"].values.flat) - {MISSING}
    return bool(dataset.attrs.get(STABILITY_MAP) and ran and conventions.freely_varied(dataset))


def stability_rows(dataset: xr.Dataset) -> list[tuple[str, ...]]:
    """The map in words: a heading, then a row for each parameter."""
    strips = stability_strips(dataset)
    return [strips[0].heading, *(row.words() for row in strips)]


def stability_strips(dataset: xr.Dataset) -> Sequence[Strip | Shares]:
    """A strip for each varied parameter, from the cases that were run.

    One at a time a strip has the first case, which has the defaults, and those that change the
    parameter; strips are in the order of the study. At random a strip has all cases, and
    parameters over which the shares differ most come first.
    """
    outcomes = Outcomes.of(dataset)
    ran = outcomes.status != MISSING
    order = [*str(dataset.attrs[STABILITY_MAP]).split(), *conventions.freely_varied(dataset)]
    names = sorted(conventions.freely_varied(dataset), key=order.index)
    varied = [Values.of(dataset, name) for name in names]
    if dataset.attrs["design"] != ONE_AT_A_TIME:
        found = [Shares.of(values.at(ran), outcomes.at(ran)) for values in varied]
        return sorted(found, key=lambda it: np.ptp(it.share()), reverse=True)
    first = np.arange(ran.size) == 0
    owns = [ran & (own | first) for own in changing(dataset, varied)]
    return [
        Strip(values.at(own), float(values.numbers[0]), outcomes.at(own))
        for values, own in zip(varied, owns, strict=True)
    ]


@STYLED
def stability_figure(dataset: xr.Dataset) -> Figure | None:
    """The picture, with a strip for each parameter: single cases, or shares of random ones."""
    if not shows_stability(dataset):
        return None
    rows = stability_strips(dataset)
    figure = Figure()
    figure.set_figheight(0.62 * len(rows) + 1.3)
    for axes, row in zip(figure.subplots(len(rows), squeeze=False)[:, 0], rows, strict=True):
        axes.spines[["top", "right", "left"]].set_visible(False)
        axes.grid(visible=False)
        label = textwrap.fill(row.values.label, 17)
        axes.set_ylabel(label, rotation=0, ha="right", va="center", fontsize=7)
        axes.tick_params(axis="x", labelsize=6, pad=1)
        notes = "\n".join(textwrap.fill(line, 46, max_lines=2) for line in row.draw(axes))
        axes.text(1.03, 0.5, notes, transform=axes.transAxes, va="center", fontsize=6)
    outcomes, first = Outcomes.of(dataset), figure.axes[0]
    is_scaled, is_strip = bool(np.isfinite(outcomes.share).any()), isinstance(rows[0], Strip)
    for status in in_order(outcomes.status):
        marker, colour = STATUSES.get(status, OTHER)
        shape = marker if is_strip else "s"
        colour = "white" if is_scaled and is_strip and status == COMPLETED else colour
        first.plot([], [], color=colour, marker=shape, mec="black", ls="", label=status)
    limits = conventions.limits_of(dataset).items()
    limit = " or ".join(
        f"{conventions.spoken(it)} over its limit of {size:g}" for it, size in limits
    )
    if is_strip:
        first.plot([], [], color="black", lw=1, label="default")
        first.plot([], [], color="0.8", lw=8, label="stable")
    elif is_scaled:
        first.plot([], [], color="black", lw=2, label=f"{limit}, median of completed")
    if is_strip and is_scaled:
        scale = ScalarMappable(Normalize(0.0, 1.0), SHADES)
        bar = figure.colorbar(scale, ax=figure.axes, location="bottom", aspect=60, pad=0.02)
        bar.set_label(f"{limit}, of completed cases", fontsize=7)
        bar.ax.tick_params(labelsize=6)
    return captioned(figure, dataset, rows[0].explanation, legend=first)
