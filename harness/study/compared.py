"""What a study is compared with: ``[compare]``, and references of its own, ``[references.NAME]``.

That is references, the result of another study, experience, and tolerances. A reference of its own
is a formula of parameters of the scene, in SI units, and of the symbols of those that ship.
"""

import functools
import json
import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from harness.references.cone_factors import COMPARED, Conditions, ConeFactor, Quantity
from harness.references.registry import EXPERIENCE_IDS, REFERENCE_IDS, cone_factor_reference
from harness.study.expressions import Expression, ExpressionError
from harness.study.files import find_study
from harness.study.scene_part import Scene, ScenePart
from harness.study.tables import StudyError, Table, is_number, shown
from mpm_warp.parameters import Value, did_you_mean, nearest_name

ERROR = "error"
"""Result with the error against the exact solution, of scenes that have one."""
ERROR_FINEST = "error_finest"
"""Result with the error against the case known best, of scenes without an exact solution."""
REFERENCE_STUDY = "reference_study"
OWN_REFERENCES = "references"
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
MISSPELT = 0.85
"""Likeness from which on a name is a slip; two results of a scene are less alike."""


@dataclass(frozen=True, kw_only=True)
class Compared:
    """What a result is compared with; every name is known."""

    references: tuple[ConeFactor, ...]  # of the literature or the study's own
    reference_result: Path | None  # whose cases stand for the true values of errors
    experience: tuple[str, ...]  # bands of factors measured in the field, to set beside the result
    tolerances: Mapping[str, float]  # largest deviation from a reference, or size of a result


def read_compared(document: Table, parts: Sequence[ScenePart], folder: Path) -> Compared:
    """What a study with these scenes, whose file is in a folder, is compared with.

    The references that it defines itself are among them, whether it names them again or not.
    """
    table = document.table("compare")
    table.allow("references", REFERENCE_STUDY, "experience", "tolerance")
    own = _own_references(document.table(OWN_REFERENCES), parts)
    named = _ids(table, "references", "reference", (*REFERENCE_IDS, *own), parts)
    references = dict.fromkeys([*named, *own])
    return Compared(
        references=tuple(
            own.get(reference) or cone_factor_reference(reference) for reference in references
        ),
        reference_result=_reference_result(table, parts, folder),
        experience=_ids(table, "experience", "band of experience", EXPERIENCE_IDS, parts),
        tolerances=_tolerances(table.table("tolerance"), list(references), parts),
    )


def takes_references(scene: Scene) -> bool:
    """Whether a scene gives what the references and the experience are of."""
    return scene.comparable == COMPARED


def _own_references(table: Table, parts: Sequence[ScenePart]) -> dict[str, "OwnReference"]:
    """The references that the study defines: formulas of parameters of the scenes compared."""
    compared = [part for part in parts if takes_references(part.scene)]
    if table.values and not compared:
        raise StudyError(f"{table.where}: no scene here gives a {COMPARED}, which they are of")
    known = dict.fromkeys(name for part in compared for name in part.parameters)
    return {name: read_own_reference(name, table.table(name), known) for name in table.values}


def _reference_result(table: Table, parts: Sequence[ScenePart], folder: Path) -> Path | None:
    """The result, kept beside its study, whose cases stand for the true values."""
    if REFERENCE_STUDY not in table.values:
        return None
    if len(parts) > 1 or not takes_references(parts[0].scene):
        raise table.refuse(REFERENCE_STUDY, f"needs one scene, which gives a {COMPARED}")
    try:
        result = find_study(table.text(REFERENCE_STUDY), folder).with_suffix(".nc")
    except StudyError as error:
        raise table.refuse(REFERENCE_STUDY, str(error)) from None
    if not result.is_file():
        raise table.refuse(
            REFERENCE_STUDY, f"its result {result} is missing: run that study, and put it there"
        )
    return result


def _ids(
    table: Table, key: str, noun: str, known: Sequence[str], parts: Sequence[ScenePart]
) -> tuple[str, ...]:
    """What a study is compared with, under one key: each known, and named once."""
    ids = table.list(key)
    for given in ids:
        if not isinstance(given, str) or given not in known:
            raise table.refuse(
                key, f"unknown {noun} {shown(given)}{nearest_name(shown(given), known)}"
            )
    if len(set(ids)) < len(ids):
        raise table.refuse(key, f"names a {noun} twice")
    if ids and not any(takes_references(part.scene) for part in parts):
        raise table.refuse(key, f"no scene here gives a {COMPARED}, which they are of")
    return tuple(ids)


def _tolerances(
    table: Table, references: Sequence[str], parts: Sequence[ScenePart]
) -> dict[str, float]:
    """Tolerances by name, which may be that of any result: slips in known names are refused."""
    unused = set(REFERENCE_IDS) - set(references)
    verified = {
        name for part in parts for check in part.scene.verifications for name in check.bounds
    }
    known = {*references, COMPARED, ERROR, ERROR_FINEST, *verified}
    for name in table.values:
        if name in EXPERIENCE_IDS:
            raise table.refuse(name, "is a band of experience, from which no result deviates")
        if name in unused:
            raise table.refuse(name, "is not among the references of [compare]")
        if name not in known and (near := did_you_mean(name, known, MISSPELT)):
            raise table.refuse(name, f"is neither a reference nor a result{near}")
    return {name: table.positive(name) for name in table.values}


@dataclass(frozen=True, kw_only=True)
class OwnReference(ConeFactor):
    """A reference of a study's own; outside its ranges it has no value.

    The formula depends on the parameters and symbols `names`; the ranges are by parameter or
    symbol.
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
    if name in REFERENCE_IDS or name in EXPERIENCE_IDS:
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
        for symbol in names:
            if every is not None and symbol not in every:
                problem = f"unknown parameter or symbol {symbol!r}{nearest_name(symbol, every)}"
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
    ends = ranges.list(name)
    if len(ends) != 2 or not all(map(is_number, ends)) or ends[0] > ends[1]:
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

    given = [_quantity(conditions, name) for name in names]
    inside = _lies_within(ranges, conditions)
    values: Quantity = xr.apply_ufunc(value, inside, *given, vectorize=True, output_dtypes=[float])
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
