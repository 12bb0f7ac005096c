"""What a study does with one scene: the values of its parameters, read from the study file."""

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, replace

from harness.errors import tell
from harness.expressions import Expression, ExpressionError
from harness.study.designs import (
    FULL,
    LARGEST_STUDY,
    LATIN_HYPERCUBE,
    LIST,
    SPACINGS,
    VARY_REPLACES_FIXED,
    Combination,
    Design,
    Range,
    Variation,
    Variations,
)
from harness.study.distributions import INPUT, Input, is_distribution
from harness.study.laws import without_replaced
from harness.study.tables import StudyError, Table
from mpm_warp.errors import UnknownSceneError
from mpm_warp.fields.checks import Range as Within
from mpm_warp.fields.checks import shown
from mpm_warp.fields.declaration import Parameter, Value
from mpm_warp.fields.flat import parameters_of
from mpm_warp.fields.names import nearest_parameter
from mpm_warp.materials.clay_law import PARAMETER
from mpm_warp.scenes import CatalogueScene, scene_class, scene_names

MOST_EXCLUSIONS = 100
"""Conditions that `exclude` may have; each is evaluated for every case."""

COUNT = Parameter(
    name="count",
    kind=int,
    default=MISSING,
    meaning="numbers from one end of a range to the other",
    bounds=Within(minimum=2, maximum=LARGEST_STUDY),
)
SPACING = Parameter(
    name="spacing",
    kind=str,
    default=SPACINGS[0],
    meaning="how the numbers of a range are spaced",
    choices=SPACINGS,
)

SNAPSHOTS = "snapshots"
"""Key of the moments at which the soil is kept."""
SCENE_KEYS = ("fixed", "vary", "derived", "exclude", "case", SNAPSHOTS)
"""Keys that may also stand under [scenes.NAME], where they apply to that scene only."""

Scene = type[CatalogueScene]


def loaded_scenes() -> dict[str, Scene]:
    """All scenes by name. A scene that cannot be loaded is left out, and a line says why."""
    loaded: dict[str, Scene] = {}
    for name in scene_names():
        try:
            loaded[name] = scene_class(name)
        except UnknownSceneError as error:
            tell(f"left out: {error}")
    return loaded


def method_of(scene: Scene) -> tuple[str, ...]:
    """The parameters of a scene's numerical method, among them those that its checks refine."""
    refining = (check.resolution for check in scene.verifications)
    return tuple(dict.fromkeys([*scene.method, *refining]))


@dataclass(frozen=True, kw_only=True)
class ScenePart:
    """What a study does with one scene. Every name and value has been checked."""

    name: str
    scene: Scene
    parameters: Mapping[str, Parameter]
    fixed: Mapping[str, Value]  # values of all cases in which the design gives no other
    varied: Variations  # ranges and distributions only in a Latin hypercube
    listed: tuple[Combination, ...]  # the cases of the design ``list``
    derived: Mapping[str, Expression]  # computed from the other parameters, in this order
    excluded: tuple[Expression, ...]  # cases for which one of these is true are not run
    snapshots: tuple[float, ...]  # moments at which the soil of each case is kept

    @property
    def assigned(self) -> set[str]:
        """The parameters that the study gives values; the others have the scene's defaults."""
        return {
            *self.fixed,
            *self.varied,
            *self.derived,
            *(name for case in self.listed for name in case),
        }


