"""What a study is compared with: the tables ``[compare]`` and ``[references.NAME]``.

``[compare]`` names references, bands of experience, a reference study and tolerances.
``[references.NAME]`` defines a reference of the user's own: a formula or points of parameters of
the scene in SI units, and of `SYMBOLS`.
"""

import json
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import MISSING, dataclass, replace
from pathlib import Path
from typing import Any

from harness.expressions import Expression, ExpressionError, expression_schema
from harness.references.reference import (
    COMPARED,
    FACTOR,
    SYMBOLS,
    Reference,
)
from harness.references.registry import BANDS, REFERENCES, reference_of, without_mode
from harness.references.strength import Criterion, StrengthMode
from harness.study.files import find_study
from harness.study.laws import flat_material
from harness.study.scene_part import Scene, ScenePart
from harness.study.tables import LINE, StudyError, Table, is_number, text_key
from mpm_warp.fields.checks import POSITIVE, shown
from mpm_warp.fields.declaration import Form, Parameter
from mpm_warp.fields.names import did_you_mean, nearest_name

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


def _choice(name: str, meaning: str, kind: type[Criterion | StrengthMode]) -> Parameter:
    words = tuple(it.value for it in kind)
    return Parameter(name=name, kind=str, default=words[0], meaning=meaning, choices=words)


FORMULA = replace(
    text_key("formula", f"formula of parameters, or of {', '.join(SYMBOLS)}"),
    default=None,
    form=Form("an expression", LINE.read, lambda declared: [expression_schema()]),
)
OWN_KEYS = (
    FORMULA,
    text_key(OWN_LABEL, "name in pictures, such as authors and year"),
    text_key("source", "where it is published"),
    text_key("how_known", "how the formula is known", "as the study's own file says"),
    text_key("method", "method by which it was found", "not stated here"),
    _choice("criterion", "yield criterion", Criterion),
    _choice("su_mode", "test that su is the strength in", StrengthMode),
)
OWN_TABLES = ("range", "points")
"""Keys of a reference of the user's own."""
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

    references: tuple[Reference, ...]  # from the literature or defined in the study
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
    named = _ids(table, "references", "reference", (*REFERENCES, *own), parts)
    references = dict.fromkeys([*named, *own])
    return Compared(
        references=tuple(own.get(reference) or reference_of(reference) for reference in references),
        reference_result=_reference_result(table, parts, folder),
        experience=_ids(table, "experience", "band of experience", tuple(BANDS), parts),
        tolerances=_tolerances(table.table("tolerance"), list(references), parts),
    )


def takes_references(scene: Scene) -> bool:
    """Whether a scene computes a cone factor, which references and experience are about."""
    return scene.comparable == COMPARED


def _own_references(table: Table, parts: Sequence[ScenePart]) -> dict[str, Reference]:
    """The references that the study defines; a formula may use parameters of any compared scene."""
    compared = [part for part in parts if takes_references(part.scene)]
    if table.values and not compared:
        raise StudyError(f"{table.where}: {NO_CONE_FACTOR}")
    known = dict.fromkeys(name for part in compared for name in part.parameters)
    for name, own in table.values.items():
        if not isinstance(own, dict):
            raise table.refuse(name, f"belongs to a reference, a table [{OWN_REFERENCES}.its_name]")
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
    unused = REFERENCES.keys() - {*references}
    verified = {
        name for part in parts for check in part.scene.verifications for name in check.bounds
    }
    known = {*references, COMPARED, ERROR, ERROR_FINEST, *verified}
    for name in table.values:
        if name in BANDS:
            raise table.refuse(name, "is a band of experience; a tolerance needs a reference")
        if name in unused:
            raise table.refuse(name, "is not among the references of [compare]")
        if name not in known and (near := did_you_mean(name, known, MISSPELLING_LIKENESS)):
            raise table.refuse(name, f"is neither a reference nor a result{near}")
    return {name: table.read(replace(TOLERANCE, name=name)) for name in table.values}


def stored_own_reference(name: str, attributes: Mapping[str, Any]) -> Reference:
    """A reference of the user's own, read from the attributes that the file of a result keeps."""
    said = {it.name: attributes[it.name] for it in OWN_KEYS if it.name in attributes}
    for key in attributes.keys() & {*OWN_TABLES}:
        try:
            said[key] = json.loads(attributes[key])
        except (TypeError, ValueError):
            said[key] = None
    return read_own_reference(name, Table(f"reference {name}:", said), None)


