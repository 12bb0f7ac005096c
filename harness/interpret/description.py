"""Site files: text of a new one, description of an existing one, and their JSON schema.

All three are made from the keys in keys.py.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from harness.interpret.keys import AXES, COLUMNS, LAYER_KEYS, RATE, SITE_KEYS, TEST_KEYS, Form, Key
from harness.interpret.site import load_site
from harness.study.description import assignment, comment, toml
from harness.study.distributions import HOW, read_input
from harness.study.files import read_toml
from harness.study.schema import DIALECT, LINE, Schema, bounds_schema, distributions, table_schema
from harness.study.tables import StudyError, Table

PERCENTILES = 5, 50, 95
"""Percentiles that describe a distribution."""


def site_text(test: str, told: Mapping[str, float], soundings: Sequence[str] = ()) -> str:
    """A new site file for a test, to be edited; each key has a comment.

    `told` has values from the test file. Several `soundings` are listed, to choose one of them.
    """
    given = {"file": test, "water_level": 1.0, "unit_weight": 17.0, **told}
    layer = {"from": 2.0, "to": 10.0, "rigidity_index": {"low": 50, "high": 300}}
    rows = _key_rows(TEST_KEYS, given)
    if soundings:
        at = rows.index("#sounding = ...")
        rows[at : at + 1] = [f"#{assignment('sounding', name)}" for name in soundings]
    lines = [
        "# A measured cone test and its ground. Lines that begin with # are comments; values in",
        "# them are assumed, and the result says so. Remove the # to give what is known here.",
        comment(f"An input is {HOW}."),
        "",
        *_key_rows(SITE_KEYS, {"title": "My site"}),
        "",
        "[test]",
        *rows,
        "",
        "# One table for each layer of undrained clay.",
        "[[layer]]",
        *_key_rows(LAYER_KEYS, layer),
    ]
    return "\n".join(lines) + "\n"


def _key_rows(keys: Mapping[str, Key], given: Mapping[str, object]) -> list[str]:
    """A comment on each key, and its value; if none is given, its default or dots as a comment."""
    rows = []
    for name, key in keys.items():
        default = f"#{name} = ..." if key.default is None else f"#{assignment(name, key.default)}"
        row = assignment(name, given[name]) if name in given else default
        rows += [comment(key.description), row]
    return rows


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
    return [*rows, "", f"an input is {HOW}"]


def test_rows(path: Path) -> list[tuple[str, str, str]]:
    """Key, value and meaning of all that has a value in the top part and [test] of a site file."""
    values = read_toml(path)
    stated = [*_stated(SITE_KEYS, values), *_stated(TEST_KEYS, values["test"])]
    return [
        (name, text, f"{key.meaning}{key.in_unit}")
        for name, key, value, text in stated
        if value is not None
    ]


def _stated(
    keys: Mapping[str, Key], given: Mapping[str, Any]
) -> Iterator[tuple[str, Key, Any, str]]:
    """Name, key, value and its text for each key of a table."""
    for name, key in keys.items():
        value = given.get(name, key.default)
        default = "" if name in given else "default "
        yield name, key, value, "-" if value is None else f"{default}{toml(value)}"


def _told_rows(keys: Mapping[str, Key], given: Mapping[str, Any]) -> Iterator[str]:
    """A row for each key, and one more for a distribution."""
    for name, key, value, text in _stated(keys, given):
        yield f"{name:18} {text:36} {key.description}"
        if isinstance(value, dict) and Form.INPUT in key.forms and "depth" not in value:
            shares = np.array(PERCENTILES) / 100.0
            ends = read_input(Table("", {name: value}), name, key.allowed).quantiles(shares)
            pairs = zip(PERCENTILES, ends, strict=True)
            yield f"{'':18} {', '.join(f'{percent} %: {end:.3g}' for percent, end in pairs)}"


def site_schema() -> Schema:
    """The JSON schema of a site file."""
    test, layer = _table_of(TEST_KEYS), _table_of(LAYER_KEYS)
    test["required"].remove("water_level")
    test["oneOf"] = [{"required": ["water_level"]}, {"required": ["u0"]}]
    layer["not"] = {"required": ["K0", "stress_anisotropy"]}
    whole = _table_of(SITE_KEYS)
    whole["properties"] |= {"test": test, "layer": {"type": "array", "items": layer, "minItems": 1}}
    whole["required"] += ["test", "layer"]
    return {"$schema": DIALECT, "title": "Site of the harness", **whole}


def _table_of(keys: Mapping[str, Key]) -> Schema:
    required = [name for name, key in keys.items() if key.required]
    return table_schema({name: _of_key(key) for name, key in keys.items()}, required=required)


def _of_key(key: Key) -> Schema:
    forms = [schema for form in key.forms for schema in _of_form(form, key)]
    if key.choices and Form.WORDS not in key.forms:
        forms.append({"enum": list(key.choices)})
    default = {} if key.default is None else {"default": key.default}
    return {"description": key.description, "anyOf": forms} | default


def _of_form(form: Form, key: Key) -> list[Schema]:
    """The schemas of what a value of such a form may be."""
    number: Schema = {"type": "number"}
    within = number | bounds_schema(key.allowed)
    by_depth = {"depth": _list(number), "value": _list(within)}
    errors = dict.fromkeys(COLUMNS[1:], number | {"minimum": 0})
    return {
        Form.TEXT: [LINE],
        Form.NUMBER: [within],
        Form.INTEGER: [within | {"type": "integer"}],
        Form.INPUT: [within, *distributions()],
        Form.BY_DEPTH: [table_schema(by_depth, required=list(by_depth))],
        Form.NUMBERS: [_list(number)],
        Form.WORDS: [_list({"enum": list(key.choices)})],
        Form.TEXTS: [table_schema(dict.fromkeys((*COLUMNS, *AXES), LINE))],
        Form.ERRORS: [table_schema(errors, required=list(errors))],
        Form.RATE: [{"type": "string", "pattern": f"^{RATE}$"}],
    }[form]


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}
