"""Files of cone tests: CSV, GEF, BRO and AGS 4 give the same columns; damaged ones one line."""

import re
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.interpret.columns import Columns, read_columns
from harness.interpret.site import load_site
from harness.study.tables import StudyError
from tests.harness.conftest import Command, Refusal
from tests.harness.interpret.conftest import LAYER, SITE, STRENGTH, changed

Row = tuple[float, float, float, float]
"""Depth [m], qc [MPa], fs [MPa] and u2 [MPa]; not a number where one is missing."""


def cells(values: Iterable[float], missing: str) -> list[str]:
    return [missing if np.isnan(it) else repr(it) for it in values]


def as_csv(rows: list[Row]) -> str:
    lines = [",".join(cells(row, "")) for row in rows]
    return "\n".join(["depth [m],qc [MPa],fs [MPa],u2 [MPa]", *lines]) + "\n"


def as_gef(rows: list[Row]) -> str:
    """Of release 1.1; the columns in another order, with the length of the rods among them."""
    data = "\n".join(
        "; ".join(cells((z + 0.01, u2, z, fs, qc), "-999.0")) + ";!" for z, qc, fs, u2 in rows
    )
    voids = "\n".join(f"#COLUMNVOID= {number}, -999.0" for number in range(1, 6))
    return f"""#GEFID= 1, 1, 0
#REPORTCODE= GEF-CPT-Report, 1, 1, 2, -
#COMPANYID= Gr\u00fcndung BV, 1, 31
#COLUMN= 5
#COLUMNINFO= 1, m, Sondeerlengte, 1
#COLUMNINFO= 2, MPa, Waterspanning, 6
#COLUMNINFO= 3, m, Gecorrigeerde diepte, 11
#COLUMNINFO= 4, Mpa, Plaatselijke wrijving, 3
#COLUMNINFO= 5, MPa, Conusweerstand, 2
{voids}
#MEASUREMENTVAR= 3, 0.80, -, netto oppervlaktequotient
#MEASUREMENTVAR= 13, 1.55, m, voorgeboord
#COLUMNSEPARATOR= ;
#RECORDSEPARATOR= !
#LASTSCAN= {len(rows)}
#EOH=
{data}
"""


def as_bro(rows: list[Row], name: str = "CPT000000000001") -> str:
    """The columns in the order of the parameters, those that are not measured among them."""
    data = ";".join(
        ",".join(cells((z + 0.01, z, qc, np.nan, fs, u2), "-999999")) for z, qc, fs, u2 in rows
    )
    measured = (
        ("penetrationLength", "ja"),
        ("depth", "ja"),
        ("coneResistance", "ja"),
        ("netConeResistance", "nee"),
        ("localFriction", "ja"),
        ("porePressureU2", "ja"),
    )
    parameters = "".join(f"<c:{it}>{answer}</c:{it}>" for it, answer in measured)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<dispatchDataResponse xmlns="http://www.broservices.nl/xsd/dscpt/1.1"
 xmlns:b="http://www.broservices.nl/xsd/brocommon/3.0" xmlns:swe="http://www.opengis.net/swe/2.0"
 xmlns:c="http://www.broservices.nl/xsd/cptcommon/1.1"><dispatchDocument><CPT_O>
<b:broId>{name}</b:broId><conePenetrometerSurvey>
<c:trajectory><c:predrilledDepth uom="m">1.55</c:predrilledDepth></c:trajectory>
<c:conePenetrometer><c:coneSurfaceQuotient>0.80</c:coneSurfaceQuotient></c:conePenetrometer>
<c:conePenetrationTest><c:cptResult><swe:encoding>
<swe:TextEncoding decimalSeparator="." tokenSeparator="," blockSeparator=";"/></swe:encoding>
<c:values>{data}</c:values></c:cptResult></c:conePenetrationTest>
<c:parameters>{parameters}</c:parameters>
</conePenetrometerSurvey></CPT_O></dispatchDocument></dispatchDataResponse>
"""


def as_ags(rows: list[Row], *names: str) -> str:
    """Groups PROJ, SCPG and SCPT of AGS 4.1; the same test at each name."""
    names = names or ("CPT1",)
    general = "\n".join(f'"DATA","{it}","1","0.80"' for it in names)
    data = "\n".join(
        f'"DATA","{it}","1","{z!r}","' + '","'.join(cells((qc, 1e3 * fs, 1e3 * u2), "")) + '"'
        for it in names
        for z, qc, fs, u2 in rows
    )
    return f""""GROUP","PROJ"
