"""The JSON schema agrees with what the harness itself accepts and refuses."""

import json
import tomllib

import pytest
from jsonschema import Draft202012Validator

from harness.study.files import studies_folder, study_names
from harness.study.schema import study_schema
from mpm_warp.fields.checks import Range
from mpm_warp.fields.declaration import Parameter
from mpm_warp.scenes import scene_names
from tests.harness.conftest import HEAD, Command

SCHEMA = Draft202012Validator(study_schema())

VALID = {
    "range": '[vary]\ndensity = { from = 1, to = 9, count = 3, spacing = "logarithmic" }',
    "distribution": "[vary]\ndensity = { p10 = 1, p90 = 2 }",
    "lognormal": '[vary]\ndensity = { mean = 1, deviation = 1, shape = "lognormal" }',
    "derived": '[derived]\ndensity = "2 * penetration"',
    "list": "[[case]]\ndensity = 1\n[[case]]\ndensity = 2",
    "reference of its own": (
        '[references.ours]\nformula = "2 * Ir"\nlabel = "We"\nsource = "here"\n'
        'criterion = "tresca"\nrange = { Ir = [1, 2], Delta = 0 }\n'
        "[references.ours_2]\npoints = { Ir = [100], Nc = [10] }\n"
        'label = "We"\nsource = "here"\n'
        '[compare]\nreferences = ["lu_2004", "ours"]'
    ),
    "scene of its own": "[scenes.cone_penetration.fixed]\ndensity = 1",
}
INVALID = {
    "misspelt": "[fixed]\ndensty = 1",
    "out of range": "[fixed]\nadhesion_factor = 1.5",
    "at an open bound": "[vary]\nrigidity_index = [1]",
    "choice": '[fixed]\nmaterial = "treska"',
    "wrong type": '[fixed]\ndensity = "1"',
    "range of texts": "[vary]\nmaterial = { from = 1, to = 2 }",
    "range without an end": "[vary]\ndensity = { from = 1 }",
    "distribution without a deviation": "[vary]\ndensity = { mean = 1 }",
    "unknown key": "scenne = 1",
    "reference": '[compare]\nreferences = ["lu_2005"]',
    "reference without a formula": '[references.ours]\nlabel = "We"\nsource = "here"',
    "experience": '[compare]\nexperience = ["lu_2004"]',
    "reference study": "[compare]\nreference_study = 1",
    "repeats": "[timing]\nrepeats = 0",
    "misspelt case": "[[case]]\ndensty = 1",
    "unknown scene": "[scenes.cone_penetratoin.fixed]\ndensity = 1",
}


def test_the_schema_is_one() -> None:
    """What stands under a scene of several is that of the scene alone, and is not checked twice."""
    own = {**SCHEMA.schema["properties"], "scenes": {}}
    Draft202012Validator.check_schema({**SCHEMA.schema, "properties": own})


@pytest.mark.parametrize("name", study_names())
def test_a_study_that_ships_is_valid(name: str) -> None:
    text = (studies_folder() / f"{name}.toml").read_text()
    assert list(SCHEMA.iter_errors(tomllib.loads(text))) == []


@pytest.mark.parametrize("scene", scene_names())
def test_every_scene_may_stand_in_a_study(scene: str) -> None:
    assert SCHEMA.is_valid({"title": "t", "scene": scene})
    assert not SCHEMA.is_valid({"title": "t", "scene": scene, "fixed": {"misspelt": 1}})


@pytest.mark.parametrize("what", VALID)
def test_what_is_allowed(what: str) -> None:
    assert list(SCHEMA.iter_errors(tomllib.loads(HEAD + VALID[what]))) == []


@pytest.mark.parametrize("what", INVALID)
def test_what_is_refused(what: str) -> None:
    assert not SCHEMA.is_valid(tomllib.loads(HEAD + INVALID[what]))


@pytest.mark.parametrize("text", ["", 'title = "t"', 'scene = "cone_penetration"'])
def test_what_must_be_there(text: str) -> None:
    assert not SCHEMA.is_valid(tomllib.loads(text))
    assert SCHEMA.is_valid(tomllib.loads(f'base = "adhesion_factor"\n{text}'))


def test_every_bound_of_a_parameter_is_there() -> None:
    bounds = Range(minimum=1.0, maximum=9.0, above=0.0, below=10.0)
    made = Parameter(name="a", kind=float, default=2.0, unit="m", meaning="length", bounds=bounds)
    assert made.schema == {
        "type": "number",
        "description": f"length [m]; {made.allowed}",
        "minimum": 1.0,
        "maximum": 9.0,
        "exclusiveMinimum": 0.0,
        "exclusiveMaximum": 10.0,
        "default": 2.0,
    }


def test_the_command_prints_it(command: Command) -> None:
    assert json.loads(command("schema").out) == SCHEMA.schema
