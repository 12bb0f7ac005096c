"""Tables of text: CSV, and columns of fixed width, with one header above the rows."""

import csv
import itertools
import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path

from harness.interpret.reading.contents import Heading, TestFile, numbers_of
from harness.interpret.reading.units import ANGLES, LENGTHS, PRESSURES, size_of
from harness.study.tables import StudyError

FEWEST_COLUMNS = 3
"""Columns of a table: depth, qc, and fs or u2."""
DECIMAL_COMMA = re.compile(r"-?\d*,\d+", re.ASCII)


def read_table(path: Path, text: str, sounding: str | None) -> TestFile:
    """A header with names and units, as qc [MPa], and rows, delimited by tab, ;, comma or blanks.

    Where blanks separate the cells, a cell may be empty if those of a column stand below each
    other. Unless the delimiter is a comma, numbers may have a decimal comma, if none has a point.
    Lines above the header are left out. Units may be in a line of their own below it.
    """
    every = dict(enumerate(text.splitlines(), start=1))
    if by_blanks := _are_parted_by_blanks(every.values()):
        every = _by_words(every) | _by_columns(every)
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
            "stand below each other, or be separated by comma, semicolon or tab"
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
        for cells in (_cells, _by_blanks)
    )
    return blank and not marked


def _by_words(every: Mapping[int, str]) -> dict[int, str]:
    """Lines with a tab in place of blanks, but for those between a name and its unit."""
    return {it: "\t".join(re.sub(r"\s+(?=[\[(])", "", every[it]).split()) for it in every}


def _by_columns(every: Mapping[int, str]) -> dict[int, str]:
    """Header and rows with a tab after each column, if the cells of each begin or end together.

    The row with most cells shows where. Nothing is returned if the cells do not stand so, or if a
    name of the header is wider than its column.
    """
    lines = {number: line.expandtabs() for number, line in every.items() if line.strip()}
    spans = {it: [word.span() for word in re.finditer(r"\S+", line)] for it, line in lines.items()}
    first = next(it for it, line in every.items() if len(numbers_of(_by_blanks(line))) > 2)
    rows = [it for it in lines if it >= first]
    header = [it for it in lines if it < first][-2:]  # names, and maybe units
    for end in (1, 0):
        edges = [span[end] for span in max((spans[it] for it in rows), key=len)]
        if all(span[end] in edges for it in rows for span in spans[it]):
            cuts = [0, *(edges[:-1] if end else edges[1:])]
            wide = {
                it
                for it in header
                for low, high in spans[it]
                if any(low < cut < high for cut in cuts)
            }
            if wide & {*header[-1:]}:
                break
            pieces = [slice(*ends) for ends in itertools.pairwise([*cuts, None])]
            return {
                it: "\t".join(lines[it][piece].strip() for piece in pieces)
                for it in (*header, *rows)
                if it not in wide
            }
    return {}


def _by_blanks(line: str) -> list[str]:
    """Cells of a line between blanks, with a point for a decimal comma."""
    return line.replace(",", ".").split()


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
    return any(size_of(cell.strip(" []()"), LENGTHS) for cell in _words(line))


def _cells(line: str) -> list[str]:
    """Cells of a line that are not empty, with a point for a decimal comma."""
    pieces = (piece.strip(' "') for piece in line.split(_delimiter(line)))
    return [piece.replace(",", ".") for piece in pieces if piece]


def _words(line: str) -> list[str]:
    """Cells of a line without numbers; none of any other line."""
    cells = _cells(line)
    return [] if numbers_of(cells) else cells


def _heading(title: str) -> Heading:
    """Name and unit of "qc [MPa]", "qc (MPa)" or "qc_MPa"."""
    found = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]", title)
    after = re.fullmatch(r"(.+?)[\s_]+(\S+)", title)
    if found is None and after and size_of(after[2], {**LENGTHS, **PRESSURES, **ANGLES}):
        found = after
    name, unit = found.groups() if found else (title, "")
    return Heading(name.strip().lower(), title, unit)
