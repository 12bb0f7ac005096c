"""A band of factors of cone tests that were measured in the field.

Measured factors hold effects that the ideal cone factor does not have. So a band is shown beside a
result but is no reference: no deviation from it is computed, and a result need not lie in it.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Self

from harness.expressions import Expression
from harness.references.reference import span
from harness.references.strength import StrengthMode


class Factor(StrEnum):
    """Kind of factor: u2 is the pore pressure behind the shoulder, u0 the one before the test."""

    RESISTANCE = "Nkt"
    PORE_PRESSURE = "N_du"

    @property
    def definition(self) -> str:
        """The factor as a formula."""
        over_su = {"Nkt": "(qt - sigma_v0) / su", "N_du": "(u2 - u0) / su"}
        return f"{self} = {over_su[self]}"


@dataclass(frozen=True, kw_only=True)
class Band:
    """One band of factors."""

    id: str  # name in study files and in the variables of a result
    label: str  # authors and year, for pictures
    factor: Factor
    formula: Expression  # of the properties in `range`, monotonic in each
    range: Mapping[str, tuple[float, float]]  # of each property of the clay
    chosen: Mapping[str, str]  # where each range comes from
    clays: str  # the tested clays
    source: str  # where it was published
    how_known: str  # where formula and ranges were taken from
    su_mode: StrengthMode
    strength: str  # meaning of su in words
    other_strengths: str  # how they compare with it
    holds: str  # effects that the factor includes
    scatter: float = 0.0  # relative, about the formula; 0: none is known

    @classmethod
    def of(cls, name: str, entry: Mapping[str, Any]) -> Self:
        """A band of the keys and values of its table."""
        made: dict[str, Any] = {
            "factor": Factor(entry["factor"]),
            "formula": Expression.parsed(entry["formula"]),
            "range": {key: span(value) for key, value in entry["range"].items()},
            "su_mode": StrengthMode(entry["su_mode"]),
        }
        return cls(id=name, **{**entry, **made})

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest factor over the ranges, with scatter."""
        corners = itertools.product(*self.range.values())
        places = (dict(zip(self.range, corner, strict=True)) for corner in corners)
        values = [float(self.formula.value(place)) for place in places]
        return min(values) * (1.0 - self.scatter), max(values) * (1.0 + self.scatter)

    @property
    def band(self) -> str:
        """Factor and bounds in words."""
        low, high = self.bounds
        return f"{self.factor} {low:.1f} to {high:.1f}"

    @property
    def spans(self) -> str:
        """Ranges of the properties, and scatter, in words."""
        ranges = (f"{name} {low:g} to {high:g}" for name, (low, high) in self.range.items())
        return ", ".join(ranges) + (f", +-{100 * self.scatter:.0f} %" if self.scatter else "")
