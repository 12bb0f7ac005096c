"""Site files: text of a new one, description of an existing one, and their JSON schema.

All three are made from the declared fields in site.py.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from harness.interpret.forms import WEIGHT
from harness.interpret.laboratory import MOST_TESTS, LaboratoryTest
from harness.interpret.site import Layer, MeasuredTest, Site, load_site
from harness.study.description import assignment, comment, template, toml
from harness.study.distributions import HOW, INPUT
from harness.study.files import read_toml
from harness.study.schema import DIALECT
from harness.study.tables import StudyError, schema_of
from mpm_warp.fields.declaration import Parameter, Schema
from mpm_warp.fields.flat import parameters_of

SITE_KEYS, TEST_KEYS, LAYER_KEYS, LABORATORY_KEYS = (
    tuple(parameters_of(owner).values()) for owner in (Site, MeasuredTest, Layer, LaboratoryTest)
)
PERCENTILES = 5, 50, 95
"""Percentiles that describe a distribution."""


def site_text(test: str, told: Mapping[str, float], soundings: Sequence[str] = ()) -> str:
    """A new site file for a test, to be edited; each key has a comment.

    `told` has values from the test file, and a comment says so. Several `soundings` are listed, to
    choose one of them.
    """
    layer = {"from": 2.0, "to": 10.0, "rigidity_index": {"low": 50, "high": 300}}
    sample = {"depth": 5.0, "strength": 20.0, "test": "CAUC"}
    by_file = {assignment(*pair): f"{assignment(*pair)}  # by {test}" for pair in told.items()}
    rows = [by_file.get(row, row) for row in template(TEST_KEYS, {"file": test, **told})]
    if soundings:
        at = rows.index("#sounding = ...")
        rows[at : at + 1] = [f"#{assignment('sounding', name)}" for name in soundings]
    lines = [
        "# A measured cone test and its ground. Lines that begin with # are comments; values in",
        "# them are assumed, and the result says so. Remove the # to give what is known here.",
        comment(f"An input is {HOW}."),
        "",
        *template(SITE_KEYS, {"title": "My site"}),
        "",
        "[test]",
        *rows,
        "",
        "# One table for each layer of undrained clay.",
        "[[layer]]",
        *template(LAYER_KEYS, layer),
        "",
        "# A table for each test of a laboratory, or a CSV with these columns: --laboratory FILE.",
        "#[[laboratory]]",
        *(row if row.startswith("#") else f"#{row}" for row in template(LABORATORY_KEYS, sample)),
    ]
    return "\n".join(lines) + "\n"


def is_site_file(name: str) -> bool:
    """Whether a file is a site file: TOML with a table [test]."""
    path = Path(name)
    if path.suffix != ".toml" or not path.is_file():
        return False
    try:
        return "test" in read_toml(path)
    except StudyError:
        return False


def site_rows(path: Path) -> list[str]:
    """Description of a site file: each key with its value and meaning."""
    site, values = load_site(path), read_toml(path)
    rows = [f"{path}: {site.title}", "", *_told_rows(SITE_KEYS, values)]
    rows += ["", "[test]", *_told_rows(TEST_KEYS, values["test"])]
    for layer in values["layer"]:
        rows += ["", "[[layer]]", *_told_rows(LAYER_KEYS, layer)]
    for test in values.get("laboratory", []):
        rows += ["", "[[laboratory]]", *_told_rows(LABORATORY_KEYS, test)]
    return [*rows, "", f"an input is {HOW}"]


def test_rows(path: Path) -> list[tuple[str, str, str]]:
    """Key, value and meaning of all that has a value in the top part and [test] of a site file."""
    values = read_toml(path)
    stated = [*_stated(SITE_KEYS, values), *_stated(TEST_KEYS, values["test"])]
    return [
        (key.name, text, f"{key.meaning}{key.in_unit}")
        for key, value, text in stated
        if value is not None
    ]


def _stated(
    declared: Iterable[Parameter], given: Mapping[str, Any]
) -> Iterator[tuple[Parameter, Any, str]]:
    """Each key of a table, its value and its text."""
    for key in declared:
        value = given.get(key.name, None if key.is_required else key.default)
        default = "" if key.name in given else "default "
        yield key, value, "-" if value is None else f"{default}{toml(value)}"


def _told_rows(declared: Iterable[Parameter], given: Mapping[str, Any]) -> Iterator[str]:
    """A row for each key, and one more for a distribution."""
    for key, value, text in _stated(declared, given):
        yield f"{key.name:18} {text:36} {key.explanation}"
        if isinstance(value, dict) and key.form in (INPUT, WEIGHT) and "depth" not in value:
            shares = np.array(PERCENTILES) / 100.0
            ends = INPUT.read(value, key).quantiles(shares)
            pairs = zip(PERCENTILES, ends, strict=True)
            yield f"{'':18} {', '.join(f'{percent} %: {end:.3g}' for percent, end in pairs)}"


def site_schema() -> Schema:
    """The JSON schema of a site file."""
    test, layer = schema_of(TEST_KEYS), schema_of(LAYER_KEYS)
    test["not"] = {"required": ["water_level", "u0"]}
    layer["not"] = {"required": ["K0", "stress_anisotropy"]}
    tables = {
        "layer": {"type": "array", "items": layer, "minItems": 1},
        "laboratory": {
            "type": "array",
            "items": schema_of(LABORATORY_KEYS),
            "maxItems": MOST_TESTS,
        },
    }
    whole = schema_of(SITE_KEYS, test=test, **tables)
    whole["required"] += ["test", "layer"]
    return {"$schema": DIALECT, "title": "Site of the harness", **whole}
