"""Stability from a default, one parameter at a time: the stable span and the margin to its ends."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from harness.archive.conventions import COMPLETED, MISSING, varied_names
from harness.pictures.drawing.quantities import Floats, Texts, Values
from harness.pictures.stability.outcomes import outcomes

NO_CASE = "no case"
FAILURES = ("first failure below", "first failure above")
STRIP_HEADING = ("parameter", "default", "stable", *FAILURES, "limit")


@dataclass(frozen=True, kw_only=True)
class Strip:
    """How the case of defaults ended, and those that differ from it in one parameter.

    Attributes:
        values: of the parameter.
        default: its value in the case from which all others start; the first of categories.
        status: of each case.
        reason: why it did not complete, in a few words.
        limit_share: size of results over their limit; not a number where nothing has one.
    """

    values: Values
    default: float
    status: Texts
    reason: Texts
    limit_share: Floats

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
            return NO_CASE
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


def strips(dataset: xr.Dataset) -> list[Strip]:
    """A strip for each parameter of a design of one at a time, in the order of the dataset.

    The first case has the defaults. What is derived from a varied parameter has a strip too. Cases
    that were not run yet are left out.
    """
    ran = dataset["status"].values != MISSING
    status, reason, limit_share = outcomes(dataset)
    found = []
    for name in varied_names(dataset):
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
                limit_share=limit_share[own],
            )
        )
    return found


def strip_row(strip: Strip) -> tuple[str, ...]:
    """A strip in words, under `STRIP_HEADING`."""
    default = strip.values.text(strip.default)
    margins = (strip.margin(-1), strip.margin(1))
    known = strip.limit_share[np.isfinite(strip.limit_share)]
    share = f"up to {known.max():.0%} of the limit" if known.size else ""
    return strip.values.label, default, strip.stable_text, *margins, share
