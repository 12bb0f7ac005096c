"""From a study to its cases. A case is named by the hash of all that decides its numbers."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass

from harness.study.definition import StudyError
from harness.study.designs import (
    LATIN_HYPERCUBE,
    Combination,
    combination_count,
    combinations,
    rounded,
)
from harness.study.expressions import ExpressionError
from harness.study.scene_part import LARGEST_STUDY, ScenePart
from harness.study.study import Study
from mpm_warp.parameters import ParameterError, Value, from_mapping, parameters_of
from mpm_warp.scenes import ReadyScene, scene_class

COMPLETED = "completed"
MISSING = "missing"
CRASHED = "crashed"
TIMED_OUT = "timed_out"
DAMAGED = "damaged"
UNTIMED = "untimed"


@dataclass(frozen=True, kw_only=True)
class Case:
    """One run of a scene.

    Attributes:
        scene: name of the scene.
        scene_version: version of the scene that the parameters are meant for.
        parameters: all parameters of the scene; None is what the scene derives.
        label: the varied values, for people.
    """

    scene: str
    scene_version: int
    parameters: Mapping[str, Value | None]
    label: str

    @property
    def key(self) -> str:
        """16 hexadecimal digits: the same parameters of the same scene version, the same key."""
        identity = [self.scene, self.scene_version, self.parameters]
        canonical = json.dumps(identity, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Outcome:
    """How a case ended.

    Attributes:
        status: ``completed``; ``refused``, by its scene before it began; ``diverged``,
            ``inaccurate``, ``failed``, ``crashed``, ``timed_out``; ``missing`` where there is no
            file, ``damaged`` where the file is of no use, ``untimed`` where it completed without
            the timed runs that its study asks for.
        message: why it did not complete, one line.
        headline: name and value of the first scalar that the scene returned.
        seconds: time that the case took in all.
        repeats: warm runs that its file has the times of.
    """

    status: str
    message: str = ""
    headline: str = ""
    seconds: float = 0.0
    repeats: int = 0


def cases_of(study: Study) -> list[Case]:
    """All cases of a study, each once, scene by scene in the order of its design.

    A combination that the scene does not allow is a case all the same where nobody has chosen it,
    but chance: one that its scene will refuse.

    Raises:
        StudyError: the scene does not allow a combination, or none that chance has chosen; or there
            are too many, or none.
    """
    counts = [combination_count(study.design, it.varied, it.listed) for it in study.parts]
    if sum(counts) > LARGEST_STUDY:
        raise StudyError(
            f"{study.source}: gives {sum(counts)} cases; a study has at most {LARGEST_STUDY}"
        )
    cases: dict[str, Case] = {}
    refusals: dict[str, StudyError] = {}
    for part in study.parts:
        definitions = parameters_of(scene_class(part.scene))
        for values in combinations(study.design, part.varied, part.listed, definitions):
            case, refusal = _case(study, part, values)
            if case is not None:
                cases.setdefault(case.key, case)
                if refusal is not None:
                    refusals[case.key] = refusal
    if not cases:
        raise StudyError(f"{study.source}: exclude: leaves no case")
    if len(refusals) == len(cases):
        raise next(iter(refusals.values()))
    return list(cases.values())


def _case(
    study: Study, part: ScenePart, values: Combination
) -> tuple[Case | None, StudyError | None]:
    """The case of one combination, None where the study excludes it; why its scene refuses it."""
    scene = scene_class(part.scene)
    text = ", ".join(f"{name}={value}" for name, value in values.items())
    of_many = [part.scene] if len(study.parts) > 1 else []
    label = ", ".join([*of_many, *([text] if text else [])]) or part.scene
    given: dict[str, Value] = {**part.fixed, **values}
    refusal = None
    try:
        try:
            complete = _complete(scene, part, given)
        except ParameterError as error:
            refusal = StudyError(f"{study.source}: {label}: {error}")
            if study.design.kind != LATIN_HYPERCUBE:
                raise refusal from None
            defaults = {name: it.default for name, it in parameters_of(scene).items()}
            complete = {**defaults, **given}
        excluded = any(condition.is_true(complete) for condition in part.excluded)
    except ExpressionError as error:
        raise StudyError(f"{study.source}: {label}: {error}") from None
    if excluded:
        return None, None
    case = Case(scene=part.scene, scene_version=scene.version, parameters=complete, label=label)
    return case, refusal


def _complete(
    scene: type[ReadyScene], part: ScenePart, given: dict[str, Value]
) -> dict[str, Value | None]:
    """All parameters of a scene, those that the study derives too, which are added to `given`."""
    for name, expression in part.derived.items():
        value = expression.value(dataclasses.asdict(scene(**given)))
        given[name] = rounded(value) if isinstance(value, float) else value
    return dataclasses.asdict(from_mapping(scene, given))
