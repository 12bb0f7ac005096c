"""Readers of the exchange formats of measured tests; cells are not converted to numbers.

They find headings, rows, codes for missing values, and data of the cone. Formats, as commonly
quoted: GEF-CPT-Report 1.1.2 (CUR 2006), BRO CPT catalogue (IMBRO), AGS 4.1 (groups SCPG and SCPT),
SGF (codes of the Swedish Geotechnical Society, as Geotech writes them). README.md lists the
libraries that were tried; none is needed, because a sounding is a small table.
"""

import csv
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree as ET

from harness.study.tables import StudyError
from mpm_warp.fields.names import nearest_name
from mpm_warp.fields.plain_numbers import plain_number


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
    # values that the file states, NaN if unreadable: area_ratio, pre_drilled [m], cone_area [cm2]
    stated: Mapping[str, float] = field(default_factory=dict)
    in_order: bool = True  # whether rows are in the order of the measurement
    notes: tuple[str, ...] = ()  # what is unusual in the file


GEF_QUANTITIES = {
    "1": "penetrationlength",
    "2": "coneresistance",
    "3": "localfriction",
    "4": "frictionratio",
    "5": "porepressureu1",
    "6": "porepressureu2",
    "7": "porepressureu3",
    "8": "inclinationresultant",
    "9": "inclinationns",
    "10": "inclinationew",
    "11": "depth",
}
"""Quantities of columns by their numbers in GEF."""
GEF_STATED = "3", "13", "1"
"""Numbers of #MEASUREMENTVAR, in the order of `STATED`."""
STATED = "area_ratio", "pre_drilled", "cone_area"
"""Values that a test file may state."""
LENGTHS: Mapping[str, float] = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048}
"""Units of length [m]."""
AREAS = {"mm2": 100.0, "cm2": 1.0, "m2": 1e-4}
"""Units of area, each with 1 cm2 in that unit."""


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
    headings = [
        Heading(
            GEF_QUANTITIES.get(column[3], column[2].lower()),
            column[2],
            column[1],
            voids.get(column[0], ()),
        )
        for _, column in columns
    ]
    parting, record = (_separator(keys, f"{of}SEPARATOR") for of in ("COLUMN", "RECORD"))
    _check_marks(path, ".", parting or " ", record or "\n")
    first = header.count("\n") + 1
    rows = [
        (number, [piece.strip() for piece in part.split(parting)])
        for number, line in enumerate(data.splitlines()[1:], start=first + 1)
        for part in line.split(record or "\n")
        if part.strip()
    ]
    numbers = [fields[0] for fields in keys.get("MEASUREMENTVAR", [])]
    for number in GEF_STATED:
        if numbers.count(number) > 1:
            raise StudyError(f"{path}: #MEASUREMENTVAR = {number} must be there once")
    measured = {fields[0]: [*fields[1:], "", ""] for fields in keys.get("MEASUREMENTVAR", [])}
    of_cone = [measured.get(number, ["", ""]) for number in GEF_STATED]
    last = next(iter(numbers_of(keys.get("LASTSCAN", [[]])[0][:1])), len(rows))
    return TestFile(
        headings=headings,
        rows=rows,
        stated=_of_cone(*(text for text, *_ in of_cone), unit=of_cone[-1][1]),
        notes=() if last == len(rows) else (f"#LASTSCAN = {last:g}, but {len(rows)} rows",),
    )


def _of_cone(*texts: str | None, unit: str | None) -> dict[str, float]:
    """Values of texts in the order of `STATED`; NaN for a text with digits that is no number.

    Other texts, and an area of 0 or in an unknown unit, are left out.
    """
    values = {
        name: math.nan if (number := plain_number(text)) is None else number
        for name, text in zip(STATED, texts, strict=True)
        if text and re.search(r"\d", text)
    }
    area, own = values.pop(STATED[-1], 0.0), plain_unit(unit or "")
    is_known = own in AREAS and area != 0.0
    return values | ({STATED[-1]: area / AREAS[own]} if is_known else {})


def plain_unit(unit: str) -> str:
    """A unit in small letters, with a square written as 2."""
    return unit.replace("\N{SUPERSCRIPT TWO}", "2").replace("^2", "2").strip().lower()