"HEADING","PROJ_ID","PROJ_NAME"
"UNIT","",""
"TYPE","ID","X"
"DATA","1","A site, a ""quoted"" one"

"GROUP","SCPG"
"HEADING","LOCA_ID","SCPG_TESN","SCPG_CAR"
"UNIT","","",""
"TYPE","ID","X","2DP"
{general}

"GROUP","SCPT"
"HEADING","LOCA_ID","SCPG_TESN","SCPT_DPTH","SCPT_RES","SCPT_FRES","SCPT_PWP2"
"UNIT","","","m","MN/m2","kN/m2","kN/m2"
"TYPE","ID","X","2DP","2DP","2DP","2DP"
{data}
"""


WRITERS: dict[str, Callable[[list[Row]], str]] = {
    "csv": as_csv,
    "gef": as_gef,
    "xml": as_bro,
    "ags": as_ags,
}


def rows_of(folder: Path) -> list[Row]:
    """The test of the folder, in which three values are missing."""
    text = (folder / "test.csv").read_text().splitlines()[1:]
    found = np.array([[float(it) for it in line.split(",")] for line in text])
    found[:, 2:] /= 1e3
    found[[10, 20, 30], [1, 2, 3]] = np.nan
    return [(z, qc, fs, u2) for z, qc, fs, u2 in found.tolist()]


def site_of(folder: Path, kind: str, text: str, *changes: tuple[str, str]) -> Path:
    """A site file for a test of a kind."""
    (folder / f"test.{kind}").write_text(text, encoding="latin-1" if kind == "gef" else "utf-8")
    (folder / "site.toml").write_text(SITE + LAYER)
    return changed(folder, ('"test.csv"', f'"test.{kind}"'), *changes)


def columns_of(path: Path) -> Columns:
    return read_columns(load_site(path).test)


@pytest.mark.parametrize("kind", WRITERS)
def test_every_kind_of_file_gives_the_same_columns(folder: Path, kind: str) -> None:
    rows = rows_of(folder)
    found = columns_of(site_of(folder, kind, WRITERS[kind](rows)))
    expected = np.array(rows).T * np.array([1.0, 1e6, 1e6, 1e6])[:, None]
    for values, exact in zip(found.values.values(), expected, strict=True):
        np.testing.assert_allclose(values, exact, rtol=1e-14)


@pytest.mark.parametrize("kind", ["gef", "xml", "ags"])
def test_what_a_file_says_of_the_cone_holds_where_the_site_file_says_nothing(
    folder: Path, kind: str
) -> None:
    said = site_of(folder, kind, WRITERS[kind](rows_of(folder)))
    assert columns_of(said).area_ratio == 0.8
    assert not columns_of(said).notes or kind != "ags"
    found = columns_of(changed(folder, ("area_ratio = 0.8", "")))
    assert found.area_ratio == 0.8
    assert "area_ratio = 0.8 by the file" in found.notes
    assert found.pre_drilled == (0.0 if kind == "ags" else 1.55)


@pytest.mark.parametrize("kind", WRITERS)
def test_a_file_of_each_kind_is_interpreted_in_one_command(
    folder: Path, kind: str, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    monkeypatch.chdir(folder)
    site_of(folder, kind, WRITERS[kind](rows_of(folder)))
    said = command("interpret", "site.toml").out
    assert said.startswith("2 to 10 m: su (isotropic, at 0.36 %/h)")
    found = xr.load_dataset("results/site_interpretation.nc")
    strength = found.strength.sel(percentile=50.0) / STRENGTH
    used = found.reason.values == 0
    assert used.sum() == 79  # of 81 depths one lacks qc and one u2
    told = "is not the result of a study, but of a measured test; `harness interpret site.toml`"
    for reader in ("status", "report", "plot", "compare"):
        assert told in command(reader, "results/site_interpretation.nc", code=2).err
    np.testing.assert_allclose(strength.values[used], 1.0, rtol=2e-4)
    assert command("status", code=2).err.startswith("harness: results: has no results")
    command("new", "mine", "--interpret", f"test.{kind}")
    assert ("\narea_ratio = 0.8" in (folder / "mine.toml").read_text()) == (kind != "csv")


@pytest.mark.parametrize(
    ("kind", "without"),
    [("gef", ("Gecorrigeerde diepte, 11", "x, 99")), ("xml", ("<c:depth>ja", "<c:depth>nee"))],
)
def test_the_length_of_the_rods_is_the_depth_where_there_is_no_other(
    folder: Path, kind: str, without: tuple[str, str]
) -> None:
    rows = rows_of(folder)
    text = WRITERS[kind](rows)
    assert without[0] in text
    found = columns_of(site_of(folder, kind, text.replace(*without)))
    np.testing.assert_allclose(found.values["depth"], [row[0] + 0.01 for row in rows])


def test_the_length_of_the_rods_is_corrected_by_inclination(folder: Path) -> None:
    """At 10 degrees all along, but for a missing value: cos 10 of the way from the first row on."""
    text = as_gef(rows_of(folder)).replace("Gecorrigeerde diepte, 11", "Helling, 8")
    text = text.replace("#COLUMNINFO= 3, m,", "#COLUMNINFO= 3, Graden(deg),")
    head, end, data = text.partition("#EOH=\n")
    lines = [line.split("; ") for line in data.splitlines()]
    for number, line in enumerate(lines):
        line[2] = "10.0" if number != 5 else "-999.0"
    tilted = head + end + "\n".join(map("; ".join, lines)) + "\n"
    found = columns_of(site_of(folder, "gef", tilted))
    way = np.array([row[0] for row in rows_of(folder)]) - rows_of(folder)[0][0]
    expected = rows_of(folder)[0][0] + 0.01 + np.cos(np.radians(10.0)) * way
    np.testing.assert_allclose(found.values["depth"], expected, rtol=1e-12)
    assert "depth corrected by inclination, by 0.17 m at the end" in found.notes


def test_an_inclination_that_the_site_file_names_corrects_the_depth(folder: Path) -> None:
    """In two planes: 1 / sqrt(1 + 2 tan^2 5)."""
    measured = rows_of(folder)
    lines = as_csv(measured).splitlines()
    rows = [f"{lines[0]},X [deg],Y [deg]", *(f"{line},5,-5" for line in lines[1:])]
    named = "columns = { inclination = 'X', inclination_across = 'Y' }\narea_ratio"
    site = site_of(folder, "csv", "\n".join(rows), ("area_ratio", named))
    depth = columns_of(site).values["depth"]
    steps = np.diff(depth) / np.diff([row[0] for row in measured])
    np.testing.assert_allclose(steps, 1.0 / np.sqrt(1.0 + 2.0 * np.tan(np.radians(5.0)) ** 2))
    steep = "\n".join(rows).replace(",5,-5", ",50,-5")
    (folder / "test.csv").write_text(steep)
    with pytest.raises(StudyError, match="inclination of 50 degrees, must be <= 45; look at its u"):
        columns_of(site)


def test_what_exports_have_around_their_rows(folder: Path) -> None:
    """Lines above the header, units below it, names of several words, a superscript."""
    rows = rows_of(folder)
    body = [";".join(cells(row, "")).replace(".", ",") for row in rows]
    head = [
        "Project: Quay;;;",
        "",
        "Depth;Cone Resistance;Sleeve friction;U2",
        "[m];MPa;MN/m\u00b2;MPa",
    ]
    found = columns_of(site_of(folder, "csv", "\n".join([*head, *body])))
    for name, column in zip(("depth", "qc", "fs", "u2"), np.array(rows).T, strict=True):
        np.testing.assert_allclose(found.values[name], column * (1.0 if name == "depth" else 1e6))
    assert "1 lines above the header left out" in found.notes


def test_what_the_two_files_say_otherwise_of_the_cone_is_told(folder: Path) -> None:
    path = site_of(folder, "gef", as_gef(rows_of(folder)), ("area_ratio = 0.8", "area_ratio = 0.6"))
    found = columns_of(path)
    assert found.area_ratio == 0.6
    assert "area_ratio = 0.6 by the site file, 0.8 by the file" in found.notes


def test_rows_of_the_bro_may_stand_in_any_order(folder: Path) -> None:
    rows = rows_of(folder)
    shuffled = [rows[it] for it in np.random.default_rng(1).permutation(len(rows))]
    found = columns_of(site_of(folder, "xml", as_bro(shuffled)))
    np.testing.assert_array_equal(found.values["depth"], [row[0] for row in rows])
    np.testing.assert_allclose(found.values["u2"], 1e6 * np.array(rows)[:, 3])


def test_changes_of_rods_and_gaps_are_told(folder: Path) -> None:
    rows = rows_of(folder)
    back = [(rows[40][0] - it, *rows[40][1:]) for it in (0.0, 0.04)]
    found = columns_of(site_of(folder, "csv", as_csv(rows[:41] + back + rows[41:60] + rows[80:])))
    assert len(found.values["depth"]) == len(rows) - 20
    assert found.notes == (
        "2 rows left out in which the tip stands or goes back",
        "no values from 6.9 to 9 m",
    )


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_commas_are_read_where_the_cells_are_not_parted_by_commas(
    folder: Path, delimiter: str
) -> None:
    rows = rows_of(folder)
    text = as_csv(rows).replace(",", delimiter).replace(".", ",")
    found = columns_of(site_of(folder, "csv", text))
    assert found.notes == ("numbers have a decimal comma",)
    np.testing.assert_array_equal(found.values["depth"], [row[0] for row in rows])


def test_levels_become_depths(folder: Path) -> None:
    rows = rows_of(folder)
    levels = as_csv([(round(4.5 - z, 3), *others) for z, *others in rows])
    found = columns_of(site_of(folder, "csv", levels, ("[test]", "[test]\nground_level = 4.5")))
    np.testing.assert_allclose(found.values["depth"], [row[0] for row in rows])


def test_of_several_soundings_one_is_named(folder: Path) -> None:
    text = as_ags(rows_of(folder), "CPT1", "CPT2")
    path = site_of(folder, "ags", text, ("[test]", '[test]\nsounding = "CPT2/1"'))
    assert len(columns_of(path).values["depth"]) == len(rows_of(folder))
    with pytest.raises(StudyError, match=r"'CPT3/1': is not there.*; has CPT1/1, CPT2/1"):
        columns_of(changed(folder, ("CPT2/1", "CPT3/1")))


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
    "no column": ("csv", replaced("fs [MPa]", "x [MPa]"), "has no column 'fs'"),
    "twice": ("csv", replaced("fs [MPa]", "qc [MPa]"), "2 columns may be qc: qc [MPa], qc [MPa]"),
    "unit of qc": ("csv", replaced("qc [MPa]", "qc [kPa]"), "nowhere above sigma_v0, 2.02e+05 Pa"),
    "unit of fs": ("csv", replaced("\n1.5,", "\n1.5,0.1,9,9\n1.51,"), "fs = 9e+06 Pa, must be"),
    "a code": ("csv", replaced("\n1.5,", "\n1.5,-9999,0,0\n1.51,"), "as missing = [-9999]"),
    "no unit": ("csv", replaced("qc [MPa]", "qc"), "has no unit"),
    "no u2": ("csv", replaced("u2 [MPa]", "other [MPa]"), "has no u2"),
    "unknown unit": ("csv", replaced("[MPa]", "[psi]"), "has unit 'psi'; allowed: Pa, kPa, MPa"),
    "back": ("csv", replaced("\n1.5,", "\n1.3,"), "line 7: depth goes back from 1.4 to 1.3 m"),
    "no depth": ("csv", replaced("\n1.5,", "\n,"), "line 7: depth is missing"),
    "code": ("csv", replaced("\n1.5,", "\n1.5,-9.99,0,0\n1.51,"), "belongs under `missing`"),
    "infinite": ("csv", replaced("\n1.5,", "\n1.5,inf,0,0\n1.51,"), "qc = inf Pa, must be"),
    "too large": ("csv", lambda it: it + b" " * 20_000_000, "a test has at most 20000000"),
    "too many": ("csv", lambda it: it + b"9,9,9,9\n" * 20_000, "rows; a test has at most 20000"),
    "one long cell": ("csv", lambda it: it + b'"' + b"x" * 200_000, "is no table: field larger"),
    "GEF cut in its header": ("gef", cut_after("#COLUMNVOID"), "is no whole GEF: has no #EOH"),
    "GEF cut in a row": ("gef", cut_after("\n1.71; 0."), "line 28: has 2 values"),
    "GEF without rows": ("gef", cut_after("#EOH="), "has no rows of values"),
    "GEF of a borehole": ("gef", replaced("CPT-Report", "BORE-Report"), "no cone test: GEF-BORE"),
    "GEF lacks a column": ("gef", replaced("#COLUMNINFO= 2", "#X"), "#COLUMNINFO must be there"),
    "GEF of levels": ("gef", replaced("; 1.0;", "; -1.0;"), "above the ground; where the file has"),
    "GEF, area ratio in %": ("gef", replaced(" 0.80,", " 80,"), "area_ratio = 80: must be > 0 and"),
    "XML cut": ("xml", cut_after("<c:values>"), "is no whole XML: no element found"),
    "XML with entities": ("xml", replaced("<dispatchDataResponse", BOMB), "has a document type"),
    "XML of a web page": ("xml", lambda _: b"<html><body/></html>", "has no cone test"),
    "XML without values": ("xml", replaced("c:values", "c:other", 2), "lacks parameters, Text"),
    "AGS 3": ("ags", lambda _: AGS_3, "no group SCPT of AGS 4 with HEADING, UNIT and DATA; AGS 3"),
    "AGS, open quotes": ("ags", lambda it: it + b'"DATA","CPT1', "is no table: unexpected end"),
    "AGS of two tests": ("ags", replaced('"CPT1","1","1.0"', '"B","1","1.0"'), "has 2 tests: B/1"),
    "AGS, u2 without values": (
        "ags",
        lambda it: re.sub(rb'("DATA","CPT1"(,"[^"]*"){4},)"[^"]*"', rb'\1""', it),
        "has no u2, which the correction",
    ),
    "AGS without units": ("ags", replaced('"m","MN/m2"', '"",""'), "'SCPT_DPTH' has no unit"),
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
    "site: no TOML": ("[test]", "[test", "not valid TOML"),
    "site: no area ratio": ("area_ratio = 0.8\n", "", "area_ratio: is missing"),
    "site: upside down": ("to = 10", "to = 1", "must be > 2"),
    "site: no test": ('"test.csv"', '"none.csv"', "No such file"),
    "site: huge number": ("= 120", f"= 1{400 * '0'}", "must be a number >= 15"),
    "site: not a number": ("= 0.4", "= nan", "must be a number >= 0 and <= 1"),
    "site: a folder": ('"test.csv"', '"."', "is no ordinary file"),
    "site: a device": ('"test.csv"', '"/dev/zero"', "is no ordinary file"),
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
    folder: Path, damage: str, monkeypatch: pytest.MonkeyPatch, refusal: Refusal
) -> None:
    monkeypatch.chdir(folder)
    kind, harm, problem = DAMAGED.get(damage, ("gef", None, "cannot be read: No such file"))
    if harm is not None:
        site_of(folder, kind, WRITERS[kind](rows_of(folder)))
        Path(f"test.{kind}").write_bytes(harm(Path(f"test.{kind}").read_bytes()))
    line = refusal(["new", "mine", "--interpret", f"test.{kind}"])
    assert line.startswith(f"harness: test.{kind}: ")
    assert problem in line
    assert not Path("mine.toml").exists()


@pytest.mark.parametrize("damage", ["no column", "twice", "unknown unit", "AGS of two tests"])
def test_a_new_site_file_is_told_what_it_has_to_name(
    folder: Path, damage: str, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    monkeypatch.chdir(folder)
    kind, harm, problem = DAMAGED[damage]
    Path(f"test.{kind}").write_bytes(harm(WRITERS[kind](rows_of(folder)).encode()))
    assert problem in command("new", "mine", "--interpret", f"test.{kind}").err.splitlines()[0]
    assert Path("mine.toml").exists()
