"""GEF: GEF-CPT-Report 1.0.0 to 1.1.2 (CUR 1999 to 2006), as commonly quoted."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from harness.interpret.reading.contents import (
    Heading,
    TestFile,
    cell_number,
    check_marks,
    numbers_of,
    stated_values,
)
from harness.study.tables import StudyError
from mpm_warp.fields.plain_numbers import plain_number

PLANES = {"9": "inclinationns", "10": "inclinationew"}
"""Inclinations in planes north to south and east to west."""
OTHER_PLANES = {"21": "inclinationns", "22": "inclinationew"}
"""Inclinations in two other planes at right angles, which are read where `PLANES` lack."""
DEPTHS = {"1": "penetrationlength", "11": "depth"}
QUANTITIES = DEPTHS | {
    "2": "coneresistance",
    "3": "localfriction",
    "4": "frictionratio",
    "5": "porepressureu1",
    "6": "porepressureu2",
    "7": "porepressureu3",
    "8": "inclinationresultant",
}
"""Quantities of columns by their numbers."""
STATED = {
    "area_ratio": ("3", "-"),
    "pre_drilled": ("13", "m"),
    "cone_area": ("1", "mm2"),
    "water_level": ("14", "m"),
}
"""Numbers of #MEASUREMENTVAR, and their units by the format."""


def read_gef(path: Path, text: str, sounding: str | None) -> TestFile:
    """A header of #KEY = value, value lines down to #EOH, and rows."""
    header, end, data = text.partition("#EOH")
    keys: dict[str, list[list[str]]] = {}
    for key, values in re.findall(r"^#[ \t]*(\w+)[ \t]*=[ \t]*(.*)$", header, re.MULTILINE):
        keys.setdefault(key.upper(), []).append([piece.strip() for piece in values.split(",")])
    if not (end and "GEFID" in keys):
        raise StudyError(f"{path}: is no whole GEF: has no {'#GEFID' if end else '#EOH'}")
    code = (keys.get("REPORTCODE") or keys.get("PROCEDURECODE") or [["no #REPORTCODE"]])[0][0]
    if "CPT" not in code.upper():
        raise StudyError(f"{path}: is no cone test: {code}, must be GEF-CPT-Report")
    parting, record = (_separator(keys, f"{of}SEPARATOR") for of in ("COLUMN", "RECORD"))
    check_marks(path, ".", parting or " ", record or "\n")
    first = header.count("\n") + 1
    rows = [
        (number, [piece.strip() for piece in part.split(parting)])
        for number, line in enumerate(data.splitlines()[1:], start=first + 1)
        for part in line.split(record or "\n")
        if part.strip()
    ]
    headings = _headings(path, keys)
    last = next(iter(numbers_of(keys.get("LASTSCAN", [[]])[0][:1])), len(rows))
    notes: tuple[str, ...] = (
        () if last == len(rows) else (f"#LASTSCAN = {last:g}, but {len(rows)} rows",)
    )
    for place in _negative(headings, rows):
        notes += (f"{headings[place].title!r} is negative downward in the file",)
        for _, cells in rows:
            if place < len(cells) and cell_number(cells[place]) not in headings[place].missing:
                cells[place] = cells[place].removeprefix("-")
    return TestFile(headings=headings, rows=rows, stated=_stated(path, keys), notes=notes)


def _headings(path: Path, keys: Mapping[str, list[list[str]]]) -> list[Heading]:
    voids: dict[str, tuple[float, ...]] = {}
    for fields in keys.get("COLUMNVOID", []):
        voids[fields[0]] = voids.get(fields[0], ()) + numbers_of(fields[1:2])
    columns = sorted(
        (plain_number(fields[0]) or 0.0, fields)
        for fields in keys.get("COLUMNINFO", [])
        if len(fields) > 3
    )
    if [number for number, _ in columns] != list(range(1, len(columns) + 1)):
        raise StudyError(f"{path}: #COLUMNINFO must be there once for each column, from 1 on")
    has_planes = any(column[3] in PLANES for _, column in columns)
    known = QUANTITIES | (PLANES if has_planes else OTHER_PLANES)
    return [
        Heading(known.get(quantity, title.lower()), title, unit, voids.get(number, ()))
        for _, (number, unit, title, quantity, *_) in columns
    ]


def _negative(headings: Sequence[Heading], rows: Sequence[tuple[int, list[str]]]) -> list[int]:
    """Places of depths that are negative downward; levels may go deeper than the rods are long."""
    found = {}
    for place, heading in enumerate(headings):
        if heading.name in DEPTHS.values():
            values = numbers_of(cells[place] for _, cells in rows if place < len(cells))
            found[place] = [it for it in values if it not in heading.missing] or [0.0]
    length = max(
        (max(map(abs, found[it])) for it in found if headings[it].name == DEPTHS["1"]),
        default=math.inf,
    )
    return [it for it, own in found.items() if max(own) <= 0.0 > min(own) >= -1.001 * length]


def _stated(path: Path, keys: Mapping[str, list[list[str]]]) -> dict[str, float]:
    """Data of the cone and the ground water level; their numbers may have a decimal comma."""
    given: dict[str, tuple[str, str, str]] = {}
    of_names = {number: (name, unit) for name, (number, unit) in STATED.items()}
    for number, *fields in keys.get("MEASUREMENTVAR", []):
        value, unit, further = (*fields, "", "", "")[:3]
        if re.fullmatch(r"-?\d+", value) and re.fullmatch(r"\d+", unit):  # as 1,50, m
            value, unit = f"{value}.{unit}", further
        if number in of_names:
            name, usual = of_names[number]
            if name in given:
                raise StudyError(f"{path}: #MEASUREMENTVAR = {number} must be there once")
            given[name] = value, unit, usual
    return stated_values(**given)


def _separator(keys: Mapping[str, list[list[str]]], name: str) -> str | None:
    """A separator; None, for any blank, if the file has none."""
    values = keys.get(name, [[""]])[0]  # a comma was parted into two empty texts
    return "," if len(values) > 1 else values[0] or None
