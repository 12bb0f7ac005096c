"""The definition of a new study: all parameters of a scene, explained; it runs as it stands."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable
from collections.abc import Set as AbstractSet

from harness.references.cone_factors import ENVELOPE
from harness.references.experience import EXPERIENCE
from harness.study.compared import takes_references
from mpm_warp.errors import ParameterError
from mpm_warp.parameters import Parameter, Value, parameters_of
from mpm_warp.scenes import CatalogueScene, scene_class

WIDTH = 100
"""Columns of the file."""


def study_text(name: str, scene_name: str) -> str:
    """A study in TOML that varies one parameter and has the defaults of the others as comments.

    Args:
        name: of the study.
        scene_name: of its scene.

    Raises:
        UnknownSceneError: there is no such scene.
    """
    scene = scene_class(scene_name)
    parameters = parameters_of(scene)
    varied, values = _to_vary(scene)
    method = _method(scene)
    others = {key: it for key, it in parameters.items() if key != varied}
    parts = [
        f"# {scene_name}: {scene.summary}.",
        f"# Run it with `harness run {name}.toml`; the result goes to results/{name}.nc.",
        "# A line that begins with # is a comment. Take the # away from `#name = value` to give a",
        "# value of your own in the place of the default. All values are in SI units.",
        f"title = {_toml(scene.summary)}",
        f"scene = {_toml(scene_name)}",
        "",
        "# What varies: a list of values. Of several lists every combination is a case.",
        "# A range of values: { from = 1, to = 100, count = 5 }.",
        "[vary]",
        _meaning(parameters[varied]),
        f"{varied} = [{', '.join(map(_toml, values))}]",
        "",
        "# What is the same in all cases. A parameter stands here or under [vary], not in both.",
        "[fixed]",
        *_defaults(it for key, it in others.items() if key not in method),
    ]
    if method & others.keys():
        parts += ["", "# Mesh, steps and extent: a good result does not depend on them."]
        parts += _defaults(it for key, it in others.items() if key in method)
    if takes_references(scene):
        ids = ", ".join(_toml(it.id) for it in ENVELOPE)
        parts += ["", "# The literature beside its cone factor:"]
        parts += ["#[compare]", f"#references = [{ids}]"]
        parts += ["# and a band of factors measured in the field; others: `harness references`"]
        parts += [f"#experience = [{_toml(EXPERIENCE[0].id)}]"]
    return "\n".join([*parts, ""])


def _method(scene: type[CatalogueScene]) -> AbstractSet[str]:
    """Parameters of the method, and what refines an exact solution."""
    return {*scene.method, *(it.resolution for it in scene.verifications)}


def _to_vary(scene: type[CatalogueScene]) -> tuple[str, list[Value]]:
    """The first parameter that is none of the method, with values that the scene allows."""
    method, known = _method(scene), parameters_of(scene)
    for name, definition in sorted(known.items(), key=lambda it: it[0] in method):
        values = [it for it in _candidates(definition) if _allows(scene, name, it)]
        if len(values) > 1:
            return name, values
    name = next(iter(known))
    return name, [value for value in (known[name].default,) if value is not None]


def _candidates(definition: Parameter) -> list[Value]:
    """The choices of a parameter; or half its default, or its greatest value, and its default."""
    default = definition.default
    if definition.choices is not None:
        return list(definition.choices)
    if isinstance(default, bool | str) or default is None:
        return []
    if default != 0:
        return [type(default)(default / 2), default]
    return [default, *([] if definition.maximum is None else [float(definition.maximum)])]


def _allows(scene: type[CatalogueScene], name: str, value: Value) -> bool:
    try:
        scene(**{name: value})
    except ParameterError:
        return False
    return True


def _defaults(parameters: Iterable[Parameter]) -> list[str]:
    """Meaning and default of parameters, as comments."""
    lines = []
    for it in parameters:
        value = "..." if it.default is None else _toml(it.default)
        lines += [_meaning(it), f"#{it.name} = {value}"]
    return lines


def _meaning(definition: Parameter) -> str:
    return textwrap.fill(
        definition.explanation, WIDTH, initial_indent="# ", subsequent_indent="#   "
    )


def _toml(value: Value) -> str:
    """A value as it stands in a study; JSON writes texts, numbers and truth as TOML does."""
    return json.dumps(value, ensure_ascii=False)
