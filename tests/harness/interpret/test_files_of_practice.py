"""Files as programs and people write them, beside those by the book: the same columns."""

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.harness.interpret.written_tests import (
    WRITERS,
    Row,
    as_ags,
    as_csv,
    as_gef,
    as_sgf,
    cells,
    columns_of,
    rows_of,
    site_of,
)

WATER = "\n#MEASUREMENTVAR= 14, {}, grondwaterstand\n#LASTSCAN"
TOLD: dict[str, tuple[str, str, str, float | str]] = {
    "words after a unit": ("gef", "1, 1500, mm2,", "1, 1510, mm2 (vierkante millimeter),", 15.1),
    "no unit": ("gef", "1, 1500, mm2,", "1, 1510.0,", 15.1),
    "no area": ("gef", "1, 1500, mm2,", "1, 0, mm2,", 10.0),
    "a hyphen": ("gef", "1, 1500, mm2,", "1, -, mm2,", 10.0),
    "centimetres": ("gef", "13, 1.55, m,", "13, 155, cm,", "pre_drilled = 1.55 by the file"),
    "a decimal comma": ("gef", "13, 1.55, m,", "13, 1,55, m,", "pre_drilled = 1.55 by the file"),
    "a comma in SGF": ("cpt", "MA=0.80,", "MA=0,80,", "area_ratio = 0.8 by the file"),
    "water": ("gef", "\n#LASTSCAN", WATER.format("2.3, m"), "the file has a water level of 2.3 m"),
    "water by level": (
        "gef",
        "\n#LASTSCAN",
        WATER.format("-130, cm"),
        "the file has a water level of -1.3 m",
    ),
    "water in the BRO": (
        "xml",
        "<c:trajectory>",
        '<c:groundwaterLevel uom="m">2.3</c:groundwaterLevel><c:trajectory>',
        "the file has a water level of 2.3 m",
    ),
    "an open quote elsewhere": ("ags", '"DATA","1","A site,', '"DATA","1","A ""site,', 15.0),
    "a quote elsewhere": ("ags", '"A site, a ""quoted"" one"', '"3 2\'24.1"E"', 15.0),
    "lost readings": (
        "csv",
        "\n1.5,",
        "\n1.5,-2.58,0.01,0.03\n1.5,",
        "readings of qc left out that no cone can have: 1, the first -2.58 MPa, at line 7",
    ),
    "u2 in another unit": (
        "csv",
        "u2 [MPa]",
        "u2 [Pa]",
        "u2 is at most 0.25 Pa, where water has 1.1e+05 Pa: no filter measures, or not in Pa",
    ),
}
"""A kind of file, a text, what stands there instead, and a note, or the area of the cone [cm2]."""


@pytest.mark.parametrize("case", TOLD)
def test_what_a_file_says_beside_its_rows(folder: Path, case: str) -> None:
    kind, old, new, expected = TOLD[case]
    text = WRITERS[kind](rows_of(folder))
    assert old in text
    own = "area_ratio = 0.8" if kind == "csv" else ""
    found = columns_of(site_of(folder, kind, text.replace(old, new), ("area_ratio = 0.8", own)))
    if isinstance(expected, str):
        assert expected in found.notes
    else:
        assert found.cone_radius == pytest.approx(math.sqrt(1e-4 * expected / math.pi))


def as_ags_3(rows: list[Row]) -> str:
    data = "\n".join(
        f'"CPT1","{z!r}","' + '","'.join(cells((qc, 1e3 * fs, 1e3 * u2), "")) + '"\n"<CONT>",""'
        for z, qc, fs, u2 in rows
    )
    return f""""**PROJ"
"*PROJ_ID","*PROJ_NAME"
"1","A "quoted" one"

"**STCN"
"*HOLE_ID","*STCN_DPTH","*STCN_RES",
"*STCN_FRES","*STCN_PWP2"
"<UNITS>","m","MN/m2","kN/m2","kN/m2"
{data}
"""


def of_fixed_width(rows: list[Row], end: str) -> str:
    """Columns whose cells end together, or begin together; cells without a value are blank."""
    lines = ["".join(f"{cell:{end}24}" for cell in cells(row, "")) for row in rows]
    head = "".join(f"{name:{end}24}" for name in ("Depth", "Cone", "Friction", "Pore 2"))
    units = "".join(f"{unit:{end}24}" for unit in ("m", "MPa", "MPa", "MPa"))
    return "\n".join([" Cone :Cone Resistance, qc [MPa]", "", head, units, *lines])


def with_words(rows: list[Row], word: str) -> str:
    header, *lines = as_csv(rows).splitlines()
    return "\n".join([header, *(re.sub(r",(?=,|$)", f",{word}", line) for line in lines)])


def with_units_in_names(rows: list[Row]) -> str:
    header = "depth_m,qc_MPa,Sleeve friction MPa,u2_MPa"
    return "\n".join([header, *as_csv(rows).splitlines()[1:]])


def downward(rows: list[Row]) -> str:
    """A GEF whose corrected depths are negative."""
    return re.sub(r"(?m)^(\d\S+ \S+ )(\d)", r"\1-\2", as_gef(rows))


def in_two_pushes(rows: list[Row]) -> str:
    """The second push of a name, from another cone, in a file whose first is half of it."""
    first, second = as_sgf(rows[:50]), as_sgf(rows)
    return first.replace("MA=0.80", "MA=0.6") + second[second.index("$\nHA") :]


def again_from_the_top(rows: list[Row]) -> str:
    """A second push without a name of its own in a group of AGS."""
    data = as_ags(rows).partition('"2DP","2DP","2DP","2DP"\n')[2]
    return as_ags(rows[:50]) + data


WRITTEN: dict[str, tuple[str, Callable[[list[Row]], str], str]] = {
    "AGS 3": ("ags", as_ags_3, ""),
    "right": ("asc", lambda rows: of_fixed_width(rows, ">"), ""),
    "left": ("asc", lambda rows: of_fixed_width(rows, "<"), ""),
    "units in names": ("csv", with_units_in_names, ""),
    "a hyphen": ("csv", lambda rows: with_words(rows, "-"), ""),
    "of a workbook": ("csv", lambda rows: with_words(rows, "#N/A"), ""),
    "downward": ("gef", downward, "'Gecorrigeerde diepte' is negative downward in the file"),
    "pushes of CPT1": ("cpt", in_two_pushes, ""),
    "pushes of CPT1/1": ("ags", again_from_the_top, ""),
}
"""A kind of file, its writer, and a note."""


@pytest.mark.parametrize("case", WRITTEN)
def test_rows_are_the_same_however_a_program_writes_them(folder: Path, case: str) -> None:
    kind, writer, note = WRITTEN[case]
    rows = rows_of(folder)
    _, several, name = case.partition("pushes of ")
    named = f'\nsounding = "{name}/2"' if several else ""
    found = columns_of(site_of(folder, kind, writer(rows), ("[test]", f"[test]{named}")))
    expected = np.array(rows).T * np.array([1.0, 1e6, 1e6, 1e6])[:, None]
    np.testing.assert_allclose(list(found.values.values()), expected, rtol=1e-12)
    assert note in "; ".join(found.notes)