def _separator(keys: Mapping[str, list[list[str]]], name: str) -> str | None:
    """A separator; None, for any blank, if the file has none."""
    values = keys.get(name, [[""]])[0]  # a comma was parted into two empty texts
    return "," if len(values) > 1 else values[0] or None


def numbers_of(texts: Iterable[str]) -> tuple[float, ...]:
    """The values of those texts that are numbers."""
    values = map(cell_number, texts)
    return tuple(value for value in values if value is not None)


def cell_number(cell: str) -> float | None:
    """The number of a cell, NaN for the word that programs write for no value; else None."""
    return math.nan if cell.strip().lower() == "nan" else plain_number(cell)


def _check_marks(path: Path, *marks: str) -> None:
    """Refuse separators that cannot be told apart from each other or from numbers."""
    if len({*marks}) < len(marks) or any(len(it) != 1 or it in "0123456789+-eE" for it in marks):
        raise StudyError(
            f"{path}: its separators are {', '.join(map(repr, marks))}: each must be one character "
            "of its own that is no part of a number"
        )


BRO_UNITS = {"depth": "m", "penetrationlength": "m"} | dict.fromkeys(
    ("inclinationresultant", "inclinationns", "inclinationew"), "deg"
)
"""Units, which the catalogue fixes; all other columns that are read are in MPa."""
BRO_MISSING = (-999999.0,)
BRO_STATED = "coneSurfaceQuotient", "predrilledDepth", "coneSurfaceArea"


def read_bro(path: Path, text: str, sounding: str | None) -> TestFile:
    """An XML document; each test has the parameters that were measured, and rows of all of them."""
    if "<!DOCTYPE" in text:  # it can define entities, which may expand without end
        raise StudyError(f"{path}: has a document type, which no file of the BRO has")
    try:
        root = ET.fromstring(text)
    except (ET.ParseError, ValueError) as error:
        raise StudyError(f"{path}: is no whole XML: {error}") from None
    surveys = {
        element.findtext("{*}broId", f"test {number}"): survey
        for number, element in enumerate(root.iter(), start=1)
        if (survey := element.find("{*}conePenetrometerSurvey")) is not None
    }
    survey = surveys[_one_of(path, list(surveys), sounding)]
    parameters = survey.find("{*}parameters")
    result = survey.find("{*}conePenetrationTest/{*}cptResult")
    values = None if result is None else result.findtext("{*}values")
    encoding = None if result is None else result.find("{*}encoding/{*}TextEncoding")
    if parameters is None or values is None or encoding is None:
        raise StudyError(f"{path}: lacks parameters, TextEncoding or values of a cone test")
    titles = [(parameter.tag.partition("}")[2], parameter.text == "ja") for parameter in parameters]
    point, cell, block = (
        encoding.get(f"{name}Separator", usual)
        for name, usual in (("decimal", "."), ("token", ","), ("block", ";"))
    )
    _check_marks(path, point, cell, block)
    to_points = str.maketrans(f"{point}.", f".{point}")
    area = survey.find(".//{*}coneSurfaceArea")
    return TestFile(
        headings=[
            Heading(
                title.lower() if is_there else "",
                title,
                BRO_UNITS.get(title.lower(), "MPa"),
                BRO_MISSING,
            )
            for title, is_there in titles
        ],
        rows=[
            (number, [piece.strip().translate(to_points) for piece in row.split(cell)])
            for number, row in enumerate(values.split(block), start=1)
            if row.strip()
        ],
        row="row",
        stated=_of_cone(
            *(survey.findtext(f".//{{*}}{tag}") for tag in BRO_STATED),
            unit=None if area is None else area.get("uom", "mm2"),
        ),
        in_order=False,
    )


