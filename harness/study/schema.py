"""The JSON schema of study files, by which editors complete and check them.

It is made from the definitions of the parameters, scene by scene. It does not check what depends
on several values together, such as the number of cases; the harness does when it reads a study.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

from harness.references.registry import EXPERIENCE_IDS, REFERENCE_IDS
from harness.study.compared import (
    DEFAULT_TEXTS,
    OWN_REFERENCES,
    REFERENCE_NAME,
    REFERENCE_STUDY,
    SYMBOLS,
)
from harness.study.designs import DESIGNS, LATIN_HYPERCUBE, LIST, SPACINGS
from harness.study.distributions import FORMS, PERCENTILE
from harness.study.expressions import LONGEST_EXPRESSION
from harness.study.scene_part import (
    LARGEST_STUDY,
    SCENE_KEYS,
    SNAPSHOTS,
    Scene,
    loaded_scenes,
    moment_of,
)
from harness.study.study import LARGEST_SEED, MOST_REPEATS, STABILITY_MAP
from mpm_warp.checks import Range
from mpm_warp.fields import Parameter, parameters_of
from mpm_warp.scenes.sounding.table import PROFILE

DIALECT = "https://json-schema.org/draft/2020-12/schema"
TYPES = {float: "number", int: "integer", bool: "boolean", str: "string"}
Schema = dict[str, Any]
LINE: Schema = {"type": "string", "pattern": "\\S"}
"""A text that is not empty."""


def study_schema() -> Schema:
    """The schema of study files. A scene that cannot be loaded is left out, and a line says why."""
    scenes = {name: _of_scene(scene) for name, scene in loaded_scenes().items()}
    references = _ids(REFERENCE_IDS, "cone factors of the literature")
    # If the study defines references, or its base may, their names are allowed too.
    defines = [{"required": [OWN_REFERENCES]}, {"required": ["base"]}]
    own = references | {"items": {"anyOf": [references["items"], {"pattern": REFERENCE_NAME}]}}
    shipped = {"properties": {"compare": {"properties": {"references": references}}}}
    experience = _ids(EXPERIENCE_IDS, "bands of factors measured in the field")
    tolerance = {
        "type": "object",
        "description": "largest deviation from a reference, or size of a result",
        "additionalProperties": {"type": "number", "exclusiveMinimum": 0},
    }
    scene_name = {"enum": list(scenes)}
    properties: Schema = {
        "title": LINE | {"description": "one line on what the study shows"},
        "base": LINE | {"description": "study from which keys are taken that this one lacks"},
        "scene": {
            "description": "what is simulated, or a list of several",
            "anyOf": [scene_name, {"type": "array", "items": scene_name, "minItems": 1}],
        },
        "design": {"enum": list(DESIGNS), "description": "how varied values are combined"},
        "samples": _integer("cases of a Latin hypercube", 1, LARGEST_STUDY),
        "seed": _integer("seed of a Latin hypercube's random numbers", 0, LARGEST_SEED),
        **{key: {} for key in SCENE_KEYS},  # their content depends on the scene; see allOf below
        PROFILE: {
            "type": "object",
            "description": "ground by depth: columns such as 'depth [m]', or file = a CSV file",
        },
        "scenes": table_schema(scenes, description="keys that apply to one scene of several"),
        "compare": table_schema(
            {
                "references": own,
                REFERENCE_STUDY: LINE
                | {"description": "study; errors are differences from its stored result"},
                "experience": experience,
                "tolerance": tolerance,
            }
        ),
        OWN_REFERENCES: {
            "type": "object",
            "description": "your own references: cone factors as formulas of parameters",
            "propertyNames": {"pattern": f"^{REFERENCE_NAME}$"},
            "additionalProperties": _own_reference(),
        },
        STABILITY_MAP: {"type": "boolean", "description": "draw where the cases complete"},
        "timing": table_schema({"repeats": _integer("timed runs of each case", 1, MOST_REPEATS)}),
    }
    return {
        "$schema": DIALECT,
        "title": "Study of the harness",
        **table_schema(properties),
        "anyOf": [{"required": ["base"]}, {"required": ["title", "scene"]}],
        "allOf": [
            # The schema of a scene has no other keys of a study, so only its properties are used.
            *(
                _if("scene", name, {"properties": tables["properties"]})
                for name, tables in scenes.items()
            ),
            _if("design", LATIN_HYPERCUBE, {"required": ["samples", "seed", "vary"]}),
            _if("design", LIST, {"required": ["case"]}),
            {"if": {"not": {"anyOf": defines}}, "then": shipped},
        ],
    }


def _own_reference() -> Schema:
    """The schema of a table [references.NAME]."""
    span = {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}
    texts = {
        "label": LINE | {"description": "name in pictures, such as authors and year"},
        "source": LINE | {"description": "where it is published"},
        **dict.fromkeys(DEFAULT_TEXTS, LINE),
    }
    ranges = {
        "type": "object",
        "description": "least and greatest value for which it is valid, by parameter or symbol",
        "additionalProperties": span,
    }
    formula = _expression(f"formula of parameters, or of {', '.join(SYMBOLS)}")
    required = ["formula", "label", "source"]
    return table_schema({"formula": formula, **texts, "range": ranges}, required=required)


def _of_scene(scene: Scene) -> Schema:
    """The schema of the keys whose content depends on the scene."""
    parameters, over = parameters_of(scene).values(), scene.snapshots_over

    def of_each(schema: Callable[[Parameter], Schema]) -> Schema:
        properties = {parameter.name: schema(parameter) for parameter in parameters}
        for parameter in parameters:  # one with variants may also be a table
            if parameter.variants is not None:
                name, own = parameter.name, f"{parameter.name}."
                of_own = {it.removeprefix(own): one for it, one in properties.items() if own in it}
                table = table_schema({parameter.variants.key: properties[name], **of_own})
                properties[name] = {"anyOf": [properties[name], table]}
        return table_schema(properties)

    fixed = of_each(value_schema)
    return table_schema(
        {
            "fixed": fixed,
            "vary": of_each(_variation),
            "derived": of_each(lambda parameter: _expression(parameter.meaning)),
            "exclude": {"type": "array", "items": _expression("condition of cases not to run")},
            "case": {"type": "array", "items": fixed},
            **({} if over is None else {SNAPSHOTS: _variation(moment_of(scene, over))}),
        }
    )


def bounds_schema(allowed: Range) -> Schema:
    """The schema keywords for the bounds of a number."""
    bounds = {
        "minimum": allowed.minimum,
        "maximum": allowed.maximum,
        "exclusiveMinimum": allowed.above,
        "exclusiveMaximum": allowed.below,
    }
    return {name: bound for name, bound in bounds.items() if math.isfinite(bound)}


def value_schema(parameter: Parameter) -> Schema:
    """The schema of a parameter's value."""
    schema: Schema = {
        "type": TYPES[parameter.kind],
        "description": parameter.explanation,
        **bounds_schema(parameter.bounds),
        "enum": None if parameter.choices is None else list(parameter.choices),
        "default": parameter.default,
    }
    return {key: value for key, value in schema.items() if value is not None}


