"""From a study to its cases. The key of a case is a hash of everything its numbers depend on."""

import dataclasses
import functools
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from harness.errors import tell
from harness.study.designs import (
    LATIN_HYPERCUBE,
    Design,
    combination_count,
    combinations,
    rounded,
)
from harness.study.expressions import Expression, ExpressionError
from harness.study.scene_part import LARGEST_STUDY, Scene, ScenePart
from harness.study.tables import StudyError
from mpm_warp.errors import ParameterError
from mpm_warp.parameters import Value, parameters_of
from mpm_warp.scenes import CatalogueScene, scene_class

MANY = 10_000
"""Cases beyond which a study takes seconds to read, and says so."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One run of a scene."""

    scene: str
    scene_version: int  # that the parameters are meant for
    # all of the scene, derived defaults filled in; None is one that it derives only when it runs
    parameters: Mapping[str, Value | None]
    label: str  # the varied values, for people
    changed: tuple[str, ...] = ()  # of which the design gives values; the others are the fixed ones
    snapshots: tuple[float, ...] = ()  # moments at which the soil is kept; they change no result
    draws: int = 1  # samples of a Latin hypercube that are this case, as many at a bound are

    @functools.cached_property
    def key(self) -> str:
        """16 hexadecimal digits: the same parameters of the same scene version, the same key."""
        identity = [self.scene, self.scene_version, self.parameters]
        canonical = json.dumps(identity, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:16]

    def built(self) -> CatalogueScene:
        """Its scene with its parameters; a `ParameterError` says why the scene refuses them."""
        return scene_class(self.scene)(**self.parameters)


def most_cases(parts: Sequence[ScenePart], design: Design) -> int:
    """Number of cases of a study, those that it excludes among them; known at once."""
    return sum(combination_count(design, part.varied, part.listed) for part in parts)


def cases_of(parts: Sequence[ScenePart], design: Design, where: str) -> tuple[Case, ...]:
    """All cases of a study, each once, scene by scene in the order of the design.

    A combination that a scene does not allow is an error in every design but the Latin hypercube,
    where chance has chosen it: there it is a case that its scene will refuse.

    Raises:
        StudyError: a scene does not allow a combination, or none of a Latin hypercube; or there are
            too many cases, or none.
    """
    if (count := most_cases(parts, design)) > LARGEST_STUDY:
        raise StudyError(f"{where}: gives {count} cases; a study has at most {LARGEST_STUDY}")
    if count > MANY:
        tell(f"{where}: checks the parameters of {count} cases")
    cases: dict[str, Case] = {}
    refusals: dict[str, StudyError] = {}
    for part in parts:
        of_many = [part.name] if len(parts) > 1 else []
        for values in combinations(design, part.varied, part.listed, part.parameters):
            text = [f"{name}={value}" for name, value in values.items()]
            label = ", ".join([*of_many, *text]) or part.name
            try:
                complete, refusal = completed(part.scene, {**part.fixed, **values}, part.derived)
                if refusal is not None and design.kind != LATIN_HYPERCUBE:
                    raise StudyError(f"{where}: {label}: {refusal}")
                is_excluded = any(condition.is_true(complete) for condition in part.excluded)
            except ExpressionError as error:
                raise StudyError(f"{where}: {label}: {error}") from None
            if is_excluded:
                continue
            case = Case(
                scene=part.name,
                scene_version=part.scene.version,
                parameters=naming(part.scene, complete),
                label=label,
                changed=tuple(values),
                snapshots=part.snapshots,
            )
            if (same := cases.get(case.key)) is None:
                cases[case.key] = case
            elif design.kind == LATIN_HYPERCUBE:
                cases[case.key] = replace(same, draws=same.draws + 1)
            if refusal is not None:
                refusals[case.key] = StudyError(f"{where}: {label}: {refusal}")
    if not cases:
        raise StudyError(f"{where}: exclude: leaves no case")
    if len(refusals) == len(cases):
        raise next(iter(refusals.values()))
    return tuple(cases.values())


def naming(scene: Scene, complete: Mapping[str, Value | None]) -> dict[str, Value | None]:
    """The parameters that name a case, of all of its scene: without those of laws that it has not.

    So a case keeps its name whatever packages with laws are installed.
    """
    absent = {name for name in scene.of_other_laws if complete[name] is None}
    return {name: value for name, value in complete.items() if name not in absent}


def completed(
    scene: Scene, given: dict[str, Value], derived: Mapping[str, Expression] | None = None
) -> tuple[dict[str, Value | None], ParameterError | None]:
    """All parameters of a scene with these values, and why the scene refuses them, if it does.

    Where it does, nothing is worked out from others. That it lacks a parameter which an expression
    still gives is no refusal.
    """
    defaults = {name: definition.default for name, definition in parameters_of(scene).items()}
    to_come = dict(derived or {})
    while True:
        try:
            complete, refusal = _parameters(scene(**given)), None
        except ParameterError as error:
            complete, refusal = {**defaults, **given}, error
        if not to_come or (refusal is not None and refusal.key not in to_come):
            return complete, refusal
        name = next(iter(to_come))
        value = to_come.pop(name).value(complete)
        given = given | {name: rounded(value) if isinstance(value, float) else value}


def _parameters(scene: CatalogueScene) -> dict[str, Value | None]:
    """The parameters of a scene; `dataclasses.asdict` would copy each of them first."""
    return {field.name: getattr(scene, field.name) for field in dataclasses.fields(scene)}
