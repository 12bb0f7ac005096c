"""What a study is compared with: ``[compare]``.

That is references, the result of another study, experience, and tolerances.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.references.cone_factors import COMPARED, ConeFactor
from harness.references.registry import cone_factor_reference, experience_ids, reference_ids
from harness.study.files import find_study
from harness.study.own_references import OWN_REFERENCES, OwnReference, read_own_reference
from harness.study.scene_part import Scene, ScenePart
from harness.study.tables import StudyError, Table, shown
from mpm_warp.parameters import did_you_mean, nearest_name

ERROR = "error"
"""Result with the error against the exact solution, of scenes that have one."""
ERROR_FINEST = "error_finest"
"""Result with the error against the case known best, of scenes without an exact solution."""
REFERENCE_STUDY = "reference_study"
MISSPELT = 0.85
"""Likeness from which on a name is a slip; two results of a scene are less alike."""


@dataclass(frozen=True, kw_only=True)
class Compared:
    """What a result is compared with; every name is known.

    Attributes:
        references: of the literature or the study's own.
        reference_result: result whose cases stand for the true values of errors; or none.
        experience: bands of factors measured in the field, to set beside the result.
        tolerances: largest deviation from a reference, or largest size of a result, by name.
    """

    references: tuple[ConeFactor, ...]
    reference_result: Path | None
    experience: tuple[str, ...]
    tolerances: Mapping[str, float]


def read_compared(document: Table, parts: Sequence[ScenePart], folder: Path) -> Compared:
    """What a study with these scenes, whose file is in a folder, is compared with.

    The references that it defines itself are among them, whether it names them again or not.
    """
    table = document.table("compare")
    table.allow("references", REFERENCE_STUDY, "experience", "tolerance")
    own = _own_references(document.table(OWN_REFERENCES), parts)
    known = (*reference_ids(), *own)
    named = _ids(table, "references", "reference", known, parts)
    references = dict.fromkeys([*named, *own])
    return Compared(
        references=tuple(own.get(it) or cone_factor_reference(it) for it in references),
        reference_result=_reference_result(table, parts, folder),
        experience=_ids(table, "experience", "band of experience", experience_ids(), parts),
        tolerances=_tolerances(table.table("tolerance"), list(references), parts),
    )


def takes_references(scene: Scene) -> bool:
    """Whether a scene gives what the references and the experience are of."""
    return scene.comparable == COMPARED


def _own_references(table: Table, parts: Sequence[ScenePart]) -> dict[str, OwnReference]:
    """The references that the study defines: formulas of parameters of the scenes compared."""
    compared = [part for part in parts if takes_references(part.scene)]
    if table.values and not compared:
        raise StudyError(f"{table.where}: no scene here gives a {COMPARED}, which they are of")
    known = {name for part in compared for name in part.parameters}
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
    unused = set(reference_ids()) - set(references)
    verified = {
        name for part in parts for check in part.scene.verifications for name in check.bounds
    }
    known = {*references, COMPARED, ERROR, ERROR_FINEST, *verified}
    for name in table.values:
        if name in experience_ids():
            raise table.refuse(name, "is a band of experience, from which no result deviates")
        if name in unused:
            raise table.refuse(name, "is not among the references of [compare]")
        if name not in known and (near := did_you_mean(name, known, MISSPELT)):
            raise table.refuse(name, f"is neither a reference nor a result{near}")
    return {name: table.positive(name) for name in table.values}
