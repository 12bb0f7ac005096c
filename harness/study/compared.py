"""What a study is compared with: ``[compare]``, its references, its experience, its tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from harness.references.cone_factors import COMPARED, reference_ids
from harness.references.experience import experience_ids
from harness.study.scene_part import Scene, ScenePart
from harness.study.tables import Table, shown
from mpm_warp.parameters import did_you_mean, nearest_name

ERROR = "error"
"""Result with the error against the exact solution, of scenes that have one."""
ERROR_FINEST = "error_finest"
"""Result with the error against the finest case of the study, of scenes without an exact one."""
MISSPELT = 0.85
"""Likeness from which on a name is a slip; two results of a scene are less alike."""


@dataclass(frozen=True, kw_only=True)
class Compared:
    """What a result is compared with; every name is known. See `Study`."""

    references: tuple[str, ...]
    experience: tuple[str, ...]
    tolerances: Mapping[str, float]


def read_compared(table: Table, parts: Sequence[ScenePart]) -> Compared:
    """What a study with these scenes is compared with.

    Raises:
        StudyError: a name is unknown, or of what no scene here can be compared with.
    """
    table.allow("references", "experience", "tolerance")
    references = _ids(table, "references", "reference", reference_ids(), parts)
    return Compared(
        references=references,
        experience=_ids(table, "experience", "band of experience", experience_ids(), parts),
        tolerances=_tolerances(table.table("tolerance"), references, parts),
    )


def takes_references(scene: Scene) -> bool:
    """Whether a scene gives what the references and the experience are of."""
    return scene.comparable == COMPARED


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
    if ids and not any(takes_references(it.scene) for it in parts):
        raise table.refuse(key, f"no scene here gives a {COMPARED}, which they are of")
    return tuple(ids)


def _tolerances(
    table: Table, references: Sequence[str], parts: Sequence[ScenePart]
) -> dict[str, float]:
    """Tolerances by name, which may be that of any result: slips in known names are refused."""
    unused = set(reference_ids()) - set(references)
    verified = {name for it in parts for check in it.scene.verifications for name in check.bounds}
    known = {*references, COMPARED, ERROR, ERROR_FINEST, *verified}
    for name in table.values:
        if name in experience_ids():
            raise table.refuse(name, "is a band of experience, from which no result deviates")
        if name in unused:
            raise table.refuse(name, "is not among the references of [compare]")
        if name not in known and (near := did_you_mean(name, known, MISSPELT)):
            raise table.refuse(name, f"is neither a reference nor a result{near}")
    return {name: table.positive(name) for name in table.values}