def own_attributes(reference: Reference) -> dict[str, str]:
    """What a result keeps of a reference of the user's own, as `stored_own_reference` reads it."""
    tables = {"range": reference.range, "points": reference.points}
    kept = {key: json.dumps(dict(table)) for key, table in tables.items() if table}
    return {OWN_LABEL: reference.label} | kept


def read_own_reference(name: str, table: Table, known: Collection[str] | None) -> Reference:
    """A reference from its table [references.NAME].

    Args:
        name: NAME.
        table: the table.
        known: parameters that it may use beside `SYMBOLS`; None allows any name.
    """
    table.allow(*(it.name for it in OWN_KEYS), *OWN_TABLES)
    tables = {
        key: flat_material(f"{table.where} [{key}]", own)
        for key in OWN_TABLES
        if isinstance(own := table.values.get(key), dict)
    }
    table = replace(table, values={**table.values, **tables})
    if not re.fullmatch(REFERENCE_NAME, name):
        raise StudyError(
            f"{table.where}: a name has lower-case letters, digits and '_', with a letter first"
        )
    if without_mode(name) in REFERENCES or name in BANDS:
        raise StudyError(f"{table.where}: a reference that ships has this name; choose another")
    said = {it.name: table.read(it) for it in OWN_KEYS}
    names = {"range": list(_checked_ranges(table.table("range")))}
    if "points" in table.values:
        names["points"] = _checked_points(table)
    else:
        names["formula"] = _checked_formula(table, said["formula"])
    every = None if known is None else (*known, *SYMBOLS)
    for key, used in names.items():
        for symbol in used:
            if every is not None and symbol not in every:
                problem = f"unknown parameter or symbol {symbol!r}{nearest_name(symbol, every)}"
                raise table.refuse(key, problem)
    return Reference.of(name, said | {key: table.values.get(key, {}) for key in OWN_TABLES})


def _checked_formula(table: Table, text: str | None) -> list[str]:
    """The names that the formula uses."""
    if text is None:
        raise table.missing(FORMULA)
    try:
        formula = Expression.parsed(text)
    except ExpressionError as error:
        raise table.refuse("formula", str(error)) from None
    if formula.is_condition:
        raise table.refuse("formula", "is a condition; it must give a number")
    if not formula.names:
        _check_constant(table, formula)
    return sorted(formula.names)


def _check_constant(table: Table, formula: Expression) -> None:
    """Refuse a formula of numbers alone that is no cone factor."""
    try:
        value = formula.value({})
    except ExpressionError as error:
        raise table.refuse("formula", str(error)) from None
    if not (is_number(value) and value > 0.0):
        raise table.refuse("formula", f"is {value!r}; a cone factor is a number > 0")


def _checked_points(table: Table) -> list[str]:
    """The names of the columns of points."""
    if "formula" in table.values:
        raise table.refuse("points", "formula says the value too; give one of them")
    points = table.table("points")
    for name in points.values:
        if not points.list(name) or not all(map(is_number, points.list(name))):
            raise points.refuse(name, "must be a list of numbers")
    lengths = {len(column) for column in points.values.values()}
    if FACTOR not in points.values or len(points.values) < 2 or len(lengths) > 1:
        raise table.refuse("points", f"must be columns of one length: symbols, and {FACTOR}")
    if min(points.values[FACTOR]) <= 0.0:
        raise points.refuse(FACTOR, "a cone factor must be > 0")
    names = [name for name in points.values if name != FACTOR]
    places = list(zip(*(points.values[name] for name in names), strict=True))
    place, count = Counter(tuple(f"{it:.9g}" for it in place) for place in places).most_common(1)[0]
    if count > 1:
        at = ", ".join(map(" = ".join, zip(names, place, strict=True)))
        raise table.refuse("points", f"has {count} values at {at}; a place has one")
    return names


def _checked_ranges(ranges: Table) -> Mapping[str, Any]:
    """The ranges, each the least and the greatest value, or one value."""
    for name, given in ranges.values.items():
        ends = given if isinstance(given, list) and len(given) == 2 else [given, given]
        if not all(map(is_number, ends)) or ends[0] > ends[1]:
            raise ranges.refuse(name, "must be two numbers, the least and the greatest, or one")
    return ranges.values
