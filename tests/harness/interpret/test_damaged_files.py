"""A damaged file of a cone test, or a site file that cannot be, is one line."""

import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.harness.conftest import Command, Refusal
from tests.harness.interpret.conftest import changed
from tests.harness.interpret.written_tests import WRITERS, rows_of, site_of


def replaced(old: str, new: str, count: int = 1) -> Callable[[bytes], bytes]:
    def damage(content: bytes) -> bytes:
        assert old.encode() in content, old
        return content.replace(old.encode(), new.encode(), count)

    return damage


def cut_after(text: str) -> Callable[[bytes], bytes]:
    return lambda content: content[: content.index(text.encode()) + len(text)]


BOMB = '<!DOCTYPE a [<!ENTITY a "x"><!ENTITY b "&a;&a;&a;">]><dispatchDataResponse'
AGS_3 = b'"**SCPT"\n"*HOLE_ID","*SCPT_DPTH"\n"CPT1","1.0"\n'
DAMAGED: dict[str, tuple[str, Callable[[bytes], bytes], str]] = {
    "empty": ("csv", lambda _: b"", "has no rows below its header"),
    "header alone": ("csv", cut_after("u2 [MPa]\n"), "has no rows below its header"),
    "binary": ("csv", lambda it: bytes(range(256)) + it, "null bytes: it is binary"),
    "UTF-16": ("csv", lambda it: it.decode().encode("utf-16"), "or UTF-16; save it as UTF-8"),
    "cut in a row": ("csv", cut_after("\n1.3,"), "line 5: has 2 values; must have one for each"),
    "text": ("csv", replaced("\n1.5,", "\n1.5,n/a"), "line 7, column 'qc [MPa]': 'n/a0."),
    "comma": (
        "csv",
        lambda it: it.replace(b",", b";").replace(b"\n1.5;", b"\n1,5;"),
        "'1,5' is no number; a number has a point",
    ),
    "no column": ("csv", replaced("qc [MPa]", "x [MPa]"), "has no column 'qc'"),
    "twice": ("csv", replaced("fs [MPa]", "qc [MPa]"), "2 columns may be qc: qc [MPa], qc [MPa]"),
    "unit of qc": (
        "csv",
        replaced("qc [MPa]", "qc [kPa]"),
        "only in 0% of the rows is qt above sigma_v0, which is at most 2.02e+05 Pa",
    ),
    "unit of fs": ("csv", replaced("\n1.5,", "\n1.5,0.1,9,9\n1.51,"), "fs = 9e+06 Pa, must be"),
    "a code of fs": ("csv", replaced("\n1.5,", "\n1.5,0.1,-0.999,0\n1.51,"), "fs = -999000 Pa"),
    "a code of u2": ("csv", replaced("\n1.5,", "\n1.5,0.1,0,-0.999\n1.51,"), "u2 = -999000 Pa"),
    "a code": ("csv", replaced("\n1.5,", "\n1.5,-9999,0,0\n1.51,"), "value: missing = [-9999] in"),
    "no unit": ("csv", replaced("qc [MPa]", "qc"), "has no unit"),
    "no u2": ("csv", replaced("u2 [MPa]", "other [MPa]"), "has no u2"),
    "unknown unit": ("csv", replaced("[MPa]", "[lb]"), "has unit 'lb'; allowed: Pa, kPa, MPa"),
    "levels": ("csv", replaced("\n1.0,", "\n12.5,"), "has levels, give ground_level"),
    "back": ("csv", replaced("\n1.5,", "\n1.3,"), "line 7: depth goes back from 1.4 to 1.3 m"),
    "no depth": ("csv", replaced("\n1.5,", "\n,"), "line 7: depth is missing"),
    "code": ("csv", replaced("\n1.5,", "\n1.5,-9.99,0,0\n1.51,"), "belongs under `missing`"),
    "infinite": ("csv", replaced("\n1.5,", "\n1.5,inf,0,0\n1.51,"), "leave the cell empty"),
    "no header": ("csv", lambda it: it.split(b"\n", 1)[1], "line 1 has values, and no line above"),
    "no depth at all": (
        "csv",
        lambda it: re.sub(rb"(?m)^[\d.]+,", b"nan,", it),
        "line 2: depth is missing",
    ),
    "upward": (
        "csv",
        lambda it: b"\n".join([*it.splitlines()[:1], *it.splitlines()[:0:-1]]),
        "its first row is the deepest, reverse the order of rows",
    ),
    "above": ("csv", replaced("\n1.0,", "\n-0.1,"), "only the first rows are above the ground"),
    "u2 from the sea bed": (
        "csv",
        replaced("\n1.5,", "\n1.5,1,0,-0.3\n1.51,"),
        "set to zero on the sea bed water_level is 0",
    ),
    "blanks": (
        "csv",
        lambda it: re.sub(rb"(?m)^(1\.5,[^,]*),[^,]*", rb"\1,", it).replace(b",", b"  "),
        "line 7: has 3 cells separated by blanks, the header has 4; where a value is missing",
    ),
    "header in a comment": ("csv", lambda it: b"# " + it, "line 1 among them; remove its #"),
    "too large": ("csv", lambda it: it + b" " * 20_000_000, "a test has at most 20000000"),
    "too many": ("csv", lambda it: it + b"9,9,9,9\n" * 20_000, "rows; a test has at most 20000"),
    "one long cell": ("csv", lambda it: it + b'"' + b"x" * 200_000, "is no table: field larger"),
    "GEF cut in its header": ("gef", cut_after("#COLUMNVOID"), "is no whole GEF: has no #EOH"),
    "GEF cut in a row": ("gef", cut_after("\n1.71; 0."), "line 29: has 2 values"),
    "GEF without rows": ("gef", cut_after("#EOH="), "has no rows below its header"),
    "GEF of a borehole": ("gef", replaced("CPT-Report", "BORE-Report"), "no cone test: GEF-BORE"),
    "GEF lacks a column": ("gef", replaced("#COLUMNINFO= 2", "#X"), "#COLUMNINFO must be there"),
    "GEF, a second area": (
        "gef",
        replaced("#MEASUREMENTVAR= 13,", "#MEASUREMENTVAR= 1, 1000, mm2, a\n#MEASUREMENTVAR= 13,"),
        "#MEASUREMENTVAR = 1 must be there once",
    ),
    "GEF, a column of many digits": (
        "gef",
        replaced("#COLUMNINFO= 2,", f"#COLUMNINFO= {'2' * 5000},"),
        "#COLUMNINFO must be there once for each column, from 1 on",
    ),
    "GEF, a separator in numbers": (
        "gef",
        replaced("#COLUMNSEPARATOR= ;", "#COLUMNSEPARATOR= 1"),
        "separators are '.', '1', '!': each must be one character of its own that is no part of",
    ),
    "GEF, a cone area of no number": (
        "gef",
        replaced("1, 1500, mm2", "1, 1_500, mm2"),
        "states cone_area by a text that is no number; the site file may state it",
    ),
    "GEF of levels": ("gef", replaced("; 1.0;", "; -1.0;"), "above the ground; where the file has"),
    "GEF, area ratio in %": ("gef", replaced(" 0.80,", " 80,"), "area_ratio = 80: must be > 0 and"),
    "XML cut": ("xml", cut_after("<c:values>"), "is no whole XML: no element found"),
    "XML with entities": ("xml", replaced("<dispatchDataResponse", BOMB), "has a document type"),
    "XML of a web page": ("xml", lambda _: b"<html><body/></html>", "has no cone test"),
    "XML, no token separator": (
        "xml",
        replaced('tokenSeparator=","', 'tokenSeparator=""'),
        "separators are '.', '', ';': each must be one character",
    ),
    "XML, no block separator": ("xml", replaced('="\x3b"', '=""'), "separators are '.', ',', ''"),
    "XML, no decimal separator": (
        "xml",
        replaced('decimalSeparator="."', 'decimalSeparator=""'),
        "separators are '', ',', ';'",
    ),
    "XML, two separators alike": (
        "xml",
        replaced('tokenSeparator=","', 'tokenSeparator=";"'),
        "separators are '.', ';', ';'",
    ),
    "XML, points beside decimal commas": (
        "xml",
        lambda it: re.sub(
            rb"<c:values>.*</c:values>",
            lambda values: values[0].replace(b",", b"|"),
            it.replace(b'tokenSeparator=","', b'tokenSeparator="|"').replace(b'="."', b'=","'),
        ),
        "is no number; a number has a point",
    ),
    "XML without values": ("xml", replaced("c:values", "c:other", 2), "lacks parameters, Text"),
    "AGS 3": ("ags", lambda _: AGS_3, "no group SCPT of AGS 4 with HEADING, UNIT and DATA; AGS 3"),
    "AGS, open quotes": ("ags", lambda it: it + b'"DATA","CPT1', "is no table: unexpected end"),
    "AGS, a quote": (
        "ags",
        lambda it: it + b'"DATA","CPT1","3 2\'24.1"","GRS80"\n',
        " is no table: ',' expected after '\"'; quotes in a text are doubled",
    ),
    "AGS of two tests": ("ags", replaced('"CPT1","1","1.0"', '"B","1","1.0"'), "has 2 tests: B/1"),
    "AGS, u2 without values": (
        "ags",
        lambda it: re.sub(rb'("DATA","CPT1"(,"[^"]*"){4},)"[^"]*"', rb'\1""', it),
        "has no u2, which the correction",
    ),
    "AGS without units": ("ags", replaced('"m","MN/m2"', '"",""'), "'SCPT_DPTH' has no unit"),
    "SGF of two tests": (
        "cpt",
        lambda it: it + it[it.index(b"$\nHA") :],
        "two cone tests called HK=CPT1; part",
    ),
    "SGF, a row above its test": (
        "cpt",
        lambda _: b"D=1.0,QC=2\n$\nHK=1\n#\nD=1,QC=3,U=2\n#$\n",
        "has no rows below its header",
    ),
    "SGF of another sounding": ("cpt", cut_after("R=0\n"), "has no cone test"),
    "site: no layer": ("toml", cut_after("u2 = 0 }"), "[[layer]] is missing"),
    "site: binary": ("toml", lambda it: b"\xff\x00" + it, "not UTF-8 at byte 0"),
}
IN_A_SITE_FILE = {
    "site: a name in a CSV": (
        "[test]",
        '[test]\nsounding = "A"',
        "sounding = 'A': the file has one",
    ),
    "site: unit of no column": (
        "[test]",
        '[test]\nunits = { inclination = "deg" }',
        "has no column 'inclination'; units of the site file has it",
    ),
    "site: a column of no name": (
        "[test]",
        '[test]\ncolumns = { fs = "x" }',
        "has no column 'x'",
    ),
    "site: no TOML": ("[test]", "[test", "not valid TOML"),
    "site: no area ratio": ("area_ratio = 0.8\n", "", "area_ratio: is missing"),
    "site: upside down": ("to = 10", "to = 1", "must be > 2"),
    "site: no test": ('"test.csv"', '"none.csv"', "No such file"),
    "site: huge number": ("= 120", f"= 1{400 * '0'}", "must be a number >= 15"),
    "site: not a number": ("= 0.4", "= nan", "must be a number >= 0 and <= 1"),
    "site: a folder": ('"test.csv"', '"."', "is not a regular file"),
    "site: a device": ('"test.csv"', '"/dev/zero"', "is not a regular file"),
}
"""A text, what stands there instead, and what is said of it."""
DAMAGED |= {
    name: ("toml", replaced(old, new), told) for name, (old, new, told) in IN_A_SITE_FILE.items()
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_damaged_file_is_one_line(folder: Path, damage: str, refusal: Refusal) -> None:
    """It names the file, and ends the command with 2 within seconds."""
    kind, harm, problem = DAMAGED[damage]
    name = "site.toml" if kind == "toml" else f"test.{kind}"
    table = "csv" if kind == "toml" else kind
    site_of(folder, table, WRITERS[table](rows_of(folder)))
    if kind != "csv":
        changed(folder, ("area_ratio = 0.8", "area_ratio = 0.8" if kind == "toml" else ""))
    (folder / name).write_bytes(harm((folder / name).read_bytes()))
    begin = time.process_time()
    line = refusal(["interpret", str(folder / "site.toml"), "--out", str(folder / "out")])
    assert time.process_time() - begin < 5.0
    assert str(folder) in line or "/dev/zero: " in line
    assert problem in line
    assert not (folder / "out").exists()


@pytest.mark.parametrize("damage", ["no file", "empty", "binary", "GEF cut in its header", "AGS 3"])
def test_no_site_file_is_written_for_a_test_that_cannot_be_read(
    here: Path, damage: str, refusal: Refusal
) -> None:
    kind, harm, problem = DAMAGED.get(damage, ("gef", None, "cannot be read: No such file"))
    if harm is not None:
        site_of(here, kind, WRITERS[kind](rows_of(here)))
        Path(f"test.{kind}").write_bytes(harm(Path(f"test.{kind}").read_bytes()))
    line = refusal(["new", "mine", "--interpret", f"test.{kind}"])
    assert line.startswith(f"harness: test.{kind}: ")
    assert problem in line
    assert not Path("mine.toml").exists()


@pytest.mark.parametrize("damage", ["no column", "twice", "unknown unit", "AGS of two tests"])
def test_a_new_site_file_is_told_what_it_has_to_name(
    here: Path, damage: str, command: Command
) -> None:
    kind, harm, problem = DAMAGED[damage]
    Path(f"test.{kind}").write_bytes(harm(WRITERS[kind](rows_of(here)).encode()))
    assert problem in command("new", "mine", "--interpret", f"test.{kind}").err.splitlines()[0]
    soundings = [it for it in Path("mine.toml").read_text().splitlines() if "#sounding" in it]
    one_of_two = ['#sounding = "B/1"', '#sounding = "CPT1/1"']
    assert soundings == (one_of_two if "two tests" in damage else ["#sounding = ..."])
