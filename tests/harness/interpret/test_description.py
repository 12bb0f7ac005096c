"""Site files in words and by their schema: both from the keys that the reader itself takes."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from harness.interpret.description import (
    LAYER_KEYS,
    SITE_KEYS,
    TEST_KEYS,
    site_schema,
    site_text,
)
from harness.interpret.site import load_site
from harness.study.tables import StudyError
from tests.harness.conftest import Command
from tests.harness.interpret.conftest import LAYER, SITE

SCHEMA = Draft202012Validator(site_schema())
WHOLE = f"{SITE}{LAYER}"

TESTED = '[[laboratory]]\ndepth = 5\nstrength = 20.5\ntest = "CAUC"\nerror = 0.1\n'
VALID = {
    "as it is": ("", ""),
    "range": ("= 120", "= { low = 50, high = 300 }"),
    "triangle": ("= 120", "= { low = 50, mode = 80, high = 300 }"),
    "normal": ("= 120", "= { mean = 100, deviation = 9 }"),
    "lognormal": ("= 120", '= { mean = 100, deviation = 9, shape = "lognormal" }'),
    "percentiles": ("= 120", "= { p10 = 50, p50 = 90, p90 = 200 }"),
    "by the sleeve": ("adhesion_factor = 0.4", 'adhesion_factor = "sleeve"'),
    "weight by depth": ("= 17", "= { depth = [0, 5], value = [16, 18] }"),
    "water by depth": ("water_level = 1.0", "u0 = { depth = [0, 5], value = [0, 40] }"),
    "no water": ("water_level = 1.0", ""),
    "class": ("accuracy = {", 'accuracy = "class 1" # {'),
    "rate": ("laboratory_rate = 1e-6", 'laboratory_rate = "5 %/h"'),
    "use": ("[test]", 'use = ["tip", "sleeve"]\n[test]'),
    "laboratory": ("[[layer]]", f"{TESTED}[[layer]]"),
    "names": ("[test]", '[test]\ncolumns = { qc = "cone" }\nunits = { qc = "bar" }'),
}
REFUSED = {
    "laboratory of another kind": (
        "[[layer]]",
        f"{TESTED.replace('CAUC', 'CUAC')}[[layer]]",
        "[[laboratory]] 1 test = 'CUAC' is not allowed",
    ),
    "laboratory without a strength": (
        "[[layer]]",
        '[[laboratory]]\ndepth = 5\ntest = "UU"\n[[layer]]',
        "[[laboratory]] 1 strength: is missing",
    ),
    "laboratory in one line": ("title = ", 'laboratory = "a.csv"\ntitle = ', "must be"),
    "misspelt": ("rigidity_index", "rigidty_index", "did you mean 'rigidity_index'"),
    "lacks a key": ("rigidity_index = 120", "", "rigidity_index: is missing"),
    "beyond": ("= 120", "= 5000", "must be a number >= 15 and <= 1000"),
    "beyond and not used": (
        "strength =",
        "extension_ratio = 5\nstrength =",
        "extension_ratio = 5 is not allowed: must be a number > 0 and <= 1.2",
    ),
    "half a range": ("= 120", "= { low = 50 }", "must be a number, { low, high }"),
    "unknown shape": (
        "= 120",
        '= { mean = 100, deviation = 9, shape = "beta" }',
        "shape must be normal",
    ),
    "one percentile": ("= 120", "= { p10 = 50 }", "must be a number, { low, high }"),
    "a text": ("= 120", '= "stiff"', "must be a number, { low, high }"),
    "by the tip": (
        "adhesion_factor = 0.4",
        'adhesion_factor = "tip"',
        "must be sleeve or a number",
    ),
    "a depth above": (
        "from = 2",
        "from = -2",
        "must be a number >= 0; meaning: depth of its top, in m",
    ),
    "sleeve of another key": ("= 120", '= "sleeve"', "must be a number, { low, high }"),
    "no such class": (
        "accuracy = {",
        'accuracy = "class 7" # {',
        "half widths of 95 %, or 'class 1', 'class 2', 'class 3'; did you mean 'class 3'",
    ),
    "half the errors": (", u2 = 0 }", " }", "must have qc, fs and u2"),
    "two waters": ("[test]", "[test]\nu0 = { depth = [0], value = [0] }", "says the same"),
    "K0 and Delta": ("[[layer]]", "[[layer]]\nK0 = 0.5", "says the same"),
    "no such use": ("[test]", 'use = ["tap"]\n[test]', "must be a list of tip, sleeve"),
    "too few samples": ("[test]", "samples = 3\n[test]", "must be an integer >= 512 and <= 65536"),
    "rate of what": ("= 1e-6", '= "5 %"', 'must be a text as "5 %/h"'),
    "two points": ("= 1e-6", '= "1.2.3 %/h"', 'must be a text as "5 %/h"'),
    "rate too high": ("= 1e-6", "= 1", "must be >= 1e-06"),
    "no layer": ("[[layer]]", "[other]", "unknown key"),
    "a column of another name": ("[test]", '[test]\ncolumns = { tip = "cone" }', "unknown key"),
    "area ratio": ("area_ratio = 0.8", "area_ratio = 1.8", "> 0 and <= 1"),
    "heavy": ("= 17", "= 17000", "must be a number >= 10 and <= 30"),
    "buoyant": ("= 17", "= 9", "must be a number >= 10 and <= 30"),
    "heavy below": ("= 17", "= { depth = [1], value = [90] }", "at all depths"),
}
"""A text, what stands there instead, and what is said of it."""


def test_the_schema_is_one() -> None:
    Draft202012Validator.check_schema(SCHEMA.schema)


@pytest.mark.parametrize("change", VALID)
def test_the_schema_and_the_reader_take_the_same(tmp_path: Path, change: str) -> None:
    text = WHOLE.replace(*VALID[change], 1)
    (tmp_path / "site.toml").write_text(text)
    load_site(tmp_path / "site.toml")
    assert list(SCHEMA.iter_errors(tomllib.loads(text))) == []


@pytest.mark.parametrize(("old", "new", "told"), REFUSED.values(), ids=REFUSED)
def test_schema_and_reader_refuse_the_same(tmp_path: Path, old: str, new: str, told: str) -> None:
    text = WHOLE.replace(old, new, 1)
    assert text != WHOLE
    path = tmp_path / "site.toml"
    path.write_text(text)
    with pytest.raises(StudyError, match=f"^{re.escape(str(path))}: .*{re.escape(told)}"):
        load_site(path)
    assert not SCHEMA.is_valid(tomllib.loads(text))


def test_a_new_site_file_is_valid_and_described(tmp_path: Path, command: Command) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(site_text("test.csv", {"area_ratio": 0.8, "water_level": 2.3}))
    assert SCHEMA.is_valid(tomllib.loads(path.read_text()))
    site = load_site(path)
    assert {"adhesion_factor", "K0", "rate_factor"} <= set(site.layers[0].assumed)
    assert site.test.assumed == ("unit_weight", "accuracy")
    assert "\nwater_level = 2.3  # by test.csv\n" in path.read_text()
    assert max(map(len, path.read_text().splitlines())) <= 100
    told = command("describe", path).out
    named = [line.split()[0] for line in told.splitlines()[2:] if line and line[0] not in " ["]
    keys = [key.name for key in (*SITE_KEYS, *TEST_KEYS, *LAYER_KEYS)]
    assert [*keys, "an"] == named
    assert "rigidity_index     { low = 50, high = 300 }" in told
    assert "5 %: 54.7, 50 %: 122, 95 %: 274" in told  # uniform in the logarithm


def test_the_schema_of_sites_is_printed(command: Command) -> None:
    assert json.loads(command("schema", "site").out) == SCHEMA.schema
