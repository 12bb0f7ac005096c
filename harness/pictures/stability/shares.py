"""Stability of random cases: the share that completed, over the range of each parameter."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from harness.archive.conventions import COMPLETED, MISSING, varied_names
from harness.pictures.drawing.quantities import Floats, Texts, Values
from harness.pictures.stability.outcomes import outcomes

PART_COUNT = 5
"""Parts of equally many cases that the range of a parameter is cut into."""
SHARE_HEADING = ("parameter", "completed", "spread", "least", "what gives way there")


@dataclass(frozen=True, kw_only=True)
class Shares:
    """How random cases ended in each part of a parameter's range.

    Attributes:
        values: of the parameter.
        bounds: lowest and highest value of each part, shape [part_count, 2].
        counts: cases of each part by status, shape [part_count].
        reason: the first reason given in each part for the status that is most frequent there
            after ``completed``; empty where all completed.
        limit_share: median size of results over their limit, of those that completed, shape
            [part_count]; not a number where nothing has a limit.
    """

    values: Values
    bounds: Floats
    counts: Mapping[str, NDArray[np.intp]]
    reason: Sequence[str]
    limit_share: Floats

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
        if low == high:
            return self.values.text(low)
        return " to ".join(self.values.text(float(f"{end:.3g}")) for end in (low, high))

    def failures(self, part: int) -> str:
        """What gave way in a part: how many cases of each status, and a reason."""
        failed = {name: int(count[part]) for name, count in self.counts.items()}
        told = [f"{n} {name}" for name, n in failed.items() if n and name != COMPLETED]
        return ": ".join(filter(None, (", ".join(told), self.reason[part]))) or "none"


def shares(dataset: xr.Dataset) -> list[Shares]:
    """The shares over each parameter of random cases, those first over which they differ most.

    Parts are single values where there are few of them, else hold about as many cases each. Cases
    that were not run yet are left out.
    """
    ran = dataset.isel(case=dataset["status"].values != MISSING)
    found = [_shares(ran, Values.of(ran, name)) for name in varied_names(ran)]
    return sorted(found, key=lambda it: it.spread, reverse=True)


def _shares(dataset: xr.Dataset, values: Values) -> Shares:
    status, reason, limit_share = outcomes(dataset)
    numbers = values.numbers
    singles = np.unique(numbers)
    if values.categories or singles.size <= PART_COUNT:
        part = np.searchsorted(singles, numbers)
    else:
        edges = np.unique(np.quantile(numbers, np.linspace(0.0, 1.0, PART_COUNT + 1)))
        part = np.searchsorted(edges[1:-1], numbers)
    members = [np.flatnonzero(part == it) for it in np.unique(part)]
    kinds = [COMPLETED, *sorted(set(status.tolist()) - {COMPLETED})]
    counts = {kind: np.array([np.sum(status[it] == kind) for it in members]) for kind in kinds}
    return Shares(
        values=values,
        bounds=np.array([[numbers[it].min(), numbers[it].max()] for it in members]),
        counts=counts,
        reason=[_first_reason(status[it], reason[it]) for it in members],
        limit_share=np.array([_median(limit_share[it]) for it in members]),
    )


def share_row(it: Shares) -> tuple[str, ...]:
    """The shares over a parameter in words, under `SHARE_HEADING`."""
    least = int(np.argmin(it.completed))
    told = ", ".join(
        f"{it.text(part)}: {share:.0%} of {count}"
        for part, (share, count) in enumerate(zip(it.completed, it.case_count, strict=True))
    )
    return it.values.label, told, f"{it.spread:.0%}", it.text(least), it.failures(least)


def _first_reason(status: Texts, reason: Texts) -> str:
    failed = Counter(status[status != COMPLETED].tolist())
    if not failed:
        return ""
    return str(reason[status == failed.most_common(1)[0][0]][0])


def _median(numbers: Floats) -> float:
    known = numbers[np.isfinite(numbers)]
    return float(np.median(known)) if known.size else np.nan
