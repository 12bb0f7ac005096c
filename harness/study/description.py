"""Scenes and studies in words, for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from harness.study.designs import FULL, LATIN_HYPERCUBE, Range
from harness.study.scene_part import ScenePart
from harness.study.study import Study
from mpm_warp.parameters import Parameter, parameters_of
from mpm_warp.scenes import scene_class


def scene_rows(name: str) -> list[str]:
    """What a scene simulates, and its parameters: default, unit, meaning, allowed range."""
    scene = scene_class(name)
    rows = [f"{name}: {scene.summary}", ""]
    for parameter, definition in parameters_of(scene).items():
        meaning = f"{definition.meaning}; {definition.allowed}"
        rows.append(f"{parameter:26} {_default(definition):16} {meaning}")
    return rows


def _default(definition: Parameter) -> str:
    """The default of a parameter with its unit, in words."""
    if definition.default is None:
        return "derived" if definition.unit == "1" else f"derived [{definition.unit}]"
    return f"{definition.default}{_unit(definition)}"


def study_rows(study: Study) -> list[str]:
    """What a study runs, what it varies and fixes, and what it is compared with."""
    count = len(study.cases)
    rows = [
        f"{study.name}: {study.title}",
        "",
        f"{'file':12} {study.source}",
        f"{'cases':12} {count}, {_DESIGNS.get(study.design.kind, study.design.kind)}",
    ]
    for part in study.parts:
        rows += [f"{title:12} {text}" for title, text in _of_part(part)]
    if study.references:
        rows.append(f"{'references':12} {', '.join(study.references)}")
    if study.reference_result is not None:
        rows.append(f"{'errors from':12} {study.reference_result}")
    if study.experience:
        rows.append(f"{'experience':12} {', '.join(study.experience)}")
    rows += [f"{'tolerance':12} {name} = {limit:g}" for name, limit in study.tolerances.items()]
    if study.timing_repeats:
        rows.append(f"{'timing':12} {study.timing_repeats} warm runs a case")
    scenes = ", ".join(f"harness describe {part.name}" for part in study.parts)
    return [*rows, "", f"all parameters: {scenes}"]


_DESIGNS = {
    FULL: "all combinations of what varies",
    "one_at_a_time": "one parameter varied at a time",
    "list": "as they are listed",
    LATIN_HYPERCUBE: "a Latin hypercube",
}


def _of_part(part: ScenePart) -> Iterator[tuple[str, str]]:
    yield "scene", f"{part.name}, {part.scene.summary}"
    for name, values in part.varied.items():
        yield "varied", f"{name} = {_span(values)}{_unit(part.parameters[name])}"
    for name, value in part.fixed.items():
        yield "fixed", f"{name} = {value}{_unit(part.parameters[name])}"
    for name, expression in part.derived.items():
        yield "derived", f"{name} = {expression.text}"
    for condition in part.excluded:
        yield "excluded", condition.text


def _span(values: object) -> str:
    if isinstance(values, Range):
        return f"{values.start:g} to {values.stop:g}"
    assert isinstance(values, tuple)
    return ", ".join(map(str, values))


def _unit(definition: Parameter) -> str:
    return "" if definition.unit == "1" else f" {definition.unit}"