def read_ags(path: Path, text: str, sounding: str | None) -> TestFile:
    """Groups of rows that begin with GROUP, HEADING, UNIT, TYPE or DATA."""
    groups: dict[str, dict[str, list[tuple[int, list[str]]]]] = {}
    group: dict[str, list[tuple[int, list[str]]]] = {}
    reader = csv.reader(text.splitlines(), strict=True)
    try:
        for kind, *cells in filter(None, reader):
            if kind == "GROUP" and cells:
                group = groups.setdefault(cells[0], {})
            group.setdefault(kind, []).append((reader.line_num, [cell.strip() for cell in cells]))
    except csv.Error as error:
        raise StudyError(
            f"{path}: line {reader.line_num} is no table: {error}; quotes in a text are doubled"
        ) from None
    if not {"HEADING", "UNIT", "DATA"} <= groups.get("SCPT", {}).keys():
        remedy = "; AGS 3 has to be converted" if "**" in text else ""
        raise StudyError(f"{path}: has no group SCPT of AGS 4 with HEADING, UNIT and DATA{remedy}")
    test, general = groups["SCPT"], groups.get("SCPG", {})
    (_, titles), (_, units) = test["HEADING"][0], test["UNIT"][0]
    rows = [(number, _ags_name(titles, cells), cells) for number, cells in test["DATA"]]
    chosen = _one_of(path, list(dict.fromkeys(name for _, name, _ in rows)), sounding)
    of_cone, in_units = (general.get(kind, [(0, [])])[0][1] for kind in ("HEADING", "UNIT"))
    own = (cells for _, cells in general.get("DATA", []) if _ags_name(of_cone, cells) == chosen)
    cone, of = (dict(zip(of_cone, it, strict=False)) for it in (next(own, []), in_units))
    return TestFile(
        headings=[
            Heading(title.lower(), title, unit)
            for title, unit in zip(titles, units + [""] * len(titles), strict=False)
        ],
        rows=[(number, cells) for number, name, cells in rows if name == chosen],
        stated=_of_cone(cone.get("SCPG_CAR"), None, cone.get("SCPG_CSA"), unit=of.get("SCPG_CSA")),
    )


def _ags_name(titles: Sequence[str], cells: Sequence[str]) -> str:
    """Location and test of a row, as CPT1/2, or CPT1 if the test has no name."""
    row = dict(zip(titles, cells, strict=False))
    return "/".join(filter(None, (row.get("LOCA_ID", ""), row.get("SCPG_TESN", ""))))


Codes = dict[str, str]
SGF_COLUMNS = {
    "D": ("penetrationlength", "m"),
    "QC": ("coneresistance", "MPa"),
    "FS": ("localfriction", "kPa"),
    "U": ("porepressureu2", "kPa"),
    "TA": ("inclinationresultant", "deg"),
}
"""Codes of a row, each with its quantity and fixed unit."""
SGF_STATED = "MA", "HO", "MC"


def read_sgf(path: Path, text: str, sounding: str | None) -> TestFile:
    """Each sounding has a line $, its codes, a line #, rows of codes as D=1.02, and a line #$.

    Rows without a depth are remarks. Soundings without QC are not cone tests.
    """
    found: list[tuple[Codes, list[tuple[int, Codes]]]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if (mark := line.strip()) == "$":
            found.append(({}, []))
        pairs = (piece.partition("=") for piece in mark.split(","))
        codes = {code.strip(): value.strip() for code, equals, value in pairs if equals}
        if "D" in codes:
            found[-1][1].append((number, codes))
        elif codes and not found[-1][1]:
            found[-1][0].update(codes)
    tests: dict[str, tuple[Codes, list[tuple[int, Codes]]]] = {}
    for place, (of_test, rows) in enumerate(found, start=1):
        if any("QC" in codes for _, codes in rows):
            name = of_test.get("HK") or f"test {place}"
            if name in tests:
                raise StudyError(f"{path}: has two cone tests called HK={name}; part the file")
            tests[name] = of_test, rows
    of_test, rows = tests[_one_of(path, list(tests), sounding)]
    there = [code for code in SGF_COLUMNS if any(code in codes for _, codes in rows)]
    return TestFile(
        headings=[Heading(SGF_COLUMNS[it][0], it, SGF_COLUMNS[it][1]) for it in there],
        rows=[(number, [codes.get(code, "") for code in there]) for number, codes in rows],
        stated=_of_cone(*(of_test.get(code) for code in SGF_STATED), unit="cm2"),
    )


def _one_of(path: Path, names: Sequence[str], wanted: str | None) -> str:
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
