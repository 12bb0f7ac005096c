"""Laboratory tests of a site: tables [[laboratory]] of its file, or a CSV with a row for each."""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from harness.interpret.reading.contents import Heading, plain_name
from harness.interpret.reading.text_table import read_table
from harness.interpret.reading.units import LENGTHS, PRESSURES, size_of
from harness.interpret.tables.model_factor import MEASURED, OF_PRACTICE
from harness.study.files import read_text
from harness.study.tables import StudyError, Table, keys_of
from mpm_warp.fields.checked import check_fields
from mpm_warp.fields.declaration import parameter
from mpm_warp.fields.names import did_you_mean
from mpm_warp.fields.plain_numbers import plain_number

MOST_TESTS = 100
"""Largest number of tests of one site."""
OF_BAND = 2.0 * 1.645
"""Width of a band of 90 % over the deviation."""


class Kind(NamedTuple):
    """A kind of test: its su over that of a mode, from low to high with 90 %."""

    mode: str
    low: float
    high: float

    @property
    def mean(self) -> float:
        """Mean of the logarithm."""
        return 0.5 * math.log(self.low * self.high)

    @property
    def deviation(self) -> float:
        """Deviation of the logarithm, common to all tests of this kind at a site."""
        return math.log(self.high / self.low) / OF_BAND


KINDS: Mapping[str, Kind] = {
    "CAUC": Kind(OF_PRACTICE, 1.0, 1.0),
    "CIUC": Kind(OF_PRACTICE, 1.0, 1.25),
    "UU": Kind(OF_PRACTICE, 0.6, 1.1),
    "UC": Kind(OF_PRACTICE, 0.5, 1.0),
    "DSS": Kind("simple_shear", 1.0, 1.0),
    "CAUE": Kind("triaxial_extension", 1.0, 1.0),
    "vane": Kind(MEASURED, 0.9, 1.6),
    "fall_cone": Kind(MEASURED, 0.7, 1.6),
    "mobilised": Kind(MEASURED, 1.0, 1.0),
}
"""Triaxial tests consolidated anisotropically (CA), isotropically (CI) or not (UU, UC), in
compression (C) or extension (E); direct simple shear; field vane without correction, over the
mobilised strength (Bjerrum's correction is 1.1 to 0.6, as commonly quoted); strengths already
brought to the mobilised one. The ranges are wide ones, chosen here; they contain the usual rate of
each kind."""
SPOKEN = {name.lower().replace("_", ""): name for name in KINDS} | {
    "cau": "CAUC",
    "ciu": "CIUC",
    "uct": "UC",
    "fv": "vane",
    "fvt": "vane",
    "fieldvane": "vane",
    "simpleshear": "DSS",
    "directsimpleshear": "DSS",
}
"""Kinds as tables have them, by `plain_name`."""
NAMES: Mapping[str, tuple[str, ...]] = {
    "depth": ("depth", "z", "sampledepth"),
    "strength": ("strength", "su", "cu", "undrainedshearstrength", "undrainedstrength"),
    "test": ("test", "type", "kind", "method", "testtype"),
    "error": ("error",),
}
"""Names of the columns of a CSV, by `plain_name`."""
UNITS: Mapping[str, Mapping[str, float]] = {
    "depth": LENGTHS,
    "strength": {unit: size / 1e3 for unit, size in PRESSURES.items()},
    "error": {"": 1.0, "-": 1.0, "1": 1.0, "%": 0.01},
}
"""Units of the columns that are numbers, in those of a site file."""
EXPECTED = "must be CSV with columns as depth [m], su [kPa], test, and error if it is known"


