"""The JSON schema of study files, by which editors complete and check them.

It is made from the definitions of the parameters, scene by scene. It does not check what depends
on several values together, such as the number of cases; the harness does when it reads a study.
"""

from collections.abc import Callable, Sequence

from harness.expressions import expression_schema
from harness.references.reference import FACTOR
from harness.references.registry import BANDS, REFERENCES
from harness.study.compared import (
    OWN_KEYS,
    OWN_REFERENCES,
    REFERENCE_NAME,
    REFERENCE_STUDY,
    RESULT,
    TOLERANCE,
)
from harness.study.designs import LATIN_HYPERCUBE, LIST, Design
from harness.study.distributions import distributions
from harness.study.files import BASE
from harness.study.scene_part import (
    COUNT,
    SCENE_KEYS,
    SNAPSHOTS,
    SPACING,
    Scene,
    loaded_scenes,
    moment_of,
)
from harness.study.study import KEYS, STABILITY_MAP
from harness.study.tables import schema_of, table_schema
from mpm_warp.fields.declaration import Parameter, Schema
from mpm_warp.fields.flat import parameters_of
from mpm_warp.scenes.sounding.table import PROFILE

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def study_schema() -> Schema:
    """The schema of study files. A scene that cannot be loaded is left out, and a line says why."""
    scenes = {name: _of_scene(scene) for name, scene in loaded_scenes().items()}
    references = _ids(tuple(REFERENCES), "cone factors of the literature")
    # If the study defines references, or its base may, their names are allowed too.
    defines = [{"required": [OWN_REFERENCES]}, {"required": ["base"]}]
    own = references | {"items": {"anyOf": [references["items"], {"pattern": REFERENCE_NAME}]}}
    shipped = {"properties": {"compare": {"properties": {"references": references}}}}
    experience = _ids(tuple(BANDS), "bands of factors measured in the field")
    tolerance = {"type": "object", "additionalProperties": TOLERANCE.schema}
    scene_name = {"enum": list(scenes)}
    properties: Schema = {
        "title": KEYS["title"].schema,
        "base": BASE.schema,
        "scene": {
            "description": "what is simulated, or a list of several",
            "anyOf": [scene_name, {"type": "array", "items": scene_name, "minItems": 1}],
        },
        **{field.name: field.schema for field in parameters_of(Design).values()},
        **{key: {} for key in SCENE_KEYS},  # their content depends on the scene; see allOf below
        PROFILE: {
            "type": "object",
            "description": "ground by depth: columns such as 'depth [m]', or file = a CSV file",
        },
        "scenes": table_schema(scenes, description="keys that apply to one scene of several"),
        "compare": table_schema(
            {
                "references": own,
                REFERENCE_STUDY: RESULT.schema,
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
        STABILITY_MAP: KEYS[STABILITY_MAP].schema,
        "timing": schema_of([KEYS["timing_repeats"]]) | {"required": []},
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
    number: Schema = {"type": "number"}
    span = {"type": "array", "items": number, "minItems": 2, "maxItems": 2}
    ranges = {
        "type": "object",
        "description": "least and greatest value, or one, where it is valid, by symbol",
        "additionalProperties": {"anyOf": [number, span]},
    }
    points = {
        "type": "object",
        "description": f"in place of a formula, columns of symbols and {FACTOR}",
        "additionalProperties": {"type": "array", "items": number, "minItems": 1},
        "required": [FACTOR],
    }
    one_of = {"oneOf": [{"required": ["formula"]}, {"required": ["points"]}]}
    return schema_of(OWN_KEYS, range=ranges, points=points) | one_of


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

    fixed = of_each(lambda parameter: parameter.schema)
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


def _variation(parameter: Parameter) -> Schema:
    value = parameter.schema
    several = {"type": "array", "items": value, "minItems": 1, "uniqueItems": True}
    if parameter.kind not in (int, float) or parameter.choices is not None:
        return several
    ends = {"from": value, "to": value, "count": COUNT.schema, "spacing": SPACING.schema}
    span = table_schema(ends, required=["from", "to"])
    drawn = distributions() if parameter.kind is float else []
    return {"description": value["description"], "anyOf": [several, span, *drawn]}


def _ids(known: Sequence[str], meaning: str) -> Schema:
    items = {"enum": list(known)}
    return {"type": "array", "items": items, "uniqueItems": True, "description": meaning}


def _expression(meaning: str) -> Schema:
    return {"description": meaning, **expression_schema()}


def _if(key: str, value: str, then: Schema) -> Schema:
    condition = {"properties": {key: {"const": value}}, "required": [key]}
    return {"if": condition, "then": then}