def read_part(name: str, scene: Scene, table: Table, design: Design, given: Table) -> ScenePart:
    """Read what a study does with one scene, and apply settings.

    Args:
        name: name of the scene.
        scene: the scene.
        table: the keys that apply to the scene; its `known` are the scene's parameters.
        design: how values are combined.
        given: values from the command line. They override the file. With the design
            `one_at_a_time` a parameter that a setting varies keeps its fixed value in the other
            cases.
    """
    known = table.known
    for one in (table.table("fixed"), table.table("vary"), given):
        one.check_variants()
    fixed = _fixed(table.table("fixed"))
    in_file = _varied(table.table("vary"), design, fixed)
    varied = without_replaced(in_file, given.values)
    for key in in_file.keys() - varied.keys():
        tell(f"{table.where} [vary] {key}: left out: {given.place(PARAMETER)} replaces it")
    fixed = without_replaced(fixed, given.values)
    derived = without_replaced(_derived(table.table("derived")), given.values)
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
        if design.kind in VARY_REPLACES_FIXED:
            fixed.pop(key, None)
    if design.kind == LATIN_HYPERCUBE and not varied:
        raise StudyError(f"{table.where} [vary]: is empty; there is nothing to sample")
    return ScenePart(
        name=name,
        scene=scene,
        parameters=known,
        fixed=fixed,
        varied=varied,
        listed=tuple(
            {
                key: value
                for key, value in without_replaced(case, given.values).items()
                if key not in given.values
            }
            for case in listed
        ),
        derived=derived,
        excluded=_excluded(table),
        snapshots=read_snapshots(name, scene, table) if SNAPSHOTS in table.values else (),
    )


def read_snapshots(name: str, scene: Scene, table: Table) -> tuple[float, ...]:
    """Read the moments at which the soil is kept: a list of numbers, or a range with a count."""
    if scene.snapshots_over is None:
        raise table.refuse(SNAPSHOTS, f"{name} takes no snapshots")
    given = replace(table, known={SNAPSHOTS: moment_of(scene, scene.snapshots_over)})
    moments = _variation(given, SNAPSHOTS, Design(kind=FULL))
    assert isinstance(moments, tuple)  # only a Latin hypercube allows a range without a count
    return tuple(sorted(float(moment) for moment in moments))


def moment_of(scene: Scene, over: str) -> Parameter:
    """The definition of snapshot moments: like the parameter `over`, such as the penetration."""
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
            raise table.refuse(key, f'is not allowed with design = "{LIST}"')
        if design.kind in VARY_REPLACES_FIXED and key in fixed:
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
            raise table.refuse(key, f"cannot be a distribution; must be {definition.allowed}")
        if design.kind != LATIN_HYPERCUBE:
            raise table.refuse(key, f'a distribution needs design = "{LATIN_HYPERCUBE}"')
        drawn: Input = table.read(replace(definition, form=INPUT))
        return drawn
    if definition.kind not in (int, float) or definition.choices is not None:
        raise table.refuse(
            key, f"cannot be a range; must be a list of values, each {definition.allowed}"
        )
    sampled = design.kind == LATIN_HYPERCUBE
    of_end = {end: replace(definition, name=end) for end in ("from", "to")}
    ends = Table(f"{table.where} {key}:", value, of_end)
    ends.allow(*of_end, "spacing", *([] if sampled else ["count"]))
    for end in of_end:
        if end not in value:
            raise StudyError(f"{ends.where} {end}: is missing; a range has from and to")
    start, stop = (float(ends.read(end)) for end in of_end.values())
    logarithmic = ends.read(SPACING) == "logarithmic"
    if logarithmic and min(start, stop) <= 0:
        raise ends.refuse("spacing", "from and to must be > 0")
    span = Range(start=start, stop=stop, logarithmic=logarithmic)
    if sampled:
        if start >= stop:
            raise ends.refuse("to", f"must be > {start:g}")
        return span
    numbers = span.values(ends.read(COUNT))
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
            raise StudyError(f"{where}: {name} is derived too, but not above this line")
    return expression


def _listed(table: Table, design: Design) -> tuple[Combination, ...]:
    if design.kind != LIST:
        if "case" in table.values:
            raise table.refuse("case", f'is allowed only with design = "{LIST}"')
        return ()
    cases = table.list("case")
    if not cases:
        raise StudyError(f"{table.where} case: is missing; each case is a table [[case]]")
    listed = []
    for number, case in enumerate(cases, 1):
        if not isinstance(case, dict):
            raise StudyError(f"{table.where} case {number} = {shown(case)}: must be a table")
        here = Table(f"{table.where} [[case]] {number}:", case, table.known)
        here.check_variants()
        listed.append(here.all_values())
    return tuple(listed)