@dataclass(frozen=True, kw_only=True)
class LaboratoryTest:
    """One test; two with the same values are the same test, which counts once."""

    depth: float = parameter(meaning="depth of the sample", unit="m", minimum=0, maximum=1000)
    strength: float = parameter(
        meaning="undrained shear strength su of the test", unit="kPa", above=0, maximum=1e4
    )
    test: str = parameter(meaning="kind of test", choices=tuple(KINDS))
    error: float = parameter(
        0.0,
        "standard deviation of what is wrong with this value, over it, as by a poor sample; the "
        "usual scatter of tests is counted without it",
        minimum=0,
        maximum=1,
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def kind(self) -> Kind:
        """Its kind."""
        return KINDS[self.test]

    @property
    def words(self) -> str:
        """The test in words."""
        return f"the test {self.test} of {self.strength:g} kPa at {self.depth:g} m"


def tests_in(site: Table) -> tuple[LaboratoryTest, ...]:
    """The tests in the tables [[laboratory]] of a site file."""
    tables = site.list("laboratory")
    if not all(isinstance(table, dict) for table in tables):
        raise site.refuse("laboratory", "must be tables [[laboratory]] with depth, strength, test")
    where = f"{site.where} [[laboratory]]"
    return _tests_of([Table(f"{where} {n}", table) for n, table in enumerate(tables, start=1)])


def read_tests(path: Path) -> tuple[LaboratoryTest, ...]:
    """The tests of a CSV with columns of `NAMES`; depths and strengths have a unit in brackets."""
    try:
        file = read_table(path, read_text(path, "a table of strengths"), None)
    except csv.Error as error:
        raise StudyError(f"{path}: is no table: {error}") from None
    columns = _columns(path, file.headings)
    tables = []
    for number, cells in file.rows:
        if any(cells[len(file.headings) :]):
            raise StudyError(f"{path}: line {number}: has more values than the header")
        row: dict[str, Any] = {}
        for name, (place, size) in columns.items():
            text = cells[place].strip() if place < len(cells) else ""
            if text and size is None:
                row[name] = SPOKEN.get(plain_name(text), text)
            elif text:
                value = plain_number(text)
                row[name] = text if value is None or size is None else size * value
        tables.append(Table(f"{path}: line {number}:", row))
    return _tests_of(tables)


def _columns(path: Path, headings: Sequence[Heading]) -> dict[str, tuple[int, float | None]]:
    """Place of each quantity, and its unit in that of a site file; None if it is a text."""
    found: dict[str, tuple[int, float | None]] = {}
    for place, heading in enumerate(headings):
        name = next((it for it, own in NAMES.items() if plain_name(heading.name) in own), None)
        sizes = UNITS.get(name or "")
        size = None if sizes is None else size_of(heading.unit, sizes)
        near = did_you_mean(heading.name, chain(*NAMES.values()), 0.85) if name is None else ""
        twice = "; there are two of it" if name in found else ""
        unit = f"; its unit must be one of {', '.join(sizes)}" if sizes and size is None else ""
        if problem := near or twice or unit:
            raise StudyError(f"{path}: column {heading.title!r}: {EXPECTED}{problem}")
        if name is not None:
            found[name] = place, size
    if lacking := [name for name in (*UNITS, "test") if name not in found and name != "error"]:
        titles = ", ".join(heading.title for heading in headings)
        raise StudyError(f"{path}: has no column {lacking[0]!r} among {titles}: {EXPECTED}")
    return found


def _tests_of(tables: Sequence[Table]) -> tuple[LaboratoryTest, ...]:
    """The tests of tables; a `StudyError` names table, key and what is allowed."""
    if len(tables) > MOST_TESTS:
        raise StudyError(f"{tables[MOST_TESTS].where} a site has at most {MOST_TESTS} tests")
    for table in tables:
        table.allow(*keys_of(LaboratoryTest))
    tests = tuple(table.made(LaboratoryTest) for table in tables)
    for place, test in enumerate(tests):
        if test in tests[:place]:
            raise StudyError(
                f"{tables[place].where} {test.words} is there before, and would count twice; a "
                "test of another sample has its own depth, if only by 0.01 m"
            )
    return tests


def refuse_shared(tests: Mapping[str, Sequence[LaboratoryTest]]) -> None:
    """Refuse a test that two site files have, given the tests of each by its name."""
    first: dict[LaboratoryTest, str] = {}
    for name, test in ((name, test) for name, own in tests.items() for test in own):
        if (other := first.setdefault(test, name)) != name:
            raise StudyError(
                f"{name}.toml: [[laboratory]]: {test.words} is in {other}.toml too, and would "
                "count twice; it belongs to the sounding beside it, and counts for all"
            )
