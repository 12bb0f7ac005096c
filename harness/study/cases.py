"""The cases of a study. The key of a case is a hash of all that its numbers depend on."""

import functools
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from harness.errors import tell
from harness.expressions import Expression, ExpressionError
from harness.study.designs import (
    LARGEST_STUDY,
    LATIN_HYPERCUBE,
    Design,
    combination_count,
    combinations,
    rounded,
)
from harness.study.laws import without_replaced
from harness.study.scene_part import Scene, ScenePart
from harness.study.tables import StudyError
from mpm_warp.errors import ParameterError
from mpm_warp.fields.declaration import Value, own_parameters_of
from mpm_warp.fields.flat import values_of
from mpm_warp.materials.clay_law import PARAMETER
from mpm_warp.scenes import CatalogueScene, scene_class

MANY_CASES = 10_000
"""With more cases than this a study takes seconds to read, and a line says so."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One run of a scene."""

    scene: str
    scene_version: int  # version of the scene that the parameters are for
    # all parameters of the scene with their defaults; None: the scene derives the value as it runs
    parameters: Mapping[str, Value | None]
    label: str  # the varied values in words, for messages and tables
    changed: tuple[str, ...] = ()  # parameters that the design sets in this case
    snapshots: tuple[float, ...] = ()  # moments at which the soil is kept; they change no result
    draws: int = 1  # samples of a Latin hypercube that give this same case; often > 1 at a bound

    @functools.cached_property
    def key(self) -> str:
        """16 hexadecimal digits, the same for equal parameters of the same scene and version."""
        identity = [self.scene, self.scene_version, self.parameters]
        canonical = json.dumps(identity, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(canonical.encode()).hexdigest()[:16]

    def built(self) -> CatalogueScene:
        """The scene with these parameters.

        Raises:
            ParameterError: the scene does not allow them; the message says why.
        """
        return scene_class(self.scene).of(self.parameters)


def most_cases(parts: Sequence[ScenePart], design: Design) -> int:
    """Number of cases before duplicates and excluded ones are removed; quick to compute."""
    return sum(combination_count(design, part.varied, part.listed) for part in parts)


def cases_of(parts: Sequence[ScenePart], design: Design, where: str) -> tuple[Case, ...]:
    """All cases of a study without duplicates, scene by scene in the order of the design.

    A combination that a scene does not allow is an error, except in a Latin hypercube. There chance
    has drawn it, and it stays as a case that will end as `refused`.

    Raises:
        StudyError: a scene does not allow a combination; in a Latin hypercube it allows none of
            them; there are too many cases, or none is left.
    """
    if (count := most_cases(parts, design)) > LARGEST_STUDY:
        raise StudyError(f"{where}: gives {count} cases; a study has at most {LARGEST_STUDY}")
    if count > MANY_CASES:
        tell(f"{where}: checking the parameters of {count} cases")
    cases: dict[str, Case] = {}
    refusals: dict[str, StudyError] = {}
    for part in parts:
        of_many = [part.name] if len(parts) > 1 else []
        for values in combinations(design, part.varied, part.listed, part.parameters):
            text = [f"{name}={value}" for name, value in values.items()]
            label = ", ".join([*of_many, *text]) or part.name
            try:
                fixed = without_replaced(part.fixed, values if PARAMETER in part.fixed else {})
                complete, refusal = complete_parameters(
                    part.scene, {**fixed, **values}, part.derived
                )
                if refusal is not None and design.kind != LATIN_HYPERCUBE:
                    raise StudyError(f"{where}: {label}: {refusal}")
                is_excluded = _is_excluded(part, complete)
            except ExpressionError as error:
                raise StudyError(f"{where}: {label}: {error}") from None
            if is_excluded:
                continue
            case = Case(
                scene=part.name,
                scene_version=part.scene.version,
                parameters=complete,
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
        raise StudyError(f"{where}: exclude: removes every case")
    if len(refusals) == len(cases):
        raise next(iter(refusals.values()))
    return tuple(cases.values())


def _is_excluded(part: ScenePart, complete: Mapping[str, Value | None]) -> bool:
    """Whether a condition of `exclude` holds for these parameters."""
    try:
        return any(condition.is_true(complete) for condition in part.excluded)
    except ExpressionError as error:
        raise ExpressionError(f"exclude: {error}") from None


def complete_parameters(
    scene: Scene, given: dict[str, Value], derived: Mapping[str, Expression] | None = None
) -> tuple[dict[str, Value | None], ParameterError | None]:
    """All parameters of a scene, and the error if the scene does not allow them.

    Args:
        scene: the scene.
        given: values by name; the scene's defaults fill in the others.
        derived: expressions for further parameters, evaluated in this order.

    Returns:
        The parameters, and None or why the scene refuses them. A refused scene has only plain
        defaults, because it cannot derive values. A parameter that is missing until its expression
        is evaluated is no reason to refuse.

    Raises:
        ExpressionError: an expression has no value; the message names its parameter.
    """
    defaults = {name: definition.default for name, definition in own_parameters_of(scene).items()}
    to_come = dict(derived or {})
    while True:
        try:
            complete, refusal = values_of(scene.of(given)), None
        except ParameterError as error:
            complete, refusal = {**defaults, **given}, error
        if not to_come or (refusal is not None and refusal.key not in to_come):
            return complete, refusal
        name = next(iter(to_come))
        try:
            value = to_come.pop(name).value(complete)
        except ExpressionError as error:
            raise ExpressionError(f"[derived] {name}: {error}") from None
        given = given | {name: rounded(value) if isinstance(value, float) else value}
