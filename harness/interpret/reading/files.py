"""Files of measured tests: the choice of the reader by the format, and the reader of CSV."""

import csv
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path

from harness.interpret.reading.formats import (
    LENGTHS,
    Heading,
    TestFile,
    numbers_of,
    plain_unit,
    read_ags,
    read_bro,
    read_gef,
    read_sgf,
)
from harness.study.files import read_bounded
from harness.study.tables import StudyError

FEWEST_COLUMNS = 3
"""Columns of a CSV: depth, qc, and fs or u2."""
LARGEST_FILE = 20_000_000
"""Size of a file [byte]; a sounding of 100 m in steps of 5 mm has some two million bytes."""
READERS: Mapping[str, Callable[[Path, str, str | None], TestFile]] = {
    ".gef": read_gef,
    ".xml": read_bro,
    ".ags": read_ags,
}


def read_file(path: Path, sounding: str | None = None) -> TestFile:
    """A test from its file; GEF, XML and AGS are recognised by the ending.

    Any other file is SGF if its first line is $, or else CSV. `sounding` names the test in a file
    that has several.

    Raises:
        StudyError: the file cannot be read or is damaged.
        NotNamedError: the file has several tests, and `sounding` is None.
    """
    content = read_bounded(path, LARGEST_FILE, "a test")
    if b"\0" in content:
        raise StudyError(f"{path}: has null bytes: it is binary, or UTF-16; save it as UTF-8 text")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")  # matters for names only; numbers and keys are ASCII
    other = read_sgf if re.match(r"\s*\$\s*$", text, re.MULTILINE) else _csv
    reader = READERS.get(path.suffix.lower(), other)
    if sounding is not None and reader in (_csv, read_gef):
        raise StudyError(f"{path}: sounding = {sounding!r}: the file has one test, without a name")
    try:
        found = reader(path, text, sounding)
    except csv.Error as error:
        raise StudyError(f"{path}: is no table: {error}") from None
    if not found.rows:
        raise StudyError(f"{path}: has no rows below its header")
    return found


DECIMAL_COMMA = re.compile(r"-?\d*,\d+", re.ASCII)


def _csv(path: Path, text: str, sounding: str | None) -> TestFile:
    """A header with names and units, as qc [MPa], and rows, delimited by tab, ;, comma or blanks.

    Unless the delimiter is a comma, numbers may have a decimal comma, if none has a point. Lines
    above the header are left out. Units may be in a line of their own below it.
    """
    every = dict(enumerate(text.splitlines(), start=1))
    if by_blanks := _are_parted_by_blanks(every.values()):
        # No tab between a name and its unit in brackets.
        every = {it: "\t".join(re.sub(r"\s+(?=[\[(])", "", every[it]).split()) for it in every}
    lines = {
        number: line
        for number, line in every.items()
        if line.strip("\t;, ") and not line.lstrip().startswith("#")
    }
    if not lines:
        return TestFile(headings=(), rows=())
    first = _header(path, every, lines)
    above = [number for number in lines if number < first]
    notes = [f"{len(above)} lines above the header left out"] if above else []
    lines = {number: line for number, line in lines.items() if number not in above}
    delimiter = _delimiter(lines[first])
    reader = csv.reader(lines.values(), delimiter=delimiter)
    header = [_heading(cell.strip()) for cell in next(reader)]
    numbers = list(lines)
    rows = [(numbers[reader.line_num - 1], cells) for cells in reader]
    odd = [(number, cells) for number, cells in rows if len(cells) != len(header)]
    if by_blanks and odd:
        raise StudyError(
            f"{path}: line {odd[0][0]}: has {len(odd[0][1])} cells separated by blanks, the header "
            f"has {len(header)}; where a value is missing or a name has several words, cells must "
            "be separated by comma, semicolon or tab"
        )
    if rows and _are_units(lines[rows[0][0]]):
        units = [cell.strip(" []()") for cell in rows.pop(0)[1]]
        header = [
            replace(heading, unit=heading.unit or unit)
            for heading, unit in zip(header, units, strict=False)
        ]
    cells_of_all = [cell for _, cells in rows for cell in cells]
    with_point = (cell for cell in cells_of_all if "." in cell)  # some may be dates
    if delimiter != "," and not numbers_of(with_point):
        commas = [DECIMAL_COMMA.fullmatch(cell.strip()) is not None for cell in cells_of_all]
        if any(commas):  # no number has a point, so the commas do not separate thousands
            rows = [(number, [cell.replace(",", ".") for cell in cells]) for number, cells in rows]
            notes.append("numbers have a decimal comma")
    return TestFile(headings=header, rows=rows, notes=tuple(notes))


def _are_parted_by_blanks(lines: Collection[str]) -> bool:
    """Whether rows of numbers are separated by blanks, and none by other delimiters."""
    marked, blank = (
        any(len(numbers_of(cells(line))) >= FEWEST_COLUMNS for line in lines)
        for cells in (_cells, lambda line: line.replace(",", ".").split())
    )
    return blank and not marked


def _delimiter(line: str) -> str:
    return next((mark for mark in "\t;," if mark in line), ",")


def _header(path: Path, every: Mapping[int, str], lines: Mapping[int, str]) -> int:
    """Number of the header: the last line of words above the first row of numbers.

    A line of units may be between the two. `every` has all lines by number; in `lines` comments and
    empty lines are left out.
    """
    worded = [number for number, line in every.items() if len(_words(line)) >= FEWEST_COLUMNS]
    named = [number for number in worded if number in lines]
    commented = [number for number in worded if every[number].startswith("#")]
    if commented and not named:
        raise StudyError(
            f"{path}: has no header: lines that begin with # are left out, line {commented[-1]} "
            "among them; remove its #"
        )
    values = [it for it, line in lines.items() if len(numbers_of(_cells(line))) >= FEWEST_COLUMNS]
    first = next((it for it in values if named and it > named[0]), None)
    above = [number for number in named if first is not None and number < first]
    if values and not above:
        raise StudyError(
            f"{path}: line {values[0]} has values, and no line above it names the columns, as "
            "depth [m],qc [MPa],fs [kPa],u2 [kPa]"
        )
    if len(above) > 1 and _are_units(lines[above[-1]]):
        return above[-2]
    return above[-1] if above else min(named or lines)


def _are_units(line: str) -> bool:
    """Whether a line of words has a unit of length, as a line of units has for the depth."""
    return any(plain_unit(cell.strip(" []()")) in LENGTHS for cell in _words(line))


def _cells(line: str) -> list[str]:
    """Cells of a line that are not empty, with a point for a decimal comma."""
    pieces = (piece.strip(' "') for piece in line.split(_delimiter(line)))
    return [piece.replace(",", ".") for piece in pieces if piece]


def _words(line: str) -> list[str]:
    """Cells of a line without numbers; none of any other line."""
    cells = _cells(line)
    return [] if numbers_of(cells) else cells


def _heading(title: str) -> Heading:
    """Name and unit of "qc [MPa]" or "qc (MPa)"."""
    found = re.fullmatch(r"(.*?)\s*(?:[\[(]([^\])]*)[\])])?", title)
    name, unit = (found[1], found[2] or "") if found else (title, "")
    return Heading(name.strip().lower(), title, unit)
