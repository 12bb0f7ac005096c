"""What a file of a measured test contains, in any format; cells are not converted to numbers."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from harness.interpret.reading.units import AREAS, LENGTHS, size_of
from harness.study.tables import StudyError
from mpm_warp.fields.names import nearest_name
from mpm_warp.fields.plain_numbers import plain_number

NO_NUMBER = ("nan", "-", "--", "n/a", "#n/a", "null")
"""Words that programs write for no value, in small letters."""
STATED: Mapping[str, Mapping[str, float]] = {
    "area_ratio": {},
    "pre_drilled": LENGTHS,
    "cone_area": AREAS,
    "water_level": LENGTHS,
}
"""Values that a test file may state, in the units of a site file, and their units."""


class NotNamedError(StudyError):
    """The site file has to name one of several soundings, a column or a unit."""

    def __init__(self, message: str, soundings: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.soundings = soundings
        """Names of the soundings; empty if a column or a unit is to be named."""


@dataclass(frozen=True)
class Heading:
    """Heading of a column."""

    name: str  # in small letters; the quantity if the file states it apart from the title
    title: str  # as in the file
    unit: str  # "" if the file has none
    missing: tuple[float, ...] = ()  # codes for a missing value


@dataclass(frozen=True, kw_only=True, eq=False)
class TestFile:
    """A measured test as its file has it."""

    headings: Sequence[Heading]
    rows: Sequence[tuple[int, list[str]]]  # number of each row in the file, and its cells
    row: str = "line"  # what this number counts, for messages
    stated: Mapping[str, float] = field(default_factory=dict)  # by `stated_values`
    in_order: bool = True  # whether rows are in the order of the measurement
    notes: tuple[str, ...] = ()  # what is unusual in the file


def stated_values(**given: tuple[str | None, str | None, str]) -> dict[str, float]:
    """Values of `STATED`, each by its text, its unit in the file, and the unit by the format.

    NaN for a text with digits that is no number. Other texts are left out; so is a 0 of an area or
    of a water level, which programs write where nobody gave one.
    """
    values = {}
    for name, (text, unit, usual) in given.items():
        if text and re.search(r"\d", text):
            known = STATED[name]
            size = size_of(unit or "", known) or known.get(usual, 1.0)
            number = plain_number(re.sub(r"^([-+]?\d+),(\d+)$", r"\1.\2", text))
            if number != 0.0 or name in ("area_ratio", "pre_drilled"):
                values[name] = math.nan if number is None else round(size * number, 9)
    return values


def plain_name(name: str) -> str:
    """A name in small letters, without blanks, dots, hyphens and underscores."""
    return re.sub(r"[\s_.-]", "", name.lower())


def numbers_of(texts: Iterable[str]) -> tuple[float, ...]:
    """The values of those texts that are numbers."""
    values = map(plain_number, texts)
    return tuple(value for value in values if value is not None)


def cell_number(cell: str) -> float | None:
    """The number of a cell, NaN for a word of `NO_NUMBER`; else None."""
    return math.nan if cell.strip().lower() in NO_NUMBER else plain_number(cell)


def check_marks(path: Path, *marks: str) -> None:
    """Refuse separators that cannot be told apart from each other or from numbers."""
    if len({*marks}) < len(marks) or any(len(it) != 1 or it in "0123456789+-eE" for it in marks):
        raise StudyError(
            f"{path}: its separators are {', '.join(map(repr, marks))}: each must be one character "
            "of its own that is no part of a number"
        )


def one_of(path: Path, names: Sequence[str], wanted: str | None) -> str:
    """The sounding that the site file names, or the only one."""
    if not names:
        raise StudyError(f"{path}: has no cone test")
    if wanted is None and len(names) == 1:
        return names[0]
    listed = ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
    if wanted is None:
        raise NotNamedError(
            f"{path}: has {len(names)} tests: {listed}; name one in the site file, as sounding = "
            f'"{names[0]}"',
            names,
        )
    if wanted not in names:
        near = nearest_name(wanted, names)
        raise StudyError(f"{path}: sounding = {wanted!r}: is not there{near}; has {listed}")
    return wanted
