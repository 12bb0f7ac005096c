"""Site files in words and by their schema: both from the keys that the reader itself takes."""

import json
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from harness.cli.main import main
from harness.interpret.description import site_schema, site_text
from harness.interpret.keys import LAYER_KEYS, SITE_KEYS, TEST_KEYS
from harness.interpret.site import load_site
from harness.study.tables import StudyError
from tests.harness.interpret.conftest import LAYER, SITE

SCHEMA = Draft202012Validator(site_schema())
WHOLE = f"{SITE}{LAYER}"

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
    "class": ("accuracy = {", 'accuracy = "class 1" # {'),
    "rate": ("laboratory_rate = 1e-6", 'laboratory_rate = "5 %/h"'),
    "use": ("[test]", 'use = ["tip", "sleeve"]\n[test]'),
    "names": ("[test]", '[test]\ncolumns = { qc = "cone" }\nunits = { qc = "bar" }'),
}
INVALID = {
    "misspelt": ("rigidity_index", "rigidty_index"),
    "lacks a key": ("rigidity_index = 120", ""),
    "beyond": ("= 120", "= 5000"),
    "half a range": ("= 120", "= { low = 50 }"),
    "unknown shape": ("= 120", '= { mean = 100, deviation = 9, shape = "beta" }'),
    "one percentile": ("= 120", "= { p10 = 50 }"),
    "a text": ("= 120", '= "stiff"'),
    "a depth above": ("from = 2", "from = -2"),
    "sleeve of another key": ("= 120", '= "sleeve"'),
    "no such class": ("accuracy = {", 'accuracy = "class 7" # {'),
    "half the errors": (", u2 = 0 }", " }"),
    "two waters": ("[test]", "[test]\nu0 = { depth = [0], value = [0] }"),
    "no water": ("water_level = 1.0", ""),
    "K0 and Delta": ("[[layer]]", "[[layer]]\nK0 = 0.5"),
    "no such use": ("[test]", 'use = ["tap"]\n[test]'),
    "too few samples": ("[test]", "samples = 3\n[test]"),
    "rate of what": ("laboratory_rate = 1e-6", 'laboratory_rate = "5 %"'),
    "no layer": ("[[layer]]", "[other]"),
    "a column of another name": ("[test]", '[test]\ncolumns = { tip = "cone" }'),
}


def test_the_schema_is_one() -> None:
    Draft202012Validator.check_schema(site_schema())


@pytest.mark.parametrize("change", VALID)
def test_the_schema_and_the_reader_take_the_same(tmp_path: Path, change: str) -> None:
    text = WHOLE.replace(*VALID[change], 1)
    (tmp_path / "site.toml").write_text(text)
    load_site(tmp_path / "site.toml")
    assert list(SCHEMA.iter_errors(tomllib.loads(text))) == []


@pytest.mark.parametrize("change", INVALID)
def test_the_schema_and_the_reader_refuse_the_same(tmp_path: Path, change: str) -> None:
    text = WHOLE.replace(*INVALID[change], 1)
    assert text != WHOLE
    (tmp_path / "site.toml").write_text(text)
    with pytest.raises(StudyError):
        load_site(tmp_path / "site.toml")
    assert not SCHEMA.is_valid(tomllib.loads(text))


def test_a_new_site_file_is_valid_and_every_key_of_it_is_described(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(site_text("test.csv", {"area_ratio": 0.8}))
    assert SCHEMA.is_valid(tomllib.loads(path.read_text()))
    assert {"adhesion_factor", "K0", "rate_factor"} <= set(load_site(path).layers[0].assumed)
    assert max(map(len, path.read_text().splitlines())) <= 100
    assert main(["describe", str(path)]) == 0
    told = capsys.readouterr().out
    named = [line.split()[0] for line in told.splitlines()[2:] if line and line[0] not in " ["]
    assert [*SITE_KEYS, *TEST_KEYS, *LAYER_KEYS, "an"] == named
    assert "rigidity_index     { low = 50, high = 300 }" in told
    assert "5 %: 54.7, 50 %: 122, 95 %: 274" in told  # uniform in the logarithm


def test_a_damaged_site_file_is_described_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(WHOLE.replace("= 120", "= 5000"))
    assert main(["describe", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "rigidity_index = 5000: must be a number >= 15 and <= 1000" in line


def test_the_schema_of_sites_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "site"]) == 0
    assert json.loads(capsys.readouterr().out) == site_schema()
