"""References that a study's own file defines: a formula in the language of its expressions.

The formula has parameters of the scene, in SI units, and the symbols of the references that ship.
"""

import functools
import json
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr

from harness.references.cone_factors import Conditions, ConeFactor, Quantity
from harness.references.registry import experience_ids, reference_ids
from harness.study.expressions import Expression, ExpressionError
from harness.study.tables import StudyError, Table
from mpm_warp.parameters import Value, nearest_name

OWN_REFERENCES = "references"
"""Key of the table."""
OWN_LABEL = "label"
"""Key that every reference of a study's own has, in the study and in the file of a result."""
REFERENCE_NAME = "[a-z][a-z0-9_]*"
"""What the name of a reference looks like, as a pattern."""
SYMBOLS = {
    "Ir": "rigidity_index",
    "alpha_c": "face_adhesion",
    "alpha_s": "shaft_adhesion",
    "Delta": "stress_anisotropy",
}
"""Symbols that a formula may have, and what they are among the `Conditions`."""
OPTIONAL = {
    "how_known": "as the study's own file says",
    "criterion": "not stated here",
    "method": "not stated here",
}
"""Texts that may be left out, and what they are then."""


@dataclass(frozen=True, kw_only=True)
class OwnReference(ConeFactor):
    """A reference of a study's own; outside its ranges it has no value.

    Attributes:
        names: parameters and symbols that the formula depends on.
        ranges: least and greatest value that the formula is meant for, by parameter or symbol.
    """

    names: frozenset[str]
    ranges: Mapping[str, tuple[float, float]]

    @property
    def validity(self) -> str:
        """The conditions that the formula is meant for, in words."""
        spans = [f"{name} {low:g} to {high:g}" for name, (low, high) in self.ranges.items()]
        return ", ".join(spans) or "no range stated"

    def applies(self, conditions: Conditions) -> Quantity:
        """Whether `conditions` lie within all ranges, element by element."""
        return _lies_within(self.ranges, conditions)

    def as_attributes(self) -> dict[str, str]:
        """What the file of a result keeps, beside what it keeps of those that ship."""
        return {OWN_LABEL: self.label, "range": json.dumps(self.ranges)}


def stored_own_reference(name: str, attributes: Mapping[str, Any]) -> OwnReference:
    """A reference as the file of a result keeps it."""
    keys = ("formula", OWN_LABEL, "source", *OPTIONAL)
    said = {key: attributes[key] for key in keys if key in attributes}
    try:
        ranges = json.loads(attributes.get("range", "{}"))
    except (TypeError, ValueError):
        ranges = None
    return read_own_reference(name, Table(f"reference {name}:", said | {"range": ranges}), None)


def read_own_reference(name: str, table: Table, known: Collection[str] | None) -> OwnReference:
    """A reference from its table [references.NAME].

    Its formula may have the parameters `known` and `SYMBOLS`, or any name where that is None.
    """
    table.allow("formula", "label", "source", *OPTIONAL, "range")
    if not re.fullmatch(REFERENCE_NAME, name):
        raise StudyError(f"{table.where}: a name is small letters, digits and '_', a letter first")
    if name in reference_ids() or name in experience_ids():
        raise StudyError(f"{table.where}: the harness has a reference of this name; choose another")
    text = table.text("formula", "; an expression of parameters of the scene")
    try:
        formula = Expression.parsed(text)
    except ExpressionError as error:
        raise table.refuse("formula", str(error)) from None
    every = None if known is None else (*known, *SYMBOLS)
    if formula.is_condition:
        raise table.refuse("formula", "is a condition; it must give a number")
    ranges = table.table("range")
    for key, names in (("formula", sorted(formula.names)), ("range", list(ranges.values))):
        for it in names:
            if every is not None and it not in every:
                problem = f"unknown parameter or symbol {it!r}{nearest_name(it, every)}"
                raise table.refuse(key, problem)
    bounds = {name: _span(ranges, name) for name in ranges.values}
    optional = OPTIONAL | {key: table.text(key) for key in OPTIONAL if key in table.values}
    return OwnReference(
        id=name,
        label=table.text("label", "; its name in pictures, as authors and year"),
        formula=text,
        evaluate=functools.partial(_evaluated, formula, bounds),
        source=table.text("source", "; where it is published"),
        names=formula.names,
        ranges=bounds,
        how_known=optional["how_known"],
        criterion=optional["criterion"],
        method=optional["method"],
    )


def _span(ranges: Table, name: str) -> tuple[float, float]:
    """Least and greatest value of a range."""
    ends = ranges.list(name)
    if (
        len(ends) != 2
        or not all(type(end) in (int, float) and math.isfinite(end) for end in ends)
        or ends[0] > ends[1]
    ):
        raise ranges.refuse(name, "must be two numbers, the least and the greatest")
    return float(ends[0]), float(ends[1])


def _evaluated(
    formula: Expression, ranges: Mapping[str, tuple[float, float]], conditions: Conditions
) -> Quantity:
    """The formula element by element; not a number outside the ranges, or where it has no value."""
    names = sorted(formula.names)

    def value(inside: bool, *given: Value) -> float:
        try:
            found = formula.value(dict(zip(names, given, strict=True)))
        except ExpressionError:
            return math.nan
        return found if inside and isinstance(found, float) else math.nan

    quantities = [_quantity(conditions, name) for name in names]
    inside = _lies_within(ranges, conditions)
    values: Quantity = xr.apply_ufunc(
        value, inside, *quantities, vectorize=True, output_dtypes=[float]
    )
    return values


def _lies_within(ranges: Mapping[str, tuple[float, float]], conditions: Conditions) -> xr.DataArray:
    inside = xr.DataArray(True)
    for name, (low, high) in ranges.items():
        quantity = xr.DataArray(_quantity(conditions, name))
        inside = inside & (quantity >= low) & (quantity <= high)
    return inside


def _quantity(conditions: Conditions, name: str) -> Quantity:
    """A parameter or what a symbol stands for; not a number where the scene has none."""
    if name in SYMBOLS:
        found: Quantity = getattr(conditions, SYMBOLS[name])
        return found
    return conditions.parameters.get(name, math.nan)
