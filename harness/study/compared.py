"""What a study is compared with: the tables ``[compare]`` and ``[references.NAME]``.

``[compare]`` names references, bands of experience, a reference study and tolerances.
``[references.NAME]`` defines a reference of the user's own: a formula of parameters of the scene
in SI units, and of the symbols Ir, alpha_c, alpha_s and Delta.
"""

import functools
import json
import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import MISSING, dataclass, replace
from pathlib import Path
from typing import Any

import xarray as xr

from harness.references.cone_factors import COMPARED, Conditions, ConeFactor, Quantity
from harness.references.registry import EXPERIENCE_IDS, REFERENCE_IDS, cone_factor_reference
from harness.study.expressions import Expression, ExpressionError, expression_schema
from harness.study.files import find_study
from harness.study.scene_part import Scene, ScenePart
from harness.study.tables import LINE, StudyError, Table, is_number, text_key
from mpm_warp.checks import POSITIVE, shown
from mpm_warp.fields import Form, Parameter, Value
from mpm_warp.names import did_you_mean, nearest_name

ERROR = "error"
"""Result with the error against the exact solution, of scenes that have one."""
ERROR_FINEST = "error_finest"
"""Result with the difference from the most accurate case, in scenes without an exact solution."""
NO_CONE_FACTOR = f"needs a scene that computes a {COMPARED}"
REFERENCE_STUDY = "reference_study"
OWN_REFERENCES = "references"
OWN_LABEL = "label"
"""Key by which a reference of the user's own is recognised in the file of a result."""
REFERENCE_NAME = "[a-z][a-z0-9_]*"
"""Pattern of the name of a reference."""
SYMBOLS = {
    "Ir": "rigidity_index",
    "alpha_c": "face_adhesion",
    "alpha_s": "shaft_adhesion",
    "Delta": "stress_anisotropy",
}
"""Symbols that a formula may use, and the field of `Conditions` that each stands for."""
FORMULA = replace(
    text_key("formula", f"formula of parameters, or of {', '.join(SYMBOLS)}"),
    form=Form("an expression", LINE.read, lambda declared: [expression_schema()]),
)
TEXTS = (
    FORMULA,
    text_key(OWN_LABEL, "name in pictures, such as authors and year"),
    text_key("source", "where it is published"),
    text_key("how_known", "how the formula is known", "as the study's own file says"),
    text_key("criterion", "yield criterion", "not stated here"),
    text_key("method", "method by which it was found", "not stated here"),
)
"""Texts of a reference of the user's own."""
RESULT = text_key(REFERENCE_STUDY, "study; errors are differences from its stored result", None)
TOLERANCE = Parameter(
    name="tolerance",
    kind=float,
    default=MISSING,
    meaning="largest deviation from a reference, or size of a result",
    bounds=POSITIVE,
)
MISSPELLING_LIKENESS = 0.85
"""A name at least this similar to a known one is a misspelling; names of two results are not."""


@dataclass(frozen=True, kw_only=True)
class Compared:
    """What a result is compared with. Every name has been checked."""

    references: tuple[ConeFactor, ...]  # from the literature or defined in the study
    reference_result: Path | None  # file of the result that errors are differences from
    experience: tuple[str, ...]  # names of bands measured in the field, shown beside the result
    tolerances: Mapping[str, float]  # largest deviation from a reference, or size of a result


