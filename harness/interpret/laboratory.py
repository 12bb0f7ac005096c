"""Laboratory tests of a site: tables [[laboratory]] of its file, or a CSV with a row for each."""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from harness.interpret.tables.model_factor import MEASURED, OF_PRACTICE
from harness.study.files import read_text
from harness.study.tables import StudyError, Table, keys_of
from mpm_warp.fields.checked import check_fields
from mpm_warp.fields.declaration import parameter
from mpm_warp.fields.flat import parameters_of
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


@dataclass(frozen=True, kw_only=True, eq=False)
class LaboratoryTest:
    """One test."""

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


def tests_in(site: Table) -> tuple[LaboratoryTest, ...]:
    """The tests in the tables [[laboratory]] of a site file."""
    tables = site.list("laboratory")
    if not all(isinstance(table, dict) for table in tables):
        raise site.refuse("laboratory", "must be tables [[laboratory]] with depth, strength, test")
    where = f"{site.where} [[laboratory]]"
    return _tests_of([Table(f"{where} {n}", table) for n, table in enumerate(tables, start=1)])


def read_tests(path: Path) -> tuple[LaboratoryTest, ...]:
    """The tests of a CSV, whose columns are named as the keys, with their units in brackets."""
    lines = read_text(path, "a table of strengths").splitlines()
    mark = ";" if lines and ";" in lines[0] else ","
    reader = csv.DictReader(lines, delimiter=mark, skipinitialspace=True)
    try:
        rows, titles = list(reader), [title.strip() for title in reader.fieldnames or ()]
    except csv.Error as error:
        raise StudyError(f"{path}: is no table: {error}") from None
    columns = {
        f"{name}{declared.in_unit}": declared
        for name, declared in parameters_of(LaboratoryTest).items()
    }
    needed = [title for title, declared in columns.items() if declared.is_required]
    if not {*needed} <= {*titles} or not {*titles} <= {*columns}:
        raise StudyError(
            f"{path}: must be CSV with the columns {', '.join(needed)}, and error if it is known"
        )
    tables = []
    for number, row in enumerate(rows, start=2):
        if None in row:
            raise StudyError(f"{path}: row {number}: has more values than the header")
        cells: dict[str, Any] = {}
        for title, text in zip(titles, row.values(), strict=False):
            if isinstance(text, str) and text.strip():
                is_number = columns[title].kind is float
                value = plain_number(text) if is_number else None
                cells[columns[title].name] = text.strip() if value is None else value
        tables.append(Table(f"{path}: row {number}:", cells))
    return _tests_of(tables)


def _tests_of(tables: Sequence[Table]) -> tuple[LaboratoryTest, ...]:
    """The tests of tables; a `StudyError` names table, key and what is allowed."""
    if len(tables) > MOST_TESTS:
        raise StudyError(f"{tables[MOST_TESTS].where} a site has at most {MOST_TESTS} tests")
    for table in tables:
        table.allow(*keys_of(LaboratoryTest))
    return tuple(table.made(LaboratoryTest) for table in tables)
