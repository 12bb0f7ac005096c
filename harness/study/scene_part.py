"""What a study does with one scene: its parameters and their values, read from the definition."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from harness.study.definition import StudyError, Table, shown
from harness.study.designs import (
    EITHER_FIXED_OR_VARIED,
    LATIN_HYPERCUBE,
    LIST,
    SPACINGS,
    Combination,
    Design,
    Range,
)
from harness.study.expressions import Expression, ExpressionError
from harness.study.known_parameters import KnownParameters
from mpm_warp.parameters import Parameter, Value, nearest_name, parameters_of
from mpm_warp.scenes import scene_class

LARGEST_STUDY = 100_000
"""Cases that a study may have; one with more is a slip in a list, not a plan."""


@dataclass(frozen=True, kw_only=True)
class ScenePart:
    """What a study does with one scene; every name and value is valid.

    Attributes:
        scene: name of the scene.
        fixed: parameters that are the same in every case, or where nothing varies them.
        varied: values of the parameters that vary; a range in a Latin hypercube alone.
        listed: the cases of the design ``list``.
        derived: parameters worked out from the others, in this order.
        excluded: conditions on cases that are not run.
    """

    scene: str
    fixed: Mapping[str, Value]
    varied: Mapping[str, tuple[Value, ...] | Range]
    listed: tuple[Combination, ...]
    derived: Mapping[str, Expression]
    excluded: tuple[Expression, ...]


def read_part(scene: str, table: Table, design: Design, settings: Mapping[str, Any]) -> ScenePart:
    """Read what a study does with a scene, and apply settings.

    Args:
        scene: its name.
        table: all that the definition says of it.
        design: how varied values are combined.
        settings: parameters and their values, which hold whatever the definition says; one that
            varies leaves alone what the design `one_at_a_time` begins with.

    Raises:
        StudyError: something in it is not allowed.
    """
    known = parameters_of(scene_class(scene))
    vary_table = table.table("vary")
    fixed = _fixed(known, table.table("fixed"))
    varied = _varied(known, vary_table, design)
    derived = _derived(known, table.table("derived"))
    listed = _listed(known, table, design)
    _check_varied(vary_table, design, fixed)
    parameters = KnownParameters(known, "--set")
    for key, value in settings.items():
        derived.pop(key, None)
        if not isinstance(value, (list, dict)):
            fixed[key] = parameters.value(key, value)
            varied.pop(key, None)
            continue
        varied[key] = _set_variation(parameters, key, value, design)
        if design.kind in EITHER_FIXED_OR_VARIED:
            fixed.pop(key, None)
    if design.kind == LATIN_HYPERCUBE and not varied:
        raise StudyError(f"{vary_table.where}: nothing varies, there is nothing to sample")
    return ScenePart(
        scene=scene,
        fixed=fixed,
        varied=varied,
        listed=tuple(_without(case, settings) for case in listed),
        derived=derived,
        excluded=_excluded(known, table),
    )


def _fixed(known: Mapping[str, Parameter], table: Table) -> dict[str, Value]:
    for key, value in table.values.items():
        KnownParameters(known, table.where).definition(key, value)
        if isinstance(value, list):
            raise table.refuse(key, "is a list; what varies belongs under [vary]")
    return _values(known, table)


def _values(known: Mapping[str, Parameter], table: Table) -> dict[str, Value]:
    parameters = KnownParameters(known, table.where)
    return {key: parameters.value(key, value) for key, value in table.values.items()}


def _without(case: Combination, settings: Mapping[str, Any]) -> Combination:
    return {key: value for key, value in case.items() if key not in settings}


def _set_variation(
    parameters: KnownParameters, key: str, value: object, design: Design
) -> tuple[Value, ...] | Range:
    """What a setting varies, which in a list of cases none can."""
    if design.kind == LIST:
        allowed = parameters.definition(key, value).allowed
        raise StudyError(
            f'{parameters.where} {key} = {shown(value)}: design = "{LIST}" does not vary it; '
            f"must be {allowed}"
        )
    return _variation(parameters, key, value, design)


def _varied(
    known: Mapping[str, Parameter], table: Table, design: Design
) -> dict[str, tuple[Value, ...] | Range]:
    parameters = KnownParameters(known, table.where)
    return {key: _variation(parameters, key, value, design) for key, value in table.values.items()}


def _check_varied(table: Table, design: Design, fixed: Mapping[str, Value]) -> None:
    for key in table.values:
        if design.kind == LIST:
            raise table.refuse(key, f'does not go with design = "{LIST}"')
        if design.kind in EITHER_FIXED_OR_VARIED and key in fixed:
            raise table.refuse(key, "is under [fixed] as well; keep one of them")


def _variation(
    parameters: KnownParameters, key: str, value: object, design: Design
) -> tuple[Value, ...] | Range:
    """A list of values, or a range such as ``{from = 1, to = 100, count = 5}``."""
    if not isinstance(value, dict):
        return parameters.values(key, value)
    definition = parameters.definition(key, value)
    table = Table(f"{parameters.where} {key}:", value)
    if definition.kind not in (int, float) or definition.choices is not None:
        raise StudyError(
            f"{parameters.where} {key} = {shown(value)}: has no ranges; must be a list of values, "
            f"each {definition.allowed}"
        )
    sampled = design.kind == LATIN_HYPERCUBE
    table.allow("from", "to", "spacing", *([] if sampled else ["count"]))
    for end in ("from", "to"):
        if end not in value:
            raise StudyError(f"{table.where} {end}: is missing; a range has from and to")
        KnownParameters({end: replace(definition, name=end)}, table.where).value(end, value[end])
    start, stop = float(value["from"]), float(value["to"])
    logarithmic = table.word("spacing", SPACINGS) == "logarithmic"
    if logarithmic and min(start, stop) <= 0:
        raise table.refuse("spacing", "from and to must be > 0")
    span = Range(start=start, stop=stop, logarithmic=logarithmic)
    if sampled:
        if start >= stop:
            raise table.refuse("to", f"must be > {start:g}")
        return span
    numbers = span.values(table.integer("count", 2, LARGEST_STUDY))
    return parameters.values(key, list(numbers))


def _derived(known: Mapping[str, Parameter], table: Table) -> dict[str, Expression]:
    derived: dict[str, Expression] = {}
    for key, value in table.values.items():
        KnownParameters(known, table.where).definition(key, value)
        later = [name for name in table.values if name not in derived]
        derived[key] = _expression(known, f"{table.where} {key} = {shown(value)}", value, later)
    return derived


def _excluded(known: Mapping[str, Parameter], table: Table) -> tuple[Expression, ...]:
    return tuple(
        _expression(known, f"{table.where} exclude = {shown(text)}", text, [])
        for text in table.list("exclude")
    )


def _expression(
    known: Mapping[str, Parameter], where: str, text: object, later: list[str]
) -> Expression:
    try:
        expression = Expression.parsed(text)
    except ExpressionError as error:
        raise StudyError(f"{where}: {error}") from None
    for name in sorted(expression.names):
        if name not in known:
            raise StudyError(f"{where}: unknown parameter {name!r}{nearest_name(name, known)}")
        if name in later:
            raise StudyError(f"{where}: {name} is derived itself, and not before")
    return expression


def _listed(
    known: Mapping[str, Parameter], table: Table, design: Design
) -> tuple[Combination, ...]:
    if design.kind != LIST:
        if "case" in table.values:
            raise table.refuse("case", f'goes with design = "{LIST}" alone')
        return ()
    cases = table.list("case")
    if not cases:
        raise StudyError(f"{table.where} case: is missing; each case is a table [[case]]")
    for number, case in enumerate(cases, 1):
        if not isinstance(case, dict):
            raise StudyError(f"{table.where} case {number} = {shown(case)}: must be a table")
    return tuple(
        _values(known, Table(f"{table.where} [[case]] {number}:", case))
        for number, case in enumerate(cases, 1)
    )
