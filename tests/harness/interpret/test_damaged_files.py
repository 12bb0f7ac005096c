"""A damaged file of a cone test, or a site file that cannot be, is one line."""

import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.harness.conftest import Command, Refusal
from tests.harness.interpret.conftest import LAYER, changed
from tests.harness.interpret.written_tests import WRITERS, rows_of, site_of


def replaced(old: str, new: str) -> Callable[[bytes], bytes]:
    def damage(content: bytes) -> bytes:
        assert old.encode() in content, old
        return content.replace(old.encode(), new.encode(), 1)

    return damage


def cut_after(text: str) -> Callable[[bytes], bytes]:
    return lambda content: content[: content.index(text.encode()) + len(text)]


BOMB = '<!DOCTYPE a [<!ENTITY a "x"><!ENTITY b "&a;&a;&a;">]><dispatchDataResponse'
AGS_3 = b'"**STCN"\n"*HOLE_ID","*STCN_DPTH"\n"CPT1","1.0"\n'
SECOND_AREA = "#MEASUREMENTVAR= 1, 1000, mm2, a\n#MEASUREMENTVAR= 13,"
MANY_DIGITS = f"#COLUMNINFO= {'2' * 5000},"
LOST = "\n1.5,{0}\n1.51,{0}\n1.52,{0}\n1.53,"
"""Three rows beside some hundred others; one of a reading that cannot be would be left out."""
ARTESIAN = "u0 = { depth = [0, 5, 12], value = [0, 49, 300] }"
SHORT_U0 = "u0 = { depth = [0, 5], value = [0, 49] }"
REPLACED: dict[str, tuple[str, str, str]] = {
    "csv: a text": ("\n1.5,", "\n1.5,n/a", "line 7, column 'qc [MPa]': 'n/a0."),
    "csv: no column": ("qc [MPa]", "x [MPa]", "has no column 'qc'"),
    "csv: a column twice": ("fs [MPa]", "qc [MPa]", "2 columns may be qc: qc [MPa], qc [MPa]"),
    "csv: unit of qc": (
        "qc [MPa]",
        "qc [kPa]",
        "fs / qc is 25 (median), in soil it is 0.001 to 0.1; qc is read in kPa, fs in MPa",
    ),
    "csv: unit of fs": ("\n1.5,", "\n1.5,0.1,9,9\n1.51,", "fs = 9 MPa, must be"),
    "csv: unit of all fs": ("fs [MPa]", "fs [kPa]", "fs / qc is 2.5e-05 (median), in soil it is"),
    "csv: another push": (
        "\n1.5,",
        "\n9,1,0.01,0.1\n1.5,",
        "from 9 to 1.5 m; at most 0.05 m are allowed, for a change of rods; where another push",
    ),
    "csv: a code of fs": ("\n1.5,", LOST.format("0.1,-0.999,0"), "fs = -0.999 MPa"),
    "csv: a code of u2": ("\n1.5,", LOST.format("0.1,0,-0.999"), "u2 = -0.999 MPa"),
    "csv: a code": ("\n1.5,", "\n1.5,-9999,0,0\n1.51,", "value: missing = [-9999] in"),
    "csv: a code of two decimals": ("\n1.5,", LOST.format("-9.99,0,0"), "belongs under `missing`"),
    "csv: no unit": ("qc [MPa]", "qc", "has no unit"),
    "csv: unknown unit": ("[MPa]", "[lb]", "has unit 'lb'; allowed: Pa, kPa, MPa"),
    "csv: levels": ("\n1.0,", "\n12.5,", "has levels, give ground_level"),
    "csv: a row that goes back": ("\n1.5,", "\n1.3,", "line 7: depth goes back from 1.4 to 1.3 m"),
    "csv: no depth": ("\n1.5,", "\n,", "line 7: depth is missing"),
    "csv: depths in mm": ("\n11.9,", "\n11900,", "depth 11900 m must be <= 1000; look at its unit"),
    "csv: infinite": ("\n1.5,", "\n1.5,inf,0,0\n1.51,", "leave the cell empty"),
    "csv: above": ("\n1.0,", "\n-0.1,", "only the first rows are above the ground"),
    "csv: a decimal comma": ("\n1.0,", "\n1,0,", "line 2: has 5 values, the header names 4; n"),
    "csv: u2 from the sea bed": (
        "\n1.5,",
        LOST.format("1,0,-0.3"),
        "set to zero on the sea bed water_level is 0",
    ),
    "gef: a borehole": ("CPT-Report", "BORE-Report", "no cone test: GEF-BORE"),
    "gef: lacks a column": ("#COLUMNINFO= 2", "#X", "#COLUMNINFO must be there"),
    "gef: a second area": (
        "#MEASUREMENTVAR= 13,",
        SECOND_AREA,
        "#MEASUREMENTVAR = 1 must be there",
    ),
    "gef: a column of many digits": ("#COLUMNINFO= 2,", MANY_DIGITS, "for each column, from 1 on"),
    "gef: a separator in numbers": (
        "#COLUMNSEPARATOR= ;",
        "#COLUMNSEPARATOR= 1",
        "separators are '.', '1', '!': each must be one character of its own that is no",
    ),
    "gef: a cone area of no number": (
        "1, 1500, mm2",
        "1, 1_500, mm2",
        "states cone_area by a text that is no number; the site file may state it",
    ),
    "gef: a cone area in no unit": (
        "1, 1500, mm2",
        "1, 15, -",
        "cone_area = 0.15: must be >= 1 and <= 100; the site file may state another",
    ),
    "gef: levels": ("; 1.0;", "; -1.0;", "above the ground; where the file has"),
    "gef: area ratio in %": (" 0.80,", " 80,", "area_ratio = 80: must be > 0 and"),
    "xml: entities": ("<dispatchDataResponse", BOMB, "has a document type"),
    "xml: no token separator": (
        'tokenSeparator=","',
        'tokenSeparator=""',
        "separators are '.', '', ",
    ),
    "xml: no block separator": ('="\x3b"', '=""', "separators are '.', ',', '': each must be one"),
    "xml: two separators alike": (
        'tokenSeparator=","',
        'tokenSeparator=";"',
        "separators are '.', ';', ';'",
    ),
    "xml: no decimal separator": (
        'decimalSeparator="."',
        'decimalSeparator=""',
        "separators are '', ',', ';'",
    ),
    "ags: two cones of one push": (
        '"DATA","CPT1","1","0.80","15"',
        '"DATA","CPT1","1","0.80","15"\n"DATA","CPT1","1","0.75","10"',
        "group SCPG has 2 rows of CPT1/1 that differ; give each push a SCPG_TESN of its own",
    ),
    "ags: two tests": ('"CPT1","1","1.0"', '"B","1","1.0"', "has 2 tests: B/1"),
    "ags: no units": ('"m","MN/m2"', '"",""', "'SCPT_DPTH' has no unit"),
    "toml: a name in a CSV": (
        "[test]",
        '[test]\nsounding = "A"',
        "sounding = 'A': the file has one",
    ),
    "toml: unit of no column": (
        "[test]",
        '[test]\nunits = { inclination = "deg" }',
        "has no column 'inclination'; units of the site file has it",
    ),
    "toml: a column of no name": ("[test]", '[test]\ncolumns = { fs = "x" }', "has no column 'x'"),
    "toml: no TOML": ("[test]", "[test", "not valid TOML"),
    "toml: no area ratio": ("area_ratio = 0.8\n", "", "area_ratio: is missing"),
    "toml: upside down": ("to = 10", "to = 1", "must be > 2"),
    "toml: no test": ('"test.csv"', '"none.csv"', "No such file"),
    "toml: huge number": ("= 120", f"= 1{400 * '0'}", "must be a number >= 15"),
    "toml: not a number": ("= 0.4", "= nan", "must be a number >= 0 and <= 1"),
    "toml: a folder": ('"test.csv"', '"."', "is not a regular file"),
    "toml: a device": ('"test.csv"', '"/dev/zero"', "is not a regular file"),
    "toml: no effective stress": (
        "water_level = 1.0",
        ARTESIAN,
        "unit_weight: sigma_v0 is not above u0 from 7 m on",
    ),
    "toml: u0 of a part": (
        "water_level = 1.0",
        SHORT_U0,
        "u0: is given from 0 to 5 m, the test goes from 1 to 11.9 m",
    ),
}
"""A kind of file, and what is wrong: a text, what stands there instead, and what is said of it."""
HARMED: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "csv: empty": (lambda _: b"", "has no rows below its header"),
    "csv: header alone": (cut_after("u2 [MPa]\n"), "has no rows below its header"),
    "csv: binary": (lambda it: bytes(range(256)) + it, "null bytes: it is binary"),
    "csv: a workbook": (lambda _: b"PK\x03\x04...", "is a workbook; save the sheet as CSV"),
    "csv: UTF-16": (lambda it: it.decode().encode("utf-16"), "or UTF-16; save it as UTF-8"),
    "csv: cut in a row": (cut_after("\n1.3,"), "line 5: has 2 values; must have one for each"),
    "csv: decimal commas in one row": (
        lambda it: it.replace(b",", b";").replace(b"\n1.5;", b"\n1,5;"),
        "'1,5' is no number; a number has a point",
    ),
    "csv: no header": (lambda it: it.split(b"\n", 1)[1], "line 1 has values, and no line above"),
    "csv: no depth at all": (
        lambda it: re.sub(rb"(?m)^[\d.]+,", b"nan,", it),
        "line 2: depth is missing",
    ),
    "csv: upward": (
        lambda it: b"\n".join([*it.splitlines()[:1], *it.splitlines()[:0:-1]]),
        "its first row is the deepest, reverse the order of rows",
    ),
    "csv: blanks": (
        lambda it: re.sub(rb"(?m)^(1\.5,[^,]*),[^,]*", rb"\1,", it).replace(b",", b"  "),
        "line 7: has 3 cells separated by blanks, the header has 4; where a value is missing",
    ),
    "csv: header in a comment": (lambda it: b"# " + it, "line 1 among them; remove its #"),
    "csv: too large": (lambda it: it + b" " * 20_000_000, "a test has at most 20000000"),
    "csv: too many": (lambda it: it + b"9,9,9,9\n" * 20_000, "rows; a test has at most 20000"),
    "csv: one long cell": (lambda it: it + b'"' + b"x" * 200_000, "is no table: field larger"),
    "gef: cut in its header": (cut_after("#COLUMNVOID"), "is no whole GEF: has no #EOH"),
    "gef: cut in a row": (cut_after("\n1.71; 0."), "line 29: has 2 values"),
    "xml: cut": (cut_after("<c:values>"), "is no whole XML: no element found"),
    "xml: a web page": (lambda _: b"<html><body/></html>", "has no cone test"),
    "xml: no values": (lambda it: it.replace(b"c:values", b"c:other"), "lacks parameters"),
    "xml: points beside decimal commas": (
        lambda it: re.sub(
            rb"<c:values>.*</c:values>",
            lambda values: values[0].replace(b",", b"|"),
            it.replace(b'tokenSeparator=","', b'tokenSeparator="|"').replace(b'="."', b'=","'),
        ),
        "is no number; a number has a point",
    ),
    "ags: AGS 3": (
        lambda _: AGS_3,
        "no group SCPT of AGS 4, or STCN of AGS 3, with headings, units",
    ),
    "ags: open quotes": (lambda it: it + b'"DATA","CPT1', "is no table: unexpected end"),
    "ags: a quote": (
        lambda it: it + b'"DATA","CPT1","3 2\'24.1"","GRS80"\n',
        " is no table: ',' expected after '\"'; quotes in a text are doubled",
    ),
    "cpt: two tests": (
        lambda it: it + it[it.index(b"$\nHA") :],
        "has 2 tests: CPT1, CPT1/2; name one in the site file, as sounding",
    ),
    "cpt: a row above its test": (
        lambda _: b"D=1.0,QC=2\n$\nHK=1\n#\nD=1,QC=3,U=2\n#$\n",
        "has no rows below its header",
    ),
    "cpt: another sounding": (cut_after("R=0\n"), "has no cone test"),
    "toml: no layer": (cut_after("u2 = 0 }"), "[[layer]] is missing"),
    "toml: binary": (lambda it: b"\xff\x00" + it, "not UTF-8 at byte 0"),
    "toml: two layers of a title": (
        lambda it: (
            it.replace(b"\nfrom = 2", b"\ntitle = 'clay'\nfrom = 2")
            + LAYER.replace("from = 2\nto = 10", "title = 'clay'\nfrom = 10\nto = 11").encode()
        ),
        "[[layer]] 2 title = 'clay': another layer has it",
    ),
}
"""A kind of file, and what is wrong: what becomes of its content, and what is said of it."""
DAMAGED = HARMED | {name: (replaced(old, new), told) for name, (old, new, told) in REPLACED.items()}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_damaged_file_is_one_line(folder: Path, damage: str, refusal: Refusal) -> None:
    """It names the file, and ends the command with 2 within seconds."""
    kind, (harm, problem) = damage.partition(":")[0], DAMAGED[damage]
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


