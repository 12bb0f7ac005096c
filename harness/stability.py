"""Where a study is stable: over which values, by which margin, and what gives way first beyond.

A design of one parameter at a time gives a :class:`Strip` a parameter, one of random cases the
:class:`Shares` that completed.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from harness.cases import COMPLETED, MISSING
from harness.compare import varied_along
from harness.designs import LATIN_HYPERCUBE, ONE_AT_A_TIME
from mpm_warp.scenes.cone_penetration import LARGEST_ENERGY_ERROR

BIN_COUNT = 5
"""Parts of equally many cases that the range of a parameter is cut into."""

ENERGY = "energy_error"
"""The result that holds the error of the energy, over the work done."""
NOT_VARIED = "not varied"
STRIP_HEADING = (
    "parameter",
    "default",
    "stable",
    "first failure below",
    "first failure above",
    "energy error",
)
SHARE_HEADING = ("parameter", "completed", "spread", "least", "what gives way there")

Floats = NDArray[np.float64]
Rows = list[tuple[str, ...]]


@dataclass(frozen=True, kw_only=True)
class Values:
    """A parameter's values in the cases that were run.

    Attributes:
        name: of the parameter.
        unit: SI unit, "1" for a dimensionless number.
        numbers: one a case; the place among `categories` where these are no numbers.
        categories: what the numbers stand for, in the order of the study; none for numbers.
    """

    name: str
    unit: str
    numbers: Floats
    categories: tuple[str, ...] = ()

    @classmethod
    def of(cls, dataset: xr.Dataset, name: str) -> Values:
        """Those of a dataset; one that the scene derives itself makes all of them categories."""
        values, unit = dataset[name].values, str(dataset[name].attrs.get("units", "1"))
        if values.dtype.kind in "iuf" and np.isfinite(values).all():
            return cls(name=name, unit=unit, numbers=values.astype(float))
        texts = [_category(value) for value in values.tolist()]
        categories = tuple(dict.fromkeys(texts))
        numbers = np.array([float(categories.index(text)) for text in texts])
        return cls(name=name, unit="1", numbers=numbers, categories=categories)

    @property
    def label(self) -> str:
        """Name and unit."""
        name = self.name.removesuffix("_parameter").replace("_", " ")
        return name if self.unit == "1" else f"{name} [{self.unit}]"

    @property
    def logarithmic(self) -> bool:
        """Whether the values, zero aside, span a decade or more."""
        positive = self.numbers[self.numbers > 0.0]
        if self.categories or positive.size == 0 or self.numbers.min() < 0.0:
            return False
        return bool(positive.max() >= 10.0 * positive.min())

    def text(self, number: float) -> str:
        """A value in words."""
        return self.categories[int(number)] if self.categories else f"{number:.6g}"


@dataclass(frozen=True, kw_only=True)
class Strip:
    """How the cases ended in which one parameter is not at its default, and that of defaults.

    Attributes:
        values: of the parameter.
        default: its value in the case from which all others start; the first of categories.
        status: of each case.
        reason: why it did not complete, in a few words.
        energy: error of the energy over the largest allowed; not a number where there is none.
    """

    values: Values
    default: float
    status: NDArray[np.str_]
    reason: NDArray[np.str_]
    energy: Floats

    def failure(self, side: int) -> int | None:
        """The failed case nearest to the default, below it (-1) or above (1), itself included."""
        distance = side * (self.values.numbers - self.default)
        failed = np.flatnonzero((distance >= 0.0) & (self.status != COMPLETED))
        return int(failed[np.argmin(distance[failed])]) if failed.size else None

    @property
    def stable(self) -> Floats:
        """The completed values, ascending, up to the first failure on either side."""
        numbers = self.values.numbers
        held = self.status == COMPLETED
        for side in (-1, 1):
            failure = self.failure(side)
            if failure is not None and not self.values.categories:
                held &= side * numbers < side * numbers[failure]
        return np.unique(numbers[held])

    @property
    def stable_text(self) -> str:
        """The values in words."""
        texts = [self.values.text(number) for number in self.stable]
        if self.values.categories:
            return ", ".join(texts) or "none"
        return " to ".join(dict.fromkeys([texts[0], texts[-1]])) if texts else "none"

    def margin(self, side: int) -> str:
        """How far it is from the default to the first failure on a side, and what gives way."""
        place = self.failure(side)
        if place is None:
            return self._unfailed(side)
        number = float(self.values.numbers[place])
        where = "the default itself" if number == self.default else self._distance(number, side)
        why = ": ".join(filter(None, (str(self.status[place]), str(self.reason[place]))))
        return f"{where}, {why}"

    def _unfailed(self, side: int) -> str:
        beyond = side * (self.values.numbers - self.default)
        if not (beyond > 0.0).any():
            return NOT_VARIED
        if self.values.categories:
            return "none failed"
        furthest = self.values.text(self.values.numbers[np.argmax(beyond)])
        return f"none failed {'up' if side > 0 else 'down'} to {furthest}"

    def _distance(self, number: float, side: int) -> str:
        """A value, with its factor to the default on a logarithmic axis, else its difference."""
        text = self.values.text(number)
        if self.values.categories:
            return text
        if self.values.logarithmic and min(number, self.default) > 0.0:
            return f"{text} (factor {(number / self.default) ** side:.3g})"
        return f"{text} (difference {number - self.default:+.3g})"


@dataclass(frozen=True, kw_only=True)
class Shares:
    """How random cases ended in each part of a parameter's range.

    Attributes:
        values: of the parameter.
        bounds: lowest and highest value of each part, shape [part_count, 2].
        counts: cases of each part by status, shape [part_count].
        reason: the first reason given in each part for the status that is most frequent there
            after ``completed``; empty where all completed.
        energy: median error of the energy over the largest allowed, shape [part_count].
    """

    values: Values
    bounds: Floats
    counts: Mapping[str, NDArray[np.intp]]
    reason: Sequence[str]
    energy: Floats

    @property
    def case_count(self) -> NDArray[np.intp]:
        """Cases of each part."""
        total: NDArray[np.intp] = np.sum(list(self.counts.values()), axis=0)
        return total

    @property
    def completed(self) -> Floats:
        """Share of the cases that completed, of each part."""
        share: Floats = self.counts[COMPLETED] / self.case_count
        return share

    @property
    def spread(self) -> float:
        """Largest share less the smallest: how much the parameter matters."""
        return float(np.ptp(self.completed))

    def text(self, part: int) -> str:
        """The values of a part in words."""
        low, high = self.bounds[part].tolist()
        few = low == high or self.values.categories
        ends = (self.values.text(it) if few else f"{it:.3g}" for it in (low, high))
        return " to ".join(dict.fromkeys(ends))

    def failures(self, part: int) -> str:
        """What gave way in a part: how many cases of each status, and a reason."""
        failed = {name: int(count[part]) for name, count in self.counts.items()}
        told = [f"{n} {name}" for name, n in failed.items() if n and name != COMPLETED]
        return ": ".join(filter(None, (", ".join(told), self.reason[part]))) or "none"


def shows_stability(dataset: xr.Dataset) -> bool:
    """Whether a study's result tells where it is stable.

    It does where one parameter at a time or random ones of one scene are varied, and a case did
    not complete or the energy error is there.
    """
    if dataset.attrs.get("design") not in (ONE_AT_A_TIME, LATIN_HYPERCUBE):
        return False
    if "status" not in dataset or len(str(dataset.attrs["scene"]).split()) > 1:
        return False
    ran = dataset["status"].values[dataset["status"].values != MISSING]
    return bool(ran.size) and (ENERGY in dataset or bool((ran != COMPLETED).any()))


def strips(dataset: xr.Dataset) -> list[Strip]:
    """A strip for each parameter of a design of one at a time, in the order of the dataset.

    The first case has the defaults. What is derived from a varied parameter has a strip too. Cases
    that were not run yet are left out.
    """
    ran = dataset["status"].values != MISSING
    status, reason, energy = _outcomes(dataset)
    found = []
    for name in varied_along(dataset, ("case",)):
        values = Values.of(dataset, name)
        own = values.numbers != values.numbers[0]
        own[0] = True
        own &= ran
        found.append(
            Strip(
                values=replace(values, numbers=values.numbers[own]),
                default=float(values.numbers[0]),
                status=status[own],
                reason=reason[own],
                energy=energy[own],
            )
        )
    return found


def shares(dataset: xr.Dataset) -> list[Shares]:
    """The shares over each parameter of random cases, those first over which they differ most.

    Parts are single values where there are few of them, else hold about as many cases each. Cases
    that were not run yet are left out.
    """
    ran = dataset.isel(case=dataset["status"].values != MISSING)
    found = [_shares(ran, Values.of(ran, name)) for name in varied_along(ran, ("case",))]
    return sorted(found, key=lambda it: it.spread, reverse=True)


def _shares(dataset: xr.Dataset, values: Values) -> Shares:
    status, reason, energy = _outcomes(dataset)
    numbers = values.numbers
    singles = np.unique(numbers)
    if values.categories or singles.size <= BIN_COUNT:
        part = np.searchsorted(singles, numbers)
    else:
        edges = np.unique(np.quantile(numbers, np.linspace(0.0, 1.0, BIN_COUNT + 1)))
        part = np.searchsorted(edges[1:-1], numbers, side="right")
    members = [np.flatnonzero(part == it) for it in np.unique(part)]
    kinds = [COMPLETED, *sorted(set(status.tolist()) - {COMPLETED})]
    counts = {kind: np.array([np.sum(status[it] == kind) for it in members]) for kind in kinds}
    return Shares(
        values=values,
        bounds=np.array([[numbers[it].min(), numbers[it].max()] for it in members]),
        counts=counts,
        reason=[_first_reason(status[it], reason[it]) for it in members],
        energy=np.array([_median(energy[it]) for it in members]),
    )


def stability_rows(dataset: xr.Dataset) -> Rows:
    """The map as a table to read: a heading, then a row a parameter."""
    if dataset.attrs["design"] == ONE_AT_A_TIME:
        return [STRIP_HEADING, *(_strip_row(strip) for strip in strips(dataset))]
    return [SHARE_HEADING, *(_share_row(it) for it in shares(dataset))]


def _strip_row(strip: Strip) -> tuple[str, ...]:
    default = strip.values.text(strip.default)
    margins = (strip.margin(-1), strip.margin(1))
    known = strip.energy[np.isfinite(strip.energy)]
    share = f"up to {known.max():.0%} of the limit" if known.size else ""
    return strip.values.label, default, strip.stable_text, *margins, share


def _share_row(it: Shares) -> tuple[str, ...]:
    least = int(np.argmin(it.completed))
    told = ", ".join(
        f"{it.text(part)}: {share:.0%} of {count}"
        for part, (share, count) in enumerate(zip(it.completed, it.case_count, strict=True))
    )
    return it.values.label, told, f"{it.spread:.0%}", it.text(least), it.failures(least)


def _outcomes(dataset: xr.Dataset) -> tuple[NDArray[np.str_], NDArray[np.str_], Floats]:
    """Status, reason and energy error over the largest allowed, of each case."""
    status = dataset["status"].values.astype(str)
    reason = np.array([short_reason(str(message)) for message in dataset["message"].values])
    if ENERGY not in dataset:
        return status, reason, np.full(status.shape, np.nan)
    return status, reason, np.abs(dataset[ENERGY].values) / LARGEST_ENERGY_ERROR


def short_reason(message: str) -> str:
    """What gave way, out of a message: without the exception's name, places, times and remedy."""
    text = re.sub(r"^\w+: ", "", message)
    text = re.sub(r" (at|is) \[[^]]*\]( m)?", "", text)
    return re.split(r", at |, more than |; |: ", text)[0]


def _first_reason(status: NDArray[np.str_], reason: NDArray[np.str_]) -> str:
    failed = Counter(status[status != COMPLETED].tolist())
    if not failed:
        return ""
    return str(reason[status == failed.most_common(1)[0][0]][0])


def _median(energy: Floats) -> float:
    known = energy[np.isfinite(energy)]
    return float(np.median(known)) if known.size else np.nan


def _category(value: object) -> str:
    if isinstance(value, float):
        return "derived" if np.isnan(value) else f"{value:.6g}"
    return str(value) or "derived"