def _variation(parameter: Parameter) -> Schema:
    value = value_schema(parameter)
    several = {"type": "array", "items": value, "minItems": 1, "uniqueItems": True}
    if parameter.kind not in (int, float) or parameter.choices is not None:
        return several
    count = _integer("numbers from one end to the other", 2, LARGEST_STUDY)
    ends = {"from": value, "to": value, "count": count, "spacing": {"enum": list(SPACINGS)}}
    span = table_schema(ends, required=["from", "to"])
    drawn = distributions() if parameter.kind is float else []
    return {"description": value["description"], "anyOf": [several, span, *drawn]}


def distributions() -> list[Schema]:
    """Schemas of all forms of an uncertain input that is not a single number."""
    kinds: dict[str, Schema] = {"shape": {"enum": ["normal", "lognormal"]}}
    number = {"type": "number"}
    tables = [
        table_schema({name: kinds.get(name, number) for name in form}, required=list(form))
        for form in FORMS
    ]
    percentiles = {"patternProperties": {f"^{PERCENTILE}$": number}, "minProperties": 2}
    return [*tables, table_schema({}, **percentiles)]


def _integer(meaning: str, least: int, most: int) -> Schema:
    return {"type": "integer", "description": meaning, "minimum": least, "maximum": most}


def _ids(known: Sequence[str], meaning: str) -> Schema:
    items = {"enum": list(known)}
    return {"type": "array", "items": items, "uniqueItems": True, "description": meaning}


def _expression(meaning: str) -> Schema:
    return {
        "type": "string",
        "description": meaning,
        "minLength": 1,
        "maxLength": LONGEST_EXPRESSION,
    }


def table_schema(properties: Schema, **more: object) -> Schema:
    """The schema of a table that may have these keys and no others."""
    return {"type": "object", "properties": properties, "additionalProperties": False, **more}


def _if(key: str, value: str, then: Schema) -> Schema:
    condition = {"properties": {key: {"const": value}}, "required": [key]}
    return {"if": condition, "then": then}
