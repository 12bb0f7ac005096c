"""How the cases of a study ended over one parameter, as drawn and told by the stability map.

In a one-at-a-time study each parameter has a strip of single cases, from the default to the first
failure on either side. In a random study each parameter has bars: the shares of completed cases
over its range.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_hex

from harness.archive.conventions import (
    COMPLETED,
    CRASHED,
    MISSING,
    TIMED_OUT,
    UNFINISHED,
    limits_of,
    over_cases,
)
from harness.pictures.drawing.plot_parts import SHADES
from harness.pictures.drawing.quantities import Floats, Texts, Values

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
        for status in in_order(np.concatenate([part.status for part in self.parts])):
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


def in_order(statuses: Texts) -> list[str]:
    """The statuses of the cases that were run, in the order of `STATUSES`, others last."""
    present = set(statuses.tolist()) - {MISSING}
    return [*(status for status in STATUSES if status in present), *sorted(present - set(STATUSES))]
