"""AGS 4 (groups SCPG and SCPT) and AGS 3 (group STCN)."""

import csv
import math
from collections.abc import Sequence
from pathlib import Path

from harness.interpret.reading.contents import Heading, TestFile, numbers_of, one_of, stated_values
from harness.study.tables import StudyError

Row = tuple[int, list[str]]
"""A line and its cells."""
Group = dict[str, list[Row]]
"""Rows of a group by their kind: HEADING, UNIT and DATA."""
TESTS, CONES = ("SCPT", "STCN"), "SCPG"
BACK = 0.5
"""Way back [m] after which another push begins; at a change of rods it is a tenth of it at most."""
STATED = {
    "area_ratio": ("SCPG_CAR", "-"),
    "cone_area": ("SCPG_CSA", "cm2"),
    "water_level": ("SCPG_WAT", "m"),
}
"""Headings of `CONES`, and their units by the format."""


def read_ags(path: Path, text: str, sounding: str | None) -> TestFile:
    """Groups of rows, one a line; each push is a test of its own, with its own cone."""
    groups = _groups(path, text)
    test = next((groups[name] for name in TESTS if name in groups), {})
    if not {"HEADING", "UNIT", "DATA"} <= test.keys():
        raise StudyError(
            f"{path}: has no group SCPT of AGS 4, or STCN of AGS 3, with headings, units and rows"
        )
    (_, titles), (_, units) = test["HEADING"][0], test["UNIT"][0]
    pushes = _pushes(titles, test["DATA"])
    chosen = one_of(path, list(pushes), sounding)
    return TestFile(
        headings=[
            Heading(title.lower().replace("stcn_", "scpt_"), title, unit)
            for title, unit in zip(titles, units + [""] * len(titles), strict=False)
        ],
        rows=pushes[chosen],
        stated=_stated(path, groups.get(CONES, {}), _name(titles, pushes[chosen][0][1])),
    )


def _groups(path: Path, text: str) -> dict[str, Group]:
    """The groups by name; a damaged line matters in those of tests and cones only."""
    groups: dict[str, Group] = {}
    name, group = "", Group()
    for number, line in enumerate(text.replace("\r\n", "\n").split("\n"), start=1):
        try:
            kind, *cells = (
                cell.strip() for cell in next(csv.reader([line], strict=True), []) or [""]
            )
        except csv.Error as error:
            if name in (*TESTS, CONES) or line.startswith(('"GROUP"', '"**')):
                raise StudyError(
                    f"{path}: line {number} is no table: {error}; quotes in a text are doubled"
                ) from None
            continue
        is_3 = kind.startswith("**")
        if is_3 or (kind == "GROUP" and cells):
            name = kind.strip("*?") if is_3 else cells[0]
            group = groups.setdefault(name, Group())
        elif kind.startswith("*"):  # of AGS 3, and long ones go on in the next line
            titles = [title.strip("*?") for title in (kind, *cells)]
            group.setdefault("HEADING", [(number, [])])[0][1].extend(filter(None, titles))
        elif kind == "<UNITS>":
            group["UNIT"] = [(number, ["", *cells])]
        elif kind in ("HEADING", "UNIT", "DATA"):
            group.setdefault(kind, []).append((number, cells))
        elif kind and name == TESTS[1] and kind != "<CONT>":
            group.setdefault("DATA", []).append((number, [kind, *cells]))
    return groups


def _pushes(titles: Sequence[str], rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows by the name of their push; where the depth goes back another one begins, NAME/2."""
    pushes: dict[str, list[Row]] = {}
    place = next((it for it, title in enumerate(titles) if title.endswith("_DPTH")), 0)
    now: dict[str, tuple[str, float]] = {}  # by name of the test, its push and depth
    for row in rows:
        name = _name(titles, row[1])
        push, before = now.get(name, (name, -math.inf))
        depth = next(iter(numbers_of(row[1][place : place + 1])), before)
        if depth < before - BACK:
            push = f"{name}/{2 + sum(it.startswith(f'{name}/') for it in pushes)}"
        now[name] = push, depth
        pushes.setdefault(push, []).append(row)
    return pushes


def _name(titles: Sequence[str], cells: Sequence[str]) -> str:
    """Location and test of a row, as CPT1/2, or CPT1 if the test has no name."""
    row = dict(zip(titles, cells, strict=False))
    places, pushes = ("LOCA_ID", "HOLE_ID"), ("SCPG_TESN", "STCN_TESN")
    return "/".join(filter(None, (row.get(it, "") for it in (*places, *pushes))))


def _stated(path: Path, cones: Group, chosen: str) -> dict[str, float]:
    """What the group of cones says of a test."""
    titles, units = (cones.get(kind, [(0, [])])[0][1] for kind in ("HEADING", "UNIT"))
    unit = dict(zip(titles, units, strict=False))
    of_all = []
    for cells in (cells for _, cells in cones.get("DATA", []) if _name(titles, cells) == chosen):
        row = dict(zip(titles, cells, strict=False))
        given = {name: (row.get(it), unit.get(it), usual) for name, (it, usual) in STATED.items()}
        of_all.append(stated_values(**given))
    if any(own != of_all[0] for own in of_all):
        raise StudyError(
            f"{path}: group {CONES} has {len(of_all)} rows of {chosen} that differ; give each push "
            "a SCPG_TESN of its own, in SCPT too"
        )
    return of_all[0] if of_all else {}
