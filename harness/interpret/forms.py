"""Forms of the values in a site file: by depth, errors of the test, texts, rates."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from harness.study.distributions import INPUT, Input
from harness.study.tables import LINE, is_number, table_schema
from mpm_warp.fields.declaration import Form, Parameter, Refused, Schema, bounds_schema
from mpm_warp.fields.names import did_you_mean, nearest_name

WATER = 9.81e3
"""Unit weight of water [N/m3]."""
COLUMNS = ("depth", "qc", "fs", "u2")
"""Quantities that are read from a test file."""
AXES = ("inclination", "inclination_across")
"""Optional quantities: the inclination of the cone, or those in two planes at right angles."""
MEASURES = ("tip", "sleeve", "pore_pressure")
"""Measurements by which strength may be found."""
ACCURACY: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "class 1": {"qc": (35e3, 0.05), "fs": (5e3, 0.10), "u2": (10e3, 0.02)},
    "class 2": {"qc": (100e3, 0.05), "fs": (15e3, 0.15), "u2": (25e3, 0.03)},
    "class 3": {"qc": (200e3, 0.05), "fs": (25e3, 0.15), "u2": (50e3, 0.05)},
}
"""Allowed errors by class of EN ISO 22476-1:2012 as commonly quoted: the larger of a value in Pa
and a share of the reading. They are taken as half widths of 95 %, constant along the test."""
RATE_TEXT = r"(\d+\.?\d*) ?%/(s|min|h)"
"""Pattern of a strain rate that is written as text."""
NUMBER: Schema = {"type": "number"}


@dataclass(frozen=True, eq=False)
class ByDepth:
    """Values by depth, linear in between; both in SI units."""

    depth: tuple[float, ...]
    value: tuple[float, ...]


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def _numbers(values: object, field: Parameter) -> tuple[float, ...]:
    if not isinstance(values, list) or not all(map(is_number, values)):
        raise Refused("must be a list of numbers")
    return tuple(map(float, values))


def _by_depth(given: Any, field: Parameter) -> ByDepth:
    form = Refused("must be { depth = [..], value = [..] }, as many numbers of each, downward")
    if not isinstance(given, dict) or given.keys() != {"depth", "value"}:
        raise form
    depth, value = (_numbers(given[name], field) for name in ("depth", "value"))
    if not depth or len(depth) != len(value) or list(depth) != sorted(depth):
        raise form
    if not field.bounds.holds(min(value), max(value)):
        raise Refused(f"must be {field.bounds.allowed} at all depths")
    return ByDepth(depth, tuple(1e3 * number for number in value))


def _weight(given: Any, field: Parameter) -> Input | ByDepth:
    if isinstance(given, dict) and "depth" in given:
        return _by_depth(given, field)
    read = INPUT.read(given, field)
    return Input(read.text, lambda share: 1e3 * read.quantiles(share))


def _accuracy(given: Any, field: Parameter) -> Mapping[str, tuple[float, float]]:
    if isinstance(given, str):
        if given not in ACCURACY:
            raise Refused(f"must be {field.allowed}{did_you_mean(given, ACCURACY)}")
        return ACCURACY[given]
    names, numbers = COLUMNS[1:], given.values() if isinstance(given, dict) else ()
    if set(given) != set(names) or not all(is_number(it) and it >= 0.0 for it in numbers):
        raise Refused("must have qc, fs and u2, each a number >= 0 [kPa]")
    return {name: (1e3 * given[name], 0.0) for name in names}


def _texts(given: Any, field: Parameter) -> dict[str, str]:
    if not isinstance(given, dict):
        raise Refused(f"must be {field.allowed}")
    for name in given:
        if name not in (*COLUMNS, *AXES):
            raise Refused(f"unknown key {name!r}{nearest_name(name, (*COLUMNS, *AXES))}")
    return {name: LINE.read(text, field) for name, text in given.items()}


def _measures(given: Any, field: Parameter) -> tuple[str, ...]:
    listed = isinstance(given, list | tuple) and all(measure in MEASURES for measure in given)
    if not listed or [*given[:1]] != [MEASURES[0]]:
        raise Refused(f"must be a list of {', '.join(MEASURES)}, the tip first")
    return tuple(given)


def _rate(given: Any, field: Parameter) -> float:
    found = re.fullmatch(RATE_TEXT, given, re.ASCII) if isinstance(given, str) else None
    if found:
        given = 0.01 * float(found[1]) / {"s": 1.0, "min": 60.0, "h": 3600.0}[found[2]]
    if not is_number(given):
        raise Refused('must be a text as "5 %/h", or a number in 1/s')
    if not field.bounds.holds(given, given):
        raise Refused(f"is {given:.2g} 1/s, must be {field.bounds.allowed}")
    return float(given)


def _by_depth_schema(field: Parameter) -> list[Schema]:
    lists = {"depth": _list(NUMBER), "value": _list(NUMBER | bounds_schema(field.bounds))}
    return [table_schema(lists, required=list(lists))]


NUMBERS = Form("a list of numbers", _numbers, lambda field: [_list(NUMBER)])
BY_DEPTH = Form("{ depth = [..], value = [..] }", _by_depth, _by_depth_schema)
WEIGHT = Form(
    f"{BY_DEPTH.words}, or an input",
    _weight,
    lambda field: [*_by_depth_schema(field), *INPUT.schemas(field)],
)
ERRORS = Form(
    "{ qc, fs, u2 } [kPa], half widths of 95 %",
    _accuracy,
    lambda field: [
        table_schema(
            {name: {**NUMBER, "minimum": 0} for name in COLUMNS[1:]}, required=[*COLUMNS[1:]]
        )
    ],
)
TEXTS = Form(
    f"{{ {', '.join((*COLUMNS, *AXES))} }}, each a text",
    _texts,
    lambda field: [table_schema({name: LINE.schemas(field)[0] for name in (*COLUMNS, *AXES)})],
)
WORDS = Form(
    f"a list of {', '.join(MEASURES)}", _measures, lambda field: [_list({"enum": list(MEASURES)})]
)
RATE = Form(
    'a text as "5 %/h", or a number',
    _rate,
    lambda field: [
        {"type": "string", "pattern": f"^{RATE_TEXT}$"},
        NUMBER | bounds_schema(field.bounds),
    ],
)
