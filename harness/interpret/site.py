"""Site files: the measured test, and what is known of each layer.

The keys are the declared fields of `Site`, `MeasuredTest` and `Layer`; README.md has an example.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.interpret import forms
from harness.interpret.forms import ByDepth
from harness.interpret.laboratory import LaboratoryTest, read_tests, tests_in
from harness.interpret.tables.factors import TABLE_RATE
from harness.interpret.tables.model_factor import MEASURED, OF_PRACTICE, RATIOS, SIMULATED
from harness.study.distributions import Input, an_input
from harness.study.files import read_toml
from harness.study.tables import LINE, StudyError, Table, keys_of
from mpm_warp.errors import ParameterError
from mpm_warp.fields.checked import check_fields
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats, Integers

BY_SLEEVE = "sleeve"
"""Value of the adhesion factor by which it follows from the sleeve friction at each depth."""
AVERAGE = "average"
MODES_OF_SHEAR = "simple_shear", OF_PRACTICE, "triaxial_extension"
MODES = MEASURED, AVERAGE, *MODES_OF_SHEAR, SIMULATED
"""Modes of the strength to be found."""
LARGEST_DEPTH = 1000.0


def _usual(ratio: str) -> dict[str, float]:
    """The usual range of a ratio of strengths, as an input is written."""
    return dict(zip(("low", "high"), RATIOS[ratio], strict=True))


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredTest:
    """The table [test]; optional values are None if they are not given."""

    where: str  # the site file and its table, for messages
    folder: Path  # of the site file
    given: frozenset[str] = frozenset()  # keys that the file has
    name: str = parameter(
        meaning="the measured test, CSV, GEF (.gef), BRO (.xml), AGS (.ags) or SGF",
        key="file",
        form=LINE,
    )
    sounding: str | None = parameter(None, "name of the test, in a file of several", form=LINE)
    columns: Mapping[str, str] = parameter(
        {}, "names of the columns in the file, if they are not the usual ones", form=forms.TEXTS
    )
    units: Mapping[str, str] = parameter(
        {}, "units of the columns, in place of those in the file", form=forms.TEXTS
    )
    missing: tuple[float, ...] | None = parameter(
        None,
        "codes for a missing value, besides those in the file; [] if values like -999 are measured",
        form=forms.NUMBERS,
    )
    ground_level: float | None = parameter(
        None, "level of the ground, if the file has levels, positive upward, not depths", unit="m"
    )
    pre_drilled: float | None = parameter(
        None, "pre-drilled depth, by default that in the test file, or 0", unit="m", minimum=0
    )
    area_ratio: float | None = parameter(
        None,
        "net area ratio of the cone on its calibration sheet, 1 if qc is corrected; a CSV does not "
        "have it, other files may",
        above=0,
        maximum=1,
    )
    cone_area: float | None = parameter(
        None,
        "cross-section of the cone, by default that in the test file, or 10",
        unit="cm2",
        minimum=1,
        maximum=100,
    )
    speed: float = parameter(
        20.0,
        "speed of the cone, by which su acts at its strain rate",
        unit="mm/s",
        minimum=1,
        maximum=100,
    )
    water_level: float = parameter(
        1.0,
        "depth of the ground water, with hydrostatic pressure below; negative if water stands on "
        "the ground, with its pressure in qc and u2",
        unit="m",
    )
    u0: ByDepth | None = parameter(
        None,
        "water pressure by depth [m], in place of water_level",
        unit="kPa",
        form=forms.BY_DEPTH,
    )
    # in N/m3; an input is the same at all depths
    unit_weight: Input | ByDepth = parameter(
        {"low": 15, "high": 19},
        "total unit weight of the ground, not the buoyant one",
        unit="kN/m3",
        minimum=10,
        maximum=30,
        form=forms.WEIGHT,
    )
    # half widths of 95 %: the larger of a value [Pa] and a share
    accuracy: Mapping[str, tuple[float, float]] = parameter(
        "class 2",
        "class of EN ISO 22476-1, or the errors of the test",
        choices=tuple(forms.ACCURACY),
        form=forms.ERRORS,
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def file(self) -> Path:
        """The file of the test."""
        return self.folder / self.name

    @property
    def water(self) -> float | ByDepth:
        """Depth of the ground water [m], or its pressure by depth [Pa]."""
        return self.water_level if self.u0 is None else self.u0

    @property
    def assumed(self) -> tuple[str, ...]:
        """Keys of the ground and of the errors that have their defaults."""
        used = (*(("water_level",) if self.u0 is None else ()), "unit_weight", "accuracy")
        return tuple(name for name in used if name not in self.given)


@dataclass(frozen=True, kw_only=True, eq=False)
class Layer:
    """A table [[layer]] in SI units."""

    given: frozenset[str] = frozenset()  # keys that the file has
    name: str | None = parameter(
        None, "title of the layer, by default its depths", key="title", form=LINE
    )
    top: float = parameter(meaning="depth of its top", unit="m", minimum=0, key="from")
    bottom: float = parameter(
        meaning="depth of its bottom", unit="m", above=0, maximum=LARGEST_DEPTH, key="to"
    )
    rigidity_index: Input = an_input(meaning="Ir = G / su", minimum=15, maximum=1000)
    rigidity_strength: str = parameter(
        AVERAGE, "mode of the su in Ir", choices=(AVERAGE, *MODES_OF_SHEAR)
    )
    adhesion_factor: Input | str = an_input(
        {"low": 0.2, "high": 0.8},
        "adhesion factor alpha; sleeve: by fs at each depth",
        minimum=0,
        maximum=1,
        choices=(BY_SLEEVE,),
    )
    K0: Input = an_input(
        {"low": 0.5, "high": 0.8}, "effective horizontal over vertical stress", above=0, maximum=5
    )
    stress_anisotropy: Input | None = an_input(
        None, "Delta = (sigma_v0 - sigma_h0) / (2 su), in place of K0", minimum=-0.6, maximum=0.9
    )
    rate_factor: Input = an_input(
        {"mean": 0.1, "deviation": 0.03},
        "increase of su per log cycle of strain rate, over su",
        minimum=0,
        maximum=0.25,
    )
    laboratory_rate: float = parameter(
        "1 %/h",
        "shear strain rate of the su to be found",
        unit="1/s",
        minimum=TABLE_RATE,
        maximum=1e-2,
        form=forms.RATE,
    )
    sensitivity: Input = an_input(
        {"low": 1.5, "high": 6.0}, "intact over remoulded strength", minimum=1, maximum=25
    )
    ductility: Input = an_input(
        {"low": 10, "high": 50},
        "plastic shear strain at which 95 % of the loss of strength is reached",
        minimum=5,
        maximum=60,
    )
    strength: str = parameter(
        MODES[0],
        "mode of the su to be found; mobilised: that of full-scale failures; average: of the three "
        "modes of shear; isotropic: of simulated clay, without a model factor",
        choices=MODES,
    )
    simple_shear_ratio: Input = an_input(
        _usual("simple_shear_ratio"), "su in simple shear over compression", above=0, maximum=1.2
    )
    extension_ratio: Input = an_input(
        _usual("extension_ratio"), "su in extension over compression", above=0, maximum=1.2
    )

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.top < self.bottom:
            raise ParameterError(
                "to",
                f"to = {self.bottom:g} is not allowed: must be > {self.top:g}, where it begins, "
                f"and <= {LARGEST_DEPTH:g}",
            )

    @property
    def title(self) -> str:
        """Its title, or else its depths."""
        return self.name or f"{self.top:g} to {self.bottom:g} m"

    @property
    def inputs(self) -> Mapping[str, Input]:
        """The inputs that are used, by key; without the adhesion factor if it is by the sleeve."""
        used = {name: getattr(self, name) for name in self._used}
        return {name: value for name, value in used.items() if value != BY_SLEEVE}

    @property
    def assumed(self) -> tuple[str, ...]:
        """Keys that have their defaults."""
        used = (*self._used, "rigidity_strength", "laboratory_rate", "strength")
        return tuple(name for name in used if name not in self.given)

    @property
    def _used(self) -> tuple[str, ...]:
        inputs = ("rigidity_index", "rate_factor", "sensitivity", "ductility", "adhesion_factor")
        anisotropy = "K0" if self.stress_anisotropy is None else "stress_anisotropy"
        converted = {self.strength, self.rigidity_strength} & {*MODES_OF_SHEAR}
        return (*inputs, anisotropy, *(RATIOS if converted else ()))


@dataclass(frozen=True, kw_only=True, eq=False)
class Site:
    """A site file."""

    name: str  # of the file without its ending, and of the results
    test: MeasuredTest
    layers: tuple[Layer, ...]
    laboratory: tuple[LaboratoryTest, ...] = ()
    title: str = parameter(meaning="title of the test", form=LINE)
    use: tuple[str, ...] = parameter(
        [forms.MEASURES[0]],
        "measurements by which strength is found, the tip first",
        form=forms.WORDS,
    )
    samples: int = parameter(
        2048, "number of random combinations of the inputs", minimum=512, maximum=65536
    )
    seed: int = parameter(1, "seed of the random numbers", minimum=0, maximum=1e9)

    def __post_init__(self) -> None:
        check_fields(self)

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


def load_site(path: Path, laboratory: Path | None = None) -> Site:
    """A site from its file, with tests of a `laboratory` in a CSV instead of those of the file.

    A `StudyError` names file, key and what is allowed.
    """
    if not path.is_file():
        raise StudyError(f"{path}: no such file; `harness new NAME --interpret TEST` writes one")
    values = read_toml(path)
    if "scene" in values and "test" not in values:
        raise StudyError(f"{path}: is a study; `harness run {path}` runs it")
    whole = Table(f"{path}:", values)
    whole.allow(*keys_of(Site), "test", "layer", "laboratory")
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
    test = _test(whole.table("test"), path.parent)
    tests = tests_in(whole) if laboratory is None else read_tests(laboratory)
    return whole.made(Site, name=path.stem, test=test, layers=tuple(read), laboratory=tests)


def _test(table: Table, folder: Path) -> MeasuredTest:
    table.allow(*keys_of(MeasuredTest))
    _refuse_both(table, "water_level", "u0")
    return table.made(MeasuredTest, where=table.where, folder=folder, given=frozenset(table.values))


def _layer(table: Table) -> Layer:
    table.allow(*keys_of(Layer))
    _refuse_both(table, "K0", "stress_anisotropy")
    return table.made(Layer, given=frozenset(table.values))


def _refuse_both(table: Table, one: str, other: str) -> None:
    """Refuse a table that has both of two alternative keys."""
    if one in table.values and other in table.values:
        raise StudyError(f"{table.where} {one}: {other} says the same; give one of them")
