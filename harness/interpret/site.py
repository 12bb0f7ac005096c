"""The file of a site: what was measured, and what is known of each layer; data, nothing is run.

    title = "Site A, CPT 3"
    [test]
    file = "cpt3.csv"
    area_ratio = 0.8
    water_level = 1.0
    unit_weight = 16.5
    [[layer]]
    from = 2.0
    to = 18.0
    rigidity_index = { low = 50, high = 300 }
    adhesion_factor = "sleeve"

`TEST_KEYS` and `LAYER_KEYS` are all keys, with their meaning; everything that checks or explains a
file of a site reads them there.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from harness.interpret.factors import TABLE_RATE
from harness.interpret.inputs import HOW, Input, read_input, refuse_both
from harness.study.files import read_toml
from harness.study.tables import StudyError, Table
from mpm_warp.arguments import NOT_NEGATIVE, POSITIVE, Range

MEASURES = ("tip", "sleeve", "pore_pressure")
"""What of a test may tell of the soil."""
BY_SLEEVE = "sleeve"
"""Value of the adhesion factor that takes it from the sleeve friction at each depth."""
MODES = ("isotropic", "simple_shear", "triaxial_compression", "triaxial_extension", "average")
"""What the strength that is wanted is the strength in; isotropic: the one of the simulation."""
ACCURACY: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "class 1": {"qc": (35e3, 0.05), "fs": (5e3, 0.10), "u2": (10e3, 0.02)},
    "class 2": {"qc": (100e3, 0.05), "fs": (15e3, 0.15), "u2": (25e3, 0.03)},
    "class 3": {"qc": (200e3, 0.05), "fs": (25e3, 0.15), "u2": (50e3, 0.05)},
}
"""Allowed errors by class of EN ISO 22476-1:2012 as commonly quoted: [Pa], or a share of the value
where that is more; taken as half widths of 95 %, the same along the whole test."""
SAMPLES, MOST_SAMPLES = 2048, 65536
"""Combinations of the inputs that are drawn."""
LARGEST_DEPTH = 1000.0


@dataclass(frozen=True)
class Key:
    """A key of the file: its meaning with unit and default, and what a number may be."""

    meaning: str
    allowed: Range | None = None


TEST_KEYS: Mapping[str, Key] = {
    "file": Key("the measured test: CSV with units in its header, as qc [MPa]"),
    "columns": Key("names of the columns depth, qc, fs, u2 in the file, where they are others"),
    "units": Key("units of these columns, where the header has none"),
    "missing": Key("numbers that stand for no value, [-999.0] say"),
    "pre_drilled": Key("depth that was bored beforehand [m] (default: 0)", NOT_NEGATIVE),
    "area_ratio": Key(
        "net area ratio of the cone; 1 where qc is corrected", Range(above=0, maximum=1)
    ),
    "water_level": Key("depth of the ground water [m]; below it pressure is hydrostatic", Range()),
    "u0": Key("water pressure by depth instead: { depth = [..], value = [..] } [m], [kPa]"),
    "unit_weight": Key(
        "[kN/m3]: an input, or { depth = [..], value = [..] }", Range(above=0, maximum=30)
    ),
    "accuracy": Key("class 1, class 2, class 3, or { qc, fs, u2 } [kPa], half widths of 95 %"),
}
LAYER_KEYS: Mapping[str, Key] = {
    "title": Key("what it is called"),
    "from": Key("depth of its top [m]", NOT_NEGATIVE),
    "to": Key("depth of its bottom [m]", POSITIVE),
    "rigidity_index": Key("G / su: an input", Range(minimum=15, maximum=1000)),
    "adhesion_factor": Key(
        'an input, or "sleeve": by fs at each depth', Range(minimum=0, maximum=1)
    ),
    "K0": Key("effective horizontal over vertical stress: an input", Range(above=0, maximum=5)),
    "stress_anisotropy": Key("Delta instead of K0: an input", Range(minimum=-0.6, maximum=0.9)),
    "rate_factor": Key(
        "what a log cycle of rate adds to su, over it: an input", Range(minimum=0, maximum=0.25)
    ),
    "laboratory_rate": Key(
        'strain rate at which su is wanted, "5 %/h" or in 1/s',
        Range(minimum=TABLE_RATE, maximum=1e-2),
    ),
    "sensitivity": Key("intact over remoulded strength: an input", Range(minimum=1, maximum=25)),
    "ductility": Key(
        "plastic shear strain of 95 % of that loss: an input", Range(minimum=5, maximum=60)
    ),
    "strength": Key("what su is wanted in: " + ", ".join(MODES)),
    "simple_shear_ratio": Key(
        "su in simple shear over compression: an input", Range(above=0, maximum=1.2)
    ),
    "extension_ratio": Key(
        "su in extension over compression: an input", Range(above=0, maximum=1.2)
    ),
    "model_error": Key(
        "what the simulation leaves out, a deviation over Nkt", Range(minimum=0, maximum=1)
    ),
}
DEFAULTS: Mapping[str, object] = {
    "adhesion_factor": {"low": 0.2, "high": 0.8},
    "K0": {"low": 0.5, "high": 0.8},
    "rate_factor": {"mean": 0.1, "deviation": 0.03},
    "laboratory_rate": "1 %/h",
    "sensitivity": {"low": 1.5, "high": 6.0},
    "ductility": {"low": 10, "high": 50},
    "strength": MODES[0],
    "simple_shear_ratio": {"low": 0.6, "high": 0.9},
    "extension_ratio": {"low": 0.35, "high": 0.7},
    "model_error": 0.1,
}
"""What a layer has that says nothing: what ordinary clay may be."""
INPUTS = ("rigidity_index", "rate_factor", "sensitivity", "ductility")
"""Inputs of a layer that are the same at all its depths."""


@dataclass(frozen=True, eq=False)
class ByDepth:
    """Values by depth, linear between; both in SI units."""

    depth: tuple[float, ...]
    value: tuple[float, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredTest:
    """What the table [test] says, in SI units; see `TEST_KEYS`.

    Attributes:
        unit_weight: one for all depths, in N/m3, where it is an input.
    """

    file: Path
    columns: Mapping[str, str]
    units: Mapping[str, str]
    missing: tuple[float, ...]
    pre_drilled: float
    area_ratio: float
    water: float | ByDepth
    unit_weight: Input | ByDepth
    accuracy: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Layer:
    """What a table [[layer]] says, in SI units; see `LAYER_KEYS`.

    Attributes:
        inputs: all that are drawn, by name; the adhesion factor is missing where the sleeve tells
            it. Of K0 and stress_anisotropy it has one.
        laboratory_rate: shear strain rate at which the strength is wanted [1/s].
        strength: the mode that it is wanted in, one of `MODES`.
        assumed: keys that the file leaves to their defaults.
    """

    title: str
    top: float
    bottom: float
    inputs: Mapping[str, Input]
    laboratory_rate: float
    strength: str
    model_error: float
    assumed: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Site:
    """A file of a site.

    Attributes:
        name: of the file, and of what is written.
        use: of `MEASURES`, what tells of the soil.
        samples, seed: how many combinations of the inputs are drawn, and by which random numbers.
    """

    name: str
    title: str
    test: MeasuredTest
    layers: tuple[Layer, ...]
    use: tuple[str, ...] = MEASURES[:1]
    samples: int = SAMPLES
    seed: int = 1


def load_site(path: Path) -> Site:
    """A site of its file.

    Raises:
        StudyError: something in it is wrong; the message names file, key and what is allowed.
    """
    if not path.is_file():
        raise StudyError(
            f"{path}: no such file; `harness new NAME --interpret TEST.csv` writes one"
        )
    whole = Table(f"{path}:", read_toml(path))
    whole.allow("title", "use", "samples", "seed", "test", "layer")
    use = whole.list("use") or [MEASURES[0]]
    if use[0] != MEASURES[0] or any(it not in MEASURES for it in use):
        raise whole.refuse("use", f"must be a list of {', '.join(MEASURES)}, the tip first")
    layers = whole.list("layer")
    if not layers or not all(isinstance(it, dict) for it in layers):
        raise StudyError(f"{path}: [[layer]] is missing: from, to and rigidity_index of the clay")
    read = [_layer(Table(f"{path}: [[layer]] {n}", it)) for n, it in enumerate(layers, start=1)]
    for above, below in itertools.pairwise(read):
        if below.top < above.bottom:
            raise StudyError(
                f"{path}: [[layer]] from = {below.top:g}: lies above {above.bottom:g}, the bottom "
                "of the layer before"
            )
    counts = Table(whole.where, {"samples": SAMPLES, "seed": 1, **whole.values})
    return Site(
        name=path.stem,
        title=whole.text("title", ', as title = "Site A, CPT 3"'),
        test=_test(whole.table("test"), path.parent),
        layers=tuple(read),
        use=tuple(use),
        samples=counts.integer("samples", 64, MOST_SAMPLES),
        seed=counts.integer("seed", 0, 2**31),
    )


def _test(table: Table, folder: Path) -> MeasuredTest:
    table.allow(*TEST_KEYS)
    file = folder / table.text("file", ", the measured test")
    if "area_ratio" not in table.values:
        raise StudyError(
            f"{table.where} area_ratio: is missing; it stands on the cone's calibration sheet, "
            "0.55 to 0.9; 1 where the file holds corrected resistances"
        )
    for key in ("water_level", "unit_weight"):
        if key not in table.values and not (key == "water_level" and "u0" in table.values):
            raise StudyError(f"{table.where} {key}: is missing; {TEST_KEYS[key].meaning}")
    refuse_both(table, "water_level", "u0")
    missing = table.list("missing")
    weight = table.values["unit_weight"]
    by_depth = isinstance(weight, dict) and "depth" in weight
    return MeasuredTest(
        file=file,
        columns=_texts(table, "columns"),
        units=_texts(table, "units"),
        missing=tuple(_finite(table, "missing", it) for it in missing),
        pre_drilled=_number(table, "pre_drilled", 0.0),
        area_ratio=_number(table, "area_ratio", 1.0),
        water=_by_depth(table, "u0", 1e3)
        if "u0" in table.values
        else _number(table, "water_level", 0.0),
        unit_weight=_by_depth(table, "unit_weight", 1e3)
        if by_depth
        else _in_kilo(read_input(table, "unit_weight", _range(TEST_KEYS, "unit_weight"))),
        accuracy=_accuracy(table),
    )


def _layer(table: Table) -> Layer:
    table.allow(*LAYER_KEYS)
    for key in ("from", "to", "rigidity_index"):
        if key not in table.values:
            raise StudyError(f"{table.where} {key}: is missing; {LAYER_KEYS[key].meaning}")
    refuse_both(table, "K0", "stress_anisotropy")
    top, bottom = (_number(table, key, 0.0, LAYER_KEYS) for key in ("from", "to"))
    if not top < bottom <= LARGEST_DEPTH:
        raise table.refuse("to", f"must be > {top:g}, where it begins, and <= {LARGEST_DEPTH:g}")
    given = {**DEFAULTS, **table.values}
    if "stress_anisotropy" in given:
        given.pop("K0")
    full = Table(table.where, given)
    names = [
        name
        for name in (*INPUTS, "adhesion_factor", "K0", "stress_anisotropy")
        if name in given and given[name] != BY_SLEEVE
    ]
    strength = full.word("strength", MODES) if "strength" in given else MODES[0]
    if strength != MODES[0]:
        names += ["simple_shear_ratio", "extension_ratio"]
    return Layer(
        title=table.text("title", "") if "title" in table.values else f"{top:g} to {bottom:g} m",
        top=top,
        bottom=bottom,
        inputs={name: read_input(full, name, _range(LAYER_KEYS, name)) for name in names},
        laboratory_rate=_rate(full),
        strength=strength,
        model_error=_number(full, "model_error", 0.0, LAYER_KEYS),
        assumed=tuple(it for it in given if it not in table.values),
    )


def _range(keys: Mapping[str, Key], name: str) -> Range:
    allowed = keys[name].allowed
    assert allowed is not None
    return allowed


def _finite(table: Table, key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise table.refuse(key, "must be a number")
    return float(value)


def _number(table: Table, key: str, default: float, keys: Mapping[str, Key] = TEST_KEYS) -> float:
    if key not in table.values:
        return default
    value = _finite(table, key, table.values[key])
    allowed = _range(keys, key)
    if not allowed.holds(value, value):
        raise table.refuse(key, f"must be {allowed.allowed}; {keys[key].meaning}")
    return value


def _texts(table: Table, key: str) -> dict[str, str]:
    own = table.table(key)
    own.allow("depth", "qc", "fs", "u2")
    return {name: own.text(name, "") for name in own.values}


def _by_depth(table: Table, key: str, unit: float) -> ByDepth:
    own = table.table(key)
    own.allow("depth", "value")
    depth, value = ([_finite(own, it, x) for x in own.list(it)] for it in ("depth", "value"))
    if not depth or len(depth) != len(value) or depth != sorted(depth):
        raise table.refuse(key, "must be { depth = [..], value = [..] }, as many of each, downward")
    return ByDepth(tuple(depth), tuple(unit * it for it in value))


def _in_kilo(given: Input) -> Input:
    return Input(given.text, lambda share: 1e3 * given.quantiles(share), given.is_known)


def _accuracy(table: Table) -> Mapping[str, tuple[float, float]]:
    value = table.values.get("accuracy", "class 2")
    if isinstance(value, str):
        return ACCURACY[table.word("accuracy", ("class 2", *ACCURACY)) if value else "class 2"]
    own = table.table("accuracy")
    own.allow("qc", "fs", "u2")
    numbers = {name: _finite(own, name, it) for name, it in own.values.items()}
    if len(numbers) < 3 or min(numbers.values()) < 0.0:
        raise table.refuse("accuracy", "must have qc, fs and u2, each a number >= 0 [kPa]")
    return {name: (1e3 * it, 0.0) for name, it in numbers.items()}


def _rate(table: Table) -> float:
    """A strain rate [1/s]."""
    value, allowed = table.values["laboratory_rate"], _range(LAYER_KEYS, "laboratory_rate")
    found = re.fullmatch(r"([\d.]+) ?%/(s|min|h)", value) if isinstance(value, str) else None
    if found:
        value = 0.01 * float(found[1]) / {"s": 1.0, "min": 60.0, "h": 3600.0}[found[2]]
    if isinstance(value, (str, bool)) or not isinstance(value, (int, float)):
        raise table.refuse("laboratory_rate", 'must be a text as "5 %/h", or a number in 1/s')
    if not allowed.holds(value, value):
        raise table.refuse("laboratory_rate", f"is {value:.2g} 1/s, must be {allowed.allowed}")
    return float(value)


def site_text(test: str) -> str:
    """A site file for a measured test, explained key by key; it is to be edited."""
    given = {"file": f'"{test}"', "water_level": "1.0", "unit_weight": "17.0"}
    layer = {"from": "2.0", "to": "10.0", "rigidity_index": "{ low = 50, high = 300 }"}
    inputs = {name: _as_toml(value) for name, value in DEFAULTS.items()}

    def rows(keys: Mapping[str, Key], set_by: Mapping[str, str]) -> list[str]:
        """A row a key; what is not set stands behind a #."""
        return [
            f"{name} = {set_by[name]}  # {key.meaning}"
            if name in set_by
            else f"# {name}: {key.meaning}"
            for name, key in keys.items()
        ]

    lines = [
        "# A measured cone test and its ground. An input is " + HOW + ".",
        "# area_ratio must be given: it stands on the calibration sheet of the cone.",
        'title = "My site"',
        'use = ["tip"]  # what tells of the soil: tip, sleeve, pore_pressure',
        "",
        "[test]",
        *rows(TEST_KEYS, given),
        "",
        "[[layer]]  # as many as there are layers of undrained clay",
        *rows(LAYER_KEYS, layer | inputs),
    ]
    return "\n".join(lines) + "\n"


def _as_toml(value: object) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{name} = {it}" for name, it in value.items()) + " }"
    return f'"{value}"' if isinstance(value, str) else str(value)