@pytest.mark.parametrize(
    "damage", ["gef: no file", "csv: empty", "csv: binary", "gef: cut in its header", "ags: AGS 3"]
)
def test_a_test_that_is_not_read_gets_no_site_file(
    here: Path, damage: str, refusal: Refusal
) -> None:
    kind = damage.partition(":")[0]
    harm, problem = DAMAGED.get(damage, (None, "cannot be read: No such file"))
    if harm is not None:
        site_of(here, kind, WRITERS[kind](rows_of(here)))
        Path(f"test.{kind}").write_bytes(harm(Path(f"test.{kind}").read_bytes()))
    line = refusal(["new", "mine", "--interpret", f"test.{kind}"])
    assert line.startswith(f"harness: test.{kind}: ")
    assert problem in line
    assert not Path("mine.toml").exists()


@pytest.mark.parametrize(
    "damage", ["csv: no column", "csv: a column twice", "csv: unknown unit", "ags: two tests"]
)
def test_a_new_site_file_is_told_what_to_name(here: Path, damage: str, command: Command) -> None:
    kind, (harm, problem) = damage.partition(":")[0], DAMAGED[damage]
    Path(f"test.{kind}").write_bytes(harm(WRITERS[kind](rows_of(here)).encode()))
    assert problem in command("new", "mine", "--interpret", f"test.{kind}").err.splitlines()[0]
    soundings = [
        it for it in Path("mine.toml").read_text(encoding="utf-8").splitlines() if "#sounding" in it
    ]
    one_of_two = ['#sounding = "B/1"', '#sounding = "CPT1/1"']
    assert soundings == (one_of_two if "two tests" in damage else ["#sounding = ..."])
