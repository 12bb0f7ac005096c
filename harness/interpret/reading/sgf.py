"""SGF: codes of the Swedish Geotechnical Society, as Geotech writes them."""

import re
from pathlib import Path

from harness.interpret.reading.contents import Heading, TestFile, one_of, stated_values
from harness.study.tables import StudyError

Codes = dict[str, str]
COLUMNS = {
    "D": ("penetrationlength", "m"),
    "QC": ("coneresistance", "MPa"),
    "FS": ("localfriction", "kPa"),
    "U": ("porepressureu2", "kPa"),
    "TA": ("inclinationresultant", "deg"),
}
"""Codes of a row, each with its quantity and fixed unit."""
STATED = {"area_ratio": ("MA", "-"), "pre_drilled": ("HO", "m"), "cone_area": ("MC", "cm2")}
BETWEEN_CODES = re.compile(r",(?=\s*%|[^,=]*=)")
"""A comma before a code; any other is a decimal comma."""


def read_sgf(path: Path, text: str, sounding: str | None) -> TestFile:
    """Each sounding has a line $, its codes, a line #, rows of codes as D=1.02, and a line #$.

    Rows without a depth are remarks. Soundings without QC are not cone tests. A second one of the
    same name, as of another push, is called NAME/2.
    """
    found: list[tuple[Codes, list[tuple[int, Codes]]]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if (mark := line.strip()) == "$":
            found.append(({}, []))
        pairs = (piece.partition("=") for piece in BETWEEN_CODES.split(mark))
        codes = {code.strip(): value.strip(" ,") for code, equals, value in pairs if equals}
        if "D" in codes:
            found[-1][1].append((number, codes))
        elif codes and not found[-1][1]:
            found[-1][0].update(codes)
    tests: dict[str, tuple[Codes, list[tuple[int, Codes]]]] = {}
    for place, (of_test, rows) in enumerate(found, start=1):
        if any("QC" in codes for _, codes in rows):
            name = of_test.get("HK") or f"test {place}"
            again = 2 + sum(it.startswith(f"{name}/") for it in tests)
            tests[f"{name}/{again}" if name in tests else name] = of_test, rows
    if not tests:
        raise StudyError(f"{path}: has no cone test: no sounding in it has the code QC")
    of_test, rows = tests[one_of(path, list(tests), sounding)]
    there = [code for code in COLUMNS if any(code in codes for _, codes in rows)]
    return TestFile(
        headings=[Heading(COLUMNS[it][0], it, COLUMNS[it][1]) for it in there],
        rows=[
            (number, [codes.get(code, "").replace(",", ".") for code in there])
            for number, codes in rows
        ],
        stated=stated_values(
            **{name: (of_test.get(code), None, unit) for name, (code, unit) in STATED.items()}
        ),
    )
