"""What a study does with one scene: its parameters and their values, read from the definition."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from harness.errors import tell
from harness.study.designs import (
    EITHER_FIXED_OR_VARIED,
    FULL,
    LATIN_HYPERCUBE,
    LIST,
    SPACINGS,
    Combination,
    Design,
    Range,
    Variation,
    Variations,
)
from harness.study.distributions import is_distribution, read_input
from harness.study.expressions import Expression, ExpressionError
from harness.study.tables import StudyError, Table, shown
from mpm_warp.errors import UnknownSceneError
from mpm_warp.parameters import Parameter, Value, nearest_parameter, parameters_of
from mpm_warp.scenes import CatalogueScene, scene_class, scene_names

LARGEST_STUDY = 100_000
"""Cases that a study may have; more than that is a slip in a list."""
MOST_EXCLUSIONS = 100
"""Conditions of a study, each of which is worked out for every case."""

SNAPSHOTS = "snapshots"
"""Key of the moments at which the soil is kept."""
OF_SCENE = ("fixed", "vary", "derived", "exclude", "case", SNAPSHOTS)
"""Keys that may stand under [scenes.NAME] as well, for that scene alone."""

Scene = type[CatalogueScene]


def loaded_scenes() -> dict[str, Scene]:
    """All scenes, by name; of one that cannot be loaded a line tells why it is left out."""
    loaded: dict[str, Scene] = {}
    for name in scene_names():
        try:
            loaded[name] = scene_class(name)
        except UnknownSceneError as error:
            tell(f"left out: {error}")
    return loaded


def method_of(scene: Scene) -> tuple[str, ...]:
    """The parameters of a scene's method; what refines an exact solution is one of them."""
    refining = (check.resolution for check in scene.verifications)
    return tuple(dict.fromkeys([*scene.method, *refining]))


@dataclass(frozen=True, kw_only=True)
class ScenePart:
    """What a study does with one scene; every name and value is valid."""

    name: str
    scene: Scene
    parameters: Mapping[str, Parameter]
    fixed: Mapping[str, Value]  # the same in every case, or where nothing varies them
    varied: Variations  # ranges and distributions in a Latin hypercube alone
    listed: tuple[Combination, ...]  # the cases of the design ``list``
    derived: Mapping[str, Expression]  # worked out from the others, in this order
    excluded: tuple[Expression, ...]  # conditions on cases that are not run
    snapshots: tuple[float, ...]  # moments at which the soil of each case is kept

    @property
    def assigned(self) -> set[str]:
        """The parameters that the study gives values to; all others are left to the scene."""
        return {
            *self.fixed,
            *self.varied,
            *self.derived,
            *(name for case in self.listed for name in case),
        }


def read_part(
    name: str, scene: Scene, table: Table, design: Design, settings: Mapping[str, Any]
) -> ScenePart:
    """Read what a study does with a scene, whose parameters the table knows, and apply settings.

    Settings hold whatever the definition says; those of parameters that the scene does not have are
    left out. In the design `one_at_a_time` a parameter that a setting varies keeps its fixed value
    in the first case.
    """
    known = table.known
    given = Table("--set", {key: settings[key] for key in settings if key in known}, known)
    fixed = _fixed(table.table("fixed"))
    varied = _varied(table.table("vary"), design, fixed)
    derived = _derived(table.table("derived"))
    listed = _listed(table, design)
    for key, value in given.values.items():
        derived.pop(key, None)
        if not isinstance(value, (list, dict)):
            fixed[key] = given.value(key)
            varied.pop(key, None)
            continue
        if design.kind == LIST:
            allowed = known[key].allowed
            raise given.refuse(key, f'design = "{LIST}" does not vary it; must be {allowed}')
        varied[key] = _variation(given, key, design)
        if design.kind in EITHER_FIXED_OR_VARIED:
            fixed.pop(key, None)
    if design.kind == LATIN_HYPERCUBE and not varied:
        raise StudyError(f"{table.where} [vary]: nothing varies, there is nothing to sample")
    return ScenePart(
        name=name,
        scene=scene,
        parameters=known,
        fixed=fixed,
        varied=varied,
        listed=tuple(
            {key: value for key, value in case.items() if key not in given.values}
            for case in listed
        ),
        derived=derived,
        excluded=_excluded(table),
        snapshots=read_snapshots(name, scene, table) if SNAPSHOTS in table.values else (),
    )


def read_snapshots(name: str, scene: Scene, table: Table) -> tuple[float, ...]:
    """Read at which moments the soil is to be kept: a list of numbers, or a range with a count."""
    if scene.snapshots_over is None:
        raise table.refuse(SNAPSHOTS, f"{name} takes no snapshots")
    given = replace(table, known={SNAPSHOTS: moment_of(scene, scene.snapshots_over)})
    moments = _variation(given, SNAPSHOTS, Design(kind=FULL))
    assert isinstance(moments, tuple)  # a range without a count is a Latin hypercube's alone
    return tuple(sorted(float(moment) for moment in moments))


