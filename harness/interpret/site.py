"""Site files: the measured test, and what is known of each layer.

The keys are explained in keys.py; README.md has an example.
"""

import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.interpret import keys
from harness.interpret.keys import LAYER_KEYS, SITE_KEYS, TEST_KEYS, Form, Key
from harness.study.distributions import Input, read_input
from harness.study.files import read_toml
from harness.study.tables import StudyError, Table, is_number
from mpm_warp.grid.fitted import Floats, Integers


@dataclass(frozen=True, eq=False)
class ByDepth:
    """Values by depth, linear in between; both in SI units."""

    depth: tuple[float, ...]
    value: tuple[float, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredTest:
    """Values of the table [test] in SI units, see `TEST_KEYS`; None if they are not given."""

    where: str  # the site file and its table, for messages
    file: Path
    sounding: str | None
    columns: Mapping[str, str]
    units: Mapping[str, str]
    missing: tuple[float, ...] | None  # codes besides those in the test file; (): there are none
    ground_level: float | None
    pre_drilled: float | None
    area_ratio: float | None
    cone_area: float | None  # [cm2]
    water: float | ByDepth
    unit_weight: Input | ByDepth  # an input is the same at all depths
    accuracy: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Layer:
    """Values of a table [[layer]] in SI units; see `LAYER_KEYS`."""

    title: str
    top: float
    bottom: float
    # K0 or stress_anisotropy is among them; the adhesion factor is not if it is by the sleeve
    inputs: Mapping[str, Input]
    laboratory_rate: float  # shear strain rate of the strength to be found [1/s]
    strength: str  # its mode, one of `MODES`
    model_error: float
    assumed: tuple[str, ...] = ()  # keys that have their defaults


@dataclass(frozen=True, kw_only=True, eq=False)
class Site:
    """A site file; see `SITE_KEYS`."""

    name: str  # of the file without its ending, and of the results
    title: str
    test: MeasuredTest
    layers: tuple[Layer, ...]
    use: tuple[str, ...]
    samples: int
    seed: int

    def layer_at(self, depth: Floats) -> Integers:
        """Index of the layer at depths [m], the lower one on a border; -1 if none, shape [n]."""
        numbers = np.full(len(depth), -1)
        for number, layer in enumerate(self.layers):
            numbers[(depth >= layer.top) & (depth <= layer.bottom)] = number
        return numbers

    @property
    def borders(self) -> list[float]:
        """Depths of the borders of its layers [m], downward."""
        return sorted({depth for layer in self.layers for depth in (layer.top, layer.bottom)})


def load_site(path: Path) -> Site:
    """A site from its file; a `StudyError` names file, key and what is allowed."""
    if not path.is_file():
        raise StudyError(f"{path}: no such file; `harness new NAME --interpret TEST` writes one")
    values = read_toml(path)
    if "scene" in values and "test" not in values:
        raise StudyError(f"{path}: is a study; `harness run {path}` runs it")
    whole = _filled(Table(f"{path}:", values), SITE_KEYS, "test", "layer")
    use = whole.list("use")
    if use[:1] != [keys.MEASURES[0]] or any(measure not in keys.MEASURES for measure in use):
        raise whole.refuse("use", f"must be a list of {', '.join(keys.MEASURES)}, the tip first")
    layers = whole.list("layer")
    if not layers or not all(isinstance(layer, dict) for layer in layers):
        raise StudyError(f"{path}: [[layer]] is missing: from, to and rigidity_index of the clay")
    read = [
        _layer(Table(f"{path}: [[layer]] {n}", layer)) for n, layer in enumerate(layers, start=1)
    ]
    titles = [layer.title for layer in read]
    for number, title in enumerate(titles, start=1):
        if title in titles[: number - 1]:
            raise StudyError(f"{path}: [[layer]] {number} title = {title!r}: another layer has it")
    for above, below in itertools.pairwise(read):
        if below.top < above.bottom:
            raise StudyError(
                f"{path}: [[layer]] from = {below.top:g}: lies above {above.bottom:g}, the bottom "
                "of the layer before"
            )
    return Site(
        name=path.stem,
        title=whole.text("title"),
        test=_test(whole.table("test"), path.parent),
        layers=tuple(read),
        use=tuple(use),
        samples=_integer(whole, "samples"),
        seed=_integer(whole, "seed"),
    )


def _filled(table: Table, known: Mapping[str, Key], *others: str) -> Table:
    """A table with the defaults of its keys; missing and unknown keys are refused."""
    table.allow(*known, *others)
    for name, key in known.items():
        if key.required and name not in table.values:
            raise StudyError(f"{table.where} {name}: is missing; {key.description}")
    defaults = {name: key.default for name, key in known.items() if key.default is not None}
    return Table(table.where, {**defaults, **table.values})


def _test(given: Table, folder: Path) -> MeasuredTest:
    _refuse_both(given, "water_level", "u0")
    in_place = {"water_level": 0.0} if "u0" in given.values else {}
    table = _filled(Table(given.where, {**in_place, **given.values}), TEST_KEYS)
    weight = table.values["unit_weight"]
    return MeasuredTest(
        where=table.where,
        file=folder / table.text("file"),
        sounding=table.text("sounding") if "sounding" in table.values else None,
        columns=_texts(table, "columns"),
        units=_texts(table, "units"),
        missing=tuple(_finite(table, "missing", code) for code in table.list("missing"))
        if "missing" in table.values
        else None,
        ground_level=_optional(table, "ground_level"),
        pre_drilled=_optional(table, "pre_drilled"),
        area_ratio=_optional(table, "area_ratio"),
        cone_area=_optional(table, "cone_area"),
        water=_by_depth(table, "u0")
        if "u0" in table.values
        else _number(table, "water_level", TEST_KEYS),
        unit_weight=_by_depth(table, "unit_weight")
        if isinstance(weight, dict) and "depth" in weight
        else _in_kilo(read_input(table, "unit_weight", TEST_KEYS["unit_weight"].allowed)),
        accuracy=_accuracy(table),
    )


def _layer(given: Table) -> Layer:
    _refuse_both(given, "K0", "stress_anisotropy")
    table = _filled(given, LAYER_KEYS)
    top, bottom = (_number(table, key, LAYER_KEYS) for key in ("from", "to"))
    if not top < bottom:
        raise table.refuse(
            "to", f"must be > {top:g}, where it begins, and <= {keys.LARGEST_DEPTH:g}"
        )
    # Values that are not used are checked too.
    inputs = {
        name: read_input(table, name, key.allowed, key.choices)
        for name, key in LAYER_KEYS.items()
        if Form.INPUT in key.forms and table.values.get(name) not in (None, *key.choices)
    }
    strength = table.word("strength", keys.MODES)
    anisotropy = "stress_anisotropy" if "stress_anisotropy" in table.values else "K0"
    names = [*keys.INPUTS, "adhesion_factor", anisotropy]
    if strength != keys.MODES[0]:
        names += ["simple_shear_ratio", "extension_ratio"]
    return Layer(
        title=table.text("title") if "title" in table.values else f"{top:g} to {bottom:g} m",
        top=top,
        bottom=bottom,
        inputs={name: inputs[name] for name in names if name in inputs},
        laboratory_rate=_rate(table),
        strength=strength,
        model_error=_number(table, "model_error", LAYER_KEYS),
        assumed=tuple(
            key
            for key in (*names, "laboratory_rate", "strength", "model_error")
            if key not in given.values
        ),
    )


def _refuse_both(table: Table, one: str, other: str) -> None:
    """Refuse a table that has both of two alternative keys."""
    if one in table.values and other in table.values:
        raise StudyError(f"{table.where} {one}: {other} says the same; give one of them")


def _finite(table: Table, key: str, value: object) -> float:
    if not is_number(value):
        raise table.refuse(key, "must be a number")
    return float(value)


def _number(table: Table, key: str, known: Mapping[str, Key]) -> float:
    value, allowed = _finite(table, key, table.values[key]), known[key].allowed
    if not allowed.holds(value, value):
        told = f"{known[key].meaning}{known[key].in_unit}"
        raise table.refuse(key, f"must be {allowed.allowed}; {told}")
    return value


def _optional(table: Table, key: str) -> float | None:
    return _number(table, key, TEST_KEYS) if key in table.values else None


def _integer(table: Table, key: str) -> int:
    allowed = SITE_KEYS[key].allowed
    return table.integer(key, int(allowed.minimum), int(allowed.maximum))


def _texts(table: Table, key: str) -> dict[str, str]:
    own = table.table(key)
    own.allow(*keys.COLUMNS, *keys.AXES)
    return {name: own.text(name, "") for name in own.values}


def _by_depth(table: Table, key: str) -> ByDepth:
    """Values of a key in kN/m3 or kPa, in SI units."""
    own = table.table(key)
    own.allow("depth", "value")
    depth, value = (
        [_finite(own, column, x) for x in own.list(column)] for column in ("depth", "value")
    )
    if not depth or len(depth) != len(value) or depth != sorted(depth):
        raise table.refuse(key, "must be { depth = [..], value = [..] }, as many of each, downward")
    if not TEST_KEYS[key].allowed.holds(min(value), max(value)):
        raise table.refuse(key, f"must be {TEST_KEYS[key].allowed.allowed} at all depths")
    return ByDepth(tuple(depth), tuple(1e3 * number for number in value))


def _in_kilo(given: Input) -> Input:
    return Input(given.text, lambda share: 1e3 * given.quantiles(share))


def _accuracy(table: Table) -> Mapping[str, tuple[float, float]]:
    if isinstance(table.values["accuracy"], str):
        return keys.ACCURACY[table.word("accuracy", tuple(keys.ACCURACY))]
    own = table.table("accuracy")
    own.allow(*keys.COLUMNS[1:])
    numbers = {name: _finite(own, name, value) for name, value in own.values.items()}
    if len(numbers) < 3 or min(numbers.values()) < 0.0:
        raise table.refuse("accuracy", "must have qc, fs and u2, each a number >= 0 [kPa]")
    return {name: (1e3 * number, 0.0) for name, number in numbers.items()}


def _rate(table: Table) -> float:
    value, allowed = table.values["laboratory_rate"], LAYER_KEYS["laboratory_rate"].allowed
    found = re.fullmatch(keys.RATE, value, re.ASCII) if isinstance(value, str) else None
    if found:
        value = 0.01 * float(found[1]) / {"s": 1.0, "min": 60.0, "h": 3600.0}[found[2]]
    if not is_number(value):
        raise table.refuse("laboratory_rate", 'must be a text as "5 %/h", or a number in 1/s')
    if not allowed.holds(value, value):
        raise table.refuse("laboratory_rate", f"is {value:.2g} 1/s, must be {allowed.allowed}")
    return float(value)
