"""A reference for the cone factor Nc = (qc - sigma_v0) / su: a formula or points.

Those that ship are in entries.toml; a study defines its own in the same way.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import xarray as xr

from harness.expressions import Expression, ExpressionError
from harness.references.strength import (
    CRITERION,
    MAY_MEAN,
    Conditions,
    Criterion,
    StrengthMode,
    by_su_in,
    in_test,
    of_law,
)
from mpm_warp.fields.declaration import Value

COMPARED = "cone_factor"
"""The result that references are compared with."""
NEEDED = ("rigidity_index", "adhesion_factor")
"""Parameters that a scene needs for a comparison."""
SYMBOLS: Mapping[str, str] = {
    "Ir": "G / su",
    "alpha_c": "adhesion factor of the cone's face",
    "alpha_s": "that of the shaft",
    "Delta": "(sigma_v0 - sigma_h0) / (2 su)",
    "apex_angle": "of the cone [degree]",
    "friction": "Coulomb coefficient",
    "constant_su": "1 in Tresca or von Mises clay whose su nothing changes, else 0",
}
"""What formulas, points and ranges may use beside parameters of the scene."""
SYMBOL_OF: Mapping[str, str] = {
    "rigidity_index": "Ir",
    "adhesion_factor": "alpha_c",
    "stress_anisotropy": "Delta",
}
"""The symbol that follows a parameter."""
USUAL: Conditions = {
    "alpha_c": 0.0,
    "alpha_s": 0.0,
    "Delta": 0.0,
    "apex_angle": 60.0,
    "friction": 0.0,
    "constant_su": 1.0,
    **of_law(Criterion.TRESCA),
}
"""Conditions of a smooth cone in Tresca clay of a constant strength."""
FACTOR = "Nc"
"""Column of points with the cone factor."""
SAME = 1e-9
"""Conditions are those of a point if they differ by less than this share."""


@dataclass(frozen=True, kw_only=True)
class Reference:
    """One formula for the cone factor, or a table of its values."""

    id: str  # name in study files and in the variables of a result
    label: str  # authors and year, for pictures
    formula: Expression | None  # None: there are points
    points: Mapping[str, Sequence[float]]  # columns of symbols or parameters, and `FACTOR`
    range: Mapping[str, tuple[float, float]]  # where it is valid, by symbol or parameter
    source: str  # where it was published
    criterion: Criterion = Criterion.NOT_STATED
    su_mode: StrengthMode = StrengthMode.NOT_STATED
    method: str = "not stated here"  # how the source arrived at it
    how_known: str = "as the study's own file says"  # where the coefficients were taken from
    extrapolates: bool = False  # whether the formula has a value outside its range too
    in_envelope: bool = False  # whether the envelope that is shown with a result has it

    @classmethod
    def of(cls, name: str, entry: Mapping[str, Any]) -> Self:
        """A reference of the keys and values of its table, which are valid."""
        made: dict[str, Any] = {
            "formula": Expression.parsed(entry["formula"]) if entry.get("formula") else None,
            "points": entry.get("points", {}),
            "range": {key: span(value) for key, value in entry.get("range", {}).items()},
            "criterion": Criterion(entry.get("criterion", Criterion.NOT_STATED)),
            "su_mode": StrengthMode(entry.get("su_mode", StrengthMode.NOT_STATED)),
        }
        return cls(id=name, **{**entry, **made})

    @property
    def text(self) -> str:
        """The formula, or what the points are over."""
        if self.formula is not None:
            return self.formula.text
        columns = [name for name in self.points if name != FACTOR]
        return f"{len(self.points[FACTOR])} points over {', '.join(columns)}"

    @property
    def definition(self) -> str:
        """Criterion and meaning of su, in words."""
        return (
            f"{'criterion ' if self.criterion is Criterion.NOT_STATED else ''}{self.criterion_name}"
            f", {'test of su' if self.su_mode is StrengthMode.NOT_STATED else 'su in'} "
            f"{self.su_mode.replace('_', ' ')}"
        )

    @property
    def criterion_name(self) -> str:
        """The criterion in words."""
        words = self.criterion.replace("_", " ")
        for name in ("tresca", "mises", "cam"):
            words = words.replace(name, name.title())
        return words

    @property
    def validity(self) -> str:
        """The conditions for which it is valid, in words."""
        spans = (
            f"{name} {low:g}{'' if low == high else f' to {high:g}'}"
            for name, (low, high) in self.range.items()
        )
        return ", ".join(spans) or "no range stated"

    @property
    def names(self) -> frozenset[str]:
        """Symbols and parameters that its value depends on."""
        return frozenset([*self._variables, *self.range])

    @property
    def _variables(self) -> list[str]:
        names = self.points.keys() - {FACTOR} if self.formula is None else self.formula.names
        return sorted(names)

    def readings(self, conditions: Conditions) -> tuple[Self, ...]:
        """The reference by each test that its su may be from.

        It is the reference itself, if the test is stated or its su the same in all `conditions`.
        """
        if self.su_mode is not StrengthMode.NOT_STATED:
            return (self,)
        first, *others = (in_test(conditions, mode) for mode in MAY_MEAN)
        if all(((it == first) | (it.isnull() & first.isnull())).all() for it in others):
            return (self,)
        return tuple(map(self.read_as, MAY_MEAN))

    def read_as(self, mode: StrengthMode) -> Self:
        """The reference, its su from a test that it does not state."""
        label = f"{self.label}, if su is in {mode.replace('_', ' ')}"
        return replace(self, id=f"{self.id}_{mode}", label=label, su_mode=mode)

    def has_criterion(self, conditions: Conditions) -> xr.DataArray:
        """Whether the criterion is that of `conditions`, or is not stated, element by element."""
        is_any = self.criterion is Criterion.NOT_STATED
        return (xr.DataArray(conditions[CRITERION]) == str(self.criterion)) | is_any

    def applies(self, conditions: Conditions) -> xr.DataArray:
        """Whether criterion and range are those of `conditions`, element by element."""
        return self._is_valid(conditions) & self.has_criterion(conditions)

    def _is_valid(self, conditions: Conditions) -> xr.DataArray:
        """Whether `conditions` are in the range; points have a value only at their places."""
        own, inside = by_su_in(conditions, self.su_mode), xr.DataArray(True)
        for name, (low, high) in self.range.items():
            quantity = _quantity(own, name)
            inside = inside & (quantity >= low) & (quantity <= high)
        return inside if self.formula is not None else inside & self._value(own).notnull()

    def evaluate(self, conditions: Conditions) -> xr.DataArray:
        """The cone factor over the su of `conditions`, element by element; NaN where it has none.

        The reference is evaluated by its own su.
        """
        ratio = in_test(conditions, self.su_mode)
        value = ratio * self._value(by_su_in(conditions, self.su_mode))
        return value if self.extrapolates else value.where(self._is_valid(conditions))

    def _value(self, conditions: Conditions) -> xr.DataArray:
        def value(*given: Value) -> float:
            at = dict(zip(self._variables, given, strict=True))
            return self._at_point(at) if self.formula is None else _number(self.formula, at)

        given = [_quantity(conditions, name) for name in self._variables]
        with np.errstate(all="ignore"):  # a formula without a value, as a root of -1, is NaN
            values = xr.apply_ufunc(value, *given, vectorize=True, output_dtypes=[float])
        return xr.DataArray(values)

    def _at_point(self, at: Mapping[str, Any]) -> float:
        for row, factor in enumerate(self.points[FACTOR]):
            if all(
                math.isclose(it, self.points[name][row], rel_tol=SAME) for name, it in at.items()
            ):
                return factor
        return math.nan


def span(given: float | Sequence[float]) -> tuple[float, float]:
    """The least and the greatest value of an entry of a range, [least, greatest] or one number."""
    low, high = given if isinstance(given, Sequence) else (given, given)
    return float(low), float(high)


def _quantity(conditions: Conditions, name: str) -> xr.DataArray:
    """The value of a parameter or symbol; NaN where the scene has no such parameter."""
    return xr.DataArray(conditions.get(name, math.nan))


def _number(formula: Expression, at: Mapping[str, Value]) -> float:
    try:
        found = formula.value(at)
    except ExpressionError:
        return math.nan
    return found if isinstance(found, float) else math.nan