def moment_of(scene: Scene, over: str) -> Parameter:
    """What a moment at which the soil is kept may be: as the parameter that it is measured over."""
    farthest = parameters_of(scene)[over]
    meaning = f"moment at which the soil is kept, measured as the {over} is"
    bounds = replace(farthest.bounds, minimum=-math.inf, above=0.0)
    return replace(farthest, name=SNAPSHOTS, bounds=bounds, meaning=meaning)


def _fixed(table: Table) -> dict[str, Value]:
    for key, value in table.values.items():
        table.definition(key)
        if isinstance(value, list):
            raise table.refuse(key, "is a list; what varies belongs under [vary]")
    return table.all_values()


def _varied(table: Table, design: Design, fixed: Mapping[str, Value]) -> dict[str, Variation]:
    varied = {key: _variation(table, key, design) for key in table.values}
    for key in varied:
        if design.kind == LIST:
            raise table.refuse(key, f'does not go with design = "{LIST}"')
        if design.kind in EITHER_FIXED_OR_VARIED and key in fixed:
            raise table.refuse(key, "is under [fixed] as well; keep one of them")
    return varied


def _variation(table: Table, key: str, design: Design) -> Variation:
    """A list, a range such as ``{from = 1, to = 100, count = 5}``, or a distribution."""
    value = table.values[key]
    if not isinstance(value, dict):
        return table.several(key)
    definition = table.definition(key)
    if is_distribution(value):
        if definition.kind is not float:
            raise table.refuse(key, f"has no distributions; must be {definition.allowed}")
        if design.kind != LATIN_HYPERCUBE:
            raise table.refuse(key, f'a distribution goes with design = "{LATIN_HYPERCUBE}" alone')
        return read_input(table, key, definition.bounds)
    if definition.kind not in (int, float) or definition.choices is not None:
        raise table.refuse(
            key, f"has no ranges; must be a list of values, each {definition.allowed}"
        )
    sampled = design.kind == LATIN_HYPERCUBE
    of_end = {end: replace(definition, name=end) for end in ("from", "to")}
    ends = Table(f"{table.where} {key}:", value, of_end)
    ends.allow(*of_end, "spacing", *([] if sampled else ["count"]))
    for end in of_end:
        ends.given(end, "; a range has from and to")
    start, stop = (float(ends.value(end)) for end in of_end)
    logarithmic = ends.word("spacing", SPACINGS) == "logarithmic"
    if logarithmic and min(start, stop) <= 0:
        raise ends.refuse("spacing", "from and to must be > 0")
    span = Range(start=start, stop=stop, logarithmic=logarithmic)
    if sampled:
        if start >= stop:
            raise ends.refuse("to", f"must be > {start:g}")
        return span
    numbers = span.values(ends.integer("count", 2, LARGEST_STUDY))
    return replace(table, values={key: list(numbers)}).several(key)


def _derived(table: Table) -> dict[str, Expression]:
    derived: dict[str, Expression] = {}
    for key, value in table.values.items():
        table.definition(key)
        later = [name for name in table.values if name not in derived]
        derived[key] = _expression(table, table.place(key), value, later)
    return derived


def _excluded(table: Table) -> tuple[Expression, ...]:
    texts = table.list("exclude")
    if len(texts) > MOST_EXCLUSIONS:
        raise StudyError(
            f"{table.where} exclude: has {len(texts)} conditions; a study has at most "
            f"{MOST_EXCLUSIONS}; join them by `or`"
        )
    return tuple(
        _expression(table, f"{table.where} exclude = {shown(text)}", text, []) for text in texts
    )


def _expression(table: Table, where: str, text: object, later: list[str]) -> Expression:
    try:
        expression = Expression.parsed(text)
    except ExpressionError as error:
        raise StudyError(f"{where}: {error}") from None
    for name in sorted(expression.names):
        if name not in table.known:
            near = nearest_parameter(name, table.known)
            raise StudyError(f"{where}: unknown parameter {name!r}{near}")
        if name in later:
            raise StudyError(f"{where}: {name} is derived itself, and not before")
    return expression


def _listed(table: Table, design: Design) -> tuple[Combination, ...]:
    if design.kind != LIST:
        if "case" in table.values:
            raise table.refuse("case", f'goes with design = "{LIST}" alone')
        return ()
    cases = table.list("case")
    if not cases:
        raise StudyError(f"{table.where} case: is missing; each case is a table [[case]]")
    listed = []
    for number, case in enumerate(cases, 1):
        if not isinstance(case, dict):
            raise StudyError(f"{table.where} case {number} = {shown(case)}: must be a table")
        here = Table(f"{table.where} [[case]] {number}:", case, table.known)
        listed.append(here.all_values())
    return tuple(listed)