def read_compared(document: Table, parts: Sequence[ScenePart], folder: Path) -> Compared:
    """Read what a study is compared with.

    References that the study defines are always included, whether [compare] names them or not.

    Args:
        document: the whole study file.
        parts: the scenes of the study.
        folder: folder of the study file; a reference study is looked for there.
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
    """Whether a scene computes a cone factor, which references and experience are about."""
    return scene.comparable == COMPARED


def _own_references(table: Table, parts: Sequence[ScenePart]) -> dict[str, "OwnReference"]:
    """The references that the study defines; a formula may use parameters of any compared scene."""
    compared = [part for part in parts if takes_references(part.scene)]
    if table.values and not compared:
        raise StudyError(f"{table.where}: {NO_CONE_FACTOR}")
    known = dict.fromkeys(name for part in compared for name in part.parameters)
    return {name: read_own_reference(name, table.table(name), known) for name in table.values}


def _reference_result(table: Table, parts: Sequence[ScenePart], folder: Path) -> Path | None:
    """The result of the reference study, a file beside that study; None where none is named."""
    if REFERENCE_STUDY not in table.values:
        return None
    if len(parts) > 1 or not takes_references(parts[0].scene):
        raise table.refuse(REFERENCE_STUDY, f"needs a single scene that computes a {COMPARED}")
    try:
        result = find_study(table.read(RESULT), folder).with_suffix(".nc")
    except StudyError as error:
        raise table.refuse(REFERENCE_STUDY, str(error)) from None
    if not result.is_file():
        raise table.refuse(
            REFERENCE_STUDY,
            f"its result {result} is missing; run that study and copy its result there",
        )
    return result


def _ids(
    table: Table, key: str, noun: str, known: Sequence[str], parts: Sequence[ScenePart]
) -> tuple[str, ...]:
    """The names under one key of [compare]; each must be known and stand there once."""
    ids = table.list(key)
    for given in ids:
        if not isinstance(given, str) or given not in known:
            raise table.refuse(
                key, f"unknown {noun} {shown(given)}{nearest_name(shown(given), known)}"
            )
    if len(set(ids)) < len(ids):
        raise table.refuse(key, f"names a {noun} twice")
    if ids and not any(takes_references(part.scene) for part in parts):
        raise table.refuse(key, NO_CONE_FACTOR)
    return tuple(ids)


def _tolerances(
    table: Table, references: Sequence[str], parts: Sequence[ScenePart]
) -> dict[str, float]:
    """Tolerances by name of a reference or a result.

    Names of results are known only after a run, so only misspellings of known names are refused.
    """
    unused = set(REFERENCE_IDS) - set(references)
    verified = {
        name for part in parts for check in part.scene.verifications for name in check.bounds
    }
    known = {*references, COMPARED, ERROR, ERROR_FINEST, *verified}
    for name in table.values:
        if name in EXPERIENCE_IDS:
            raise table.refuse(name, "is a band of experience; a tolerance needs a reference")
        if name in unused:
            raise table.refuse(name, "is not among the references of [compare]")
        if name not in known and (near := did_you_mean(name, known, MISSPELLING_LIKENESS)):
            raise table.refuse(name, f"is neither a reference nor a result{near}")
    return {name: table.read(replace(TOLERANCE, name=name)) for name in table.values}


@dataclass(frozen=True, kw_only=True)
class OwnReference(ConeFactor):
    """A reference that a study defines. Outside its ranges its value is not a number."""

    names: frozenset[str]  # parameters and symbols in the formula
    ranges: Mapping[str, tuple[float, float]]  # least and greatest value, by parameter or symbol

    @property
    def validity(self) -> str:
        """The conditions that the formula is meant for, in words."""
        spans = [f"{name} {low:g} to {high:g}" for name, (low, high) in self.ranges.items()]
        return ", ".join(spans) or "no range stated"

    def applies(self, conditions: Conditions) -> Quantity:
        """Whether `conditions` lie inside all ranges, element by element."""
        return _lies_within(self.ranges, conditions)


def stored_own_reference(name: str, attributes: Mapping[str, Any]) -> OwnReference:
    """A reference of the user's own, read from the attributes that the file of a result keeps."""
    said = {it.name: attributes[it.name] for it in TEXTS if it.name in attributes}
    try:
        ranges = json.loads(attributes.get("range", "{}"))
    except (TypeError, ValueError):
        ranges = None
    return read_own_reference(name, Table(f"reference {name}:", said | {"range": ranges}), None)


def read_own_reference(name: str, table: Table, known: Collection[str] | None) -> OwnReference:
    """A reference from its table [references.NAME].

    Args:
        name: NAME.
        table: the table.
        known: parameters that the formula may use beside `SYMBOLS`; None allows any name.
    """
    table.allow(*(it.name for it in TEXTS), "range")
    if not re.fullmatch(REFERENCE_NAME, name):
        raise StudyError(
            f"{table.where}: a name has lower-case letters, digits and '_', with a letter first"
        )
    if name in REFERENCE_IDS or name in EXPERIENCE_IDS:
        raise StudyError(f"{table.where}: a reference that ships has this name; choose another")
    texts = {it.name: table.read(it) for it in TEXTS}
    try:
        formula = Expression.parsed(texts["formula"])
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
    return OwnReference(
        id=name,
        evaluate=functools.partial(_evaluated, formula, bounds),
        names=formula.names,
        ranges=bounds,
        **texts,
    )


def _span(ranges: Table, name: str) -> tuple[float, float]:
    ends = ranges.list(name)
    if len(ends) != 2 or not all(map(is_number, ends)) or ends[0] > ends[1]:
        raise ranges.refuse(name, "must be two numbers, the least and the greatest")
    return float(ends[0]), float(ends[1])


def _evaluated(
    formula: Expression, ranges: Mapping[str, tuple[float, float]], conditions: Conditions
) -> Quantity:
    """The formula element by element; NaN outside the ranges and where it has no value."""
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
    """The value of a parameter or symbol; NaN where the scene has no such parameter."""
    if name in SYMBOLS:
        found: Quantity = getattr(conditions, SYMBOLS[name])
        return found
    return conditions.parameters.get(name, math.nan)
