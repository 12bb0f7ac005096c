"""Files of cone tests: CSV, GEF, BRO and AGS 4 give the same columns."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.study.tables import StudyError
from tests.harness.conftest import Command, Refusal
from tests.harness.interpret.conftest import STRENGTH, changed
from tests.harness.interpret.written_tests import (
    WRITERS,
    as_ags,
    as_bro,
    as_csv,
    as_gef,
    as_sgf,
    cells,
    columns_of,
    rows_of,
    site_of,
)


@pytest.mark.parametrize("kind", WRITERS)
def test_every_kind_of_file_gives_the_same_columns(folder: Path, kind: str) -> None:
    rows = rows_of(folder)
    found = columns_of(site_of(folder, kind, WRITERS[kind](rows)))
    expected = np.array(rows).T * np.array([1.0, 1e6, 1e6, 1e6])[:, None]
    for values, exact in zip(found.values.values(), expected, strict=True):
        np.testing.assert_allclose(values, exact, rtol=1e-14)


@pytest.mark.parametrize("kind", ["gef", "xml", "ags", "cpt"])
def test_what_a_file_says_of_the_cone_holds_unless_told_otherwise(folder: Path, kind: str) -> None:
    said = site_of(folder, kind, WRITERS[kind](rows_of(folder)))
    assert columns_of(said).area_ratio == 0.8
    assert "cone_area = 15 by the file" in columns_of(said).notes
    found = columns_of(changed(folder, ("area_ratio = 0.8", "")))
    assert found.area_ratio == 0.8
    assert "area_ratio = 0.8 by the file" in found.notes
    assert found.pre_drilled == (0.0 if kind == "ags" else 1.55)
    assert found.cone_radius == pytest.approx(np.sqrt(15e-4 / np.pi))
    own = columns_of(changed(folder, ("[test]", "[test]\ncone_area = 10\narea_ratio = 0.6")))
    assert own.cone_radius == pytest.approx(np.sqrt(10e-4 / np.pi))
    assert own.area_ratio == 0.6
    assert "cone_area = 10 by the site file, 15 by the file" in own.notes
    assert "area_ratio = 0.6 by the site file, 0.8 by the file" in own.notes


@pytest.mark.usefixtures("undrawn")
def test_a_file_is_interpreted_in_one_command(here: Path, command: Command) -> None:
    """Of one kind for all, whose columns are the same."""
    site_of(here, "gef", as_gef(rows_of(here)))
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
    command("new", "mine", "--interpret", "test.gef")
    assert "\narea_ratio = 0.8" in (here / "mine.toml").read_text()


def test_a_new_site_file_leaves_out_what_a_test_says_that_cannot_be(
    here: Path, command: Command, refusal: Refusal
) -> None:
    text = as_gef(rows_of(here)).replace(" 0.80,", " 0,")
    (here / "test.gef").write_text(text, encoding="latin-1")
    command("new", "mine", "--interpret", "test.gef")
    assert "\n#area_ratio = ..." in (here / "mine.toml").read_text()
    assert "test.gef: area_ratio = 0: must be > 0" in refusal(["interpret", "mine.toml"])


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


@pytest.mark.parametrize("quantity", [5, 7])
def test_pressure_of_other_filters_is_no_u2(folder: Path, quantity: int) -> None:
    """Whatever a GEF calls it, unless the site file says so."""
    text = as_gef(rows_of(folder)).replace("Waterspanning, 6", f"Pore pressure, {quantity}")
    path = site_of(folder, "gef", text)
    assert np.isnan(columns_of(path).values["u2"]).all()
    named = changed(folder, ("[test]", '[test]\ncolumns = { u2 = "Pore pressure" }'))
    assert np.isfinite(columns_of(named).values["u2"]).any()


def test_a_column_of_a_gef_may_have_several_codes_of_a_missing_value(folder: Path) -> None:
    """Of -1 beside -999, which stands in row 20."""
    rows = rows_of(folder)
    more = "#COLUMNVOID= 4, -999.0\n#COLUMNVOID= 4, -1.0"
    text = as_gef(rows).replace("#COLUMNVOID= 4, -999.0", more)
    other = text.replace(f"; {rows[5][2]!r}; ", "; -1.0; ")
    found = columns_of(site_of(folder, "gef", other))
    assert [row for row, fs in enumerate(found.values["fs"]) if np.isnan(fs)] == [5, 20]


FIVE = np.tan(np.radians(5.0))


@pytest.mark.parametrize(
    ("given", "step"),
    [
        ({8: "10.0"}, np.cos(np.radians(10.0))),
        ({9: "5.0", 10: "5.0"}, 1.0 / np.sqrt(1.0 + 2.0 * FIVE**2)),
        ({9: "5.0", 10: "5.0", 8: "0.0"}, 1.0),
        ({21: "5.0", 22: "5.0"}, 1.0 / np.sqrt(1.0 + 2.0 * FIVE**2)),
        ({9: "0.0", 10: "0.0", 21: "5.0", 22: "5.0"}, 1.0),
    ],
    ids=["resultant", "two planes", "resultant and planes", "other planes", "four planes"],
)
def test_inclination_corrects_the_depth(folder: Path, given: dict[int, str], step: float) -> None:
    """Columns of a GEF, by their quantity, the same all along but for a missing value."""
    rows = rows_of(folder)
    head, _, data = as_gef(rows).replace("Gecorrigeerde diepte, 11", "x, 99").partition("#EOH=\n")
    for number, quantity in enumerate(given, start=6):
        head += f"#COLUMNINFO= {number}, deg, Helling, {quantity}\n#COLUMNVOID= {number}, -999.0\n"
    tilt = "; ".join(given.values())
    lines = [f"{line.removesuffix(';!')}; {tilt};!" for line in data.splitlines()]
    lines[5] = lines[5].replace(next(iter(given.values())), "-999.0")
    found = columns_of(site_of(folder, "gef", "\n".join([f"{head}#EOH=", *lines])))
    way = np.array([row[0] for row in rows]) - rows[0][0]
    expected = rows[0][0] + 0.01 + step * way
    np.testing.assert_allclose(found.values["depth"], expected, rtol=1e-12)
    told = f"depth corrected by inclination, by {(1.0 - step) * way[-1]:.2g} m at the end"
    assert told in found.notes


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
    with pytest.raises(
        StudyError, match="inclination = 50 degrees, must be >= -45 and <= 45; look"
    ):
        columns_of(site)


def test_what_exports_have_around_their_rows(folder: Path) -> None:
    """Lines above the header, units below it, names of several words, a superscript, blanks."""
    rows = rows_of(folder)
    body = [";".join(cells(row, "")).replace(".", ",") for row in rows]
    head = [
        "Project: Quay;;;",
        "",
        "Coordinates;597000.1;6543210.2;12.4",
        "Cone;C10CFIIP;calibrated;",
        "Operator;A. N. Other;Ltd;Quay",
        "Depth;Cone Resistance;Sleeve friction;U2",
        "[m];MPa;MN/m\u00b2;MPa",
    ]
    found = columns_of(site_of(folder, "csv", "\n".join([*head, *body, ";;;", ""])))
    for name, column in zip(("depth", "qc", "fs", "u2"), np.array(rows).T, strict=True):
        np.testing.assert_allclose(found.values[name], column * (1.0 if name == "depth" else 1e6))
    assert "4 lines above the header left out" in found.notes


def test_rows_of_the_bro_may_stand_in_any_order(folder: Path) -> None:
    rows = rows_of(folder)
    shuffled = [rows[it] for it in np.random.default_rng(1).permutation(len(rows))]
    found = columns_of(site_of(folder, "xml", as_bro(shuffled)))
    np.testing.assert_array_equal(found.values["depth"], [row[0] for row in rows])
    np.testing.assert_allclose(found.values["u2"], 1e6 * np.array(rows)[:, 3])


@pytest.mark.parametrize("code", [-999, -9999.0])
def test_a_code_for_no_value_is_never_a_pore_pressure(folder: Path, code: float) -> None:
    """Where sensors may have been set to zero on the sea bed -1 MPa would be possible."""
    text = "depth [m],qc [MPa],fs [kPa],u2 [kPa]\n1,0.2,5,30\n2,0.2,5,{}\n3,0.2,5,50\n"
    at_zero = ("water_level = 1.0", "water_level = 0")
    path = site_of(folder, "csv", text.format(code), at_zero)
    with pytest.raises(StudyError, match=rf"line 3, column 'u2 \[kPa\]': {code:g} is a usual code"):
        columns_of(path)
    told = columns_of(changed(folder, ("[test]", f"[test]\nmissing = [{code}]")))
    np.testing.assert_array_equal(np.isnan(told.values["u2"]), [False, True, False])
    none = columns_of(changed(folder, (f"[{code}]", "[]")))
    np.testing.assert_array_equal(none.values["u2"], [30e3, 1e3 * code, 50e3])


def test_rows_without_a_depth_by_their_code_are_left_out(folder: Path) -> None:
    """As those of a length of rods above the depth that was bored beforehand."""
    rows = rows_of(folder)
    lacking = [(np.nan, np.nan, np.nan, np.nan)] * 3
    found = columns_of(site_of(folder, "gef", as_gef([*lacking, *rows])))
    np.testing.assert_array_equal(found.values["depth"], [row[0] for row in rows])
    assert "rows left out whose depth is a code for no value: 3" in found.notes


def test_changes_of_rods_and_gaps_are_told(folder: Path) -> None:
    rows = rows_of(folder)
    back = [(rows[40][0] - it, *rows[40][1:]) for it in (0.0, 0.04)]
    found = columns_of(site_of(folder, "csv", as_csv(rows[:41] + back + rows[41:60] + rows[80:])))
    assert len(found.values["depth"]) == len(rows) - 20
    assert found.notes == (
        "rows left out in which the tip stands or goes back: 2",
        "no values from 6.9 to 9 m",
    )


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_commas_are_read_unless_they_part_the_cells(folder: Path, delimiter: str) -> None:
    rows = rows_of(folder)
    text = as_csv(rows).replace(",", delimiter).replace(".", ",")
    found = columns_of(site_of(folder, "csv", text))
    assert found.notes == ("numbers have a decimal comma",)
    np.testing.assert_array_equal(found.values["depth"], [row[0] for row in rows])
    dated = [f"{line}{delimiter}01.02.2026" for line in text.splitlines()[1:]]
    again = columns_of(
        site_of(folder, "csv", "\n".join([f"{text.splitlines()[0]}{delimiter}day", *dated]))
    )
    np.testing.assert_array_equal(again.values["qc"], found.values["qc"])


@pytest.mark.parametrize("point", [".", ","])
@pytest.mark.parametrize(
    "header", ["depth [m]  qc (MPa) fs[MPa]\tu2 [MPa]", "z qc fs u2\nm MPa MPa MPa"]
)
def test_cells_may_be_parted_by_blanks(folder: Path, point: str, header: str) -> None:
    """Below lines of words, with units beside or below the names, and no value missing."""
    rows = [row for row in rows_of(folder) if not np.isnan(row).any()]
    lines = [f"  {'   '.join(map(repr, row))}".replace(".", point) for row in rows]
    text = "\n".join(["Test 7 of the quay", "", *header.splitlines(), *lines]) + "\n"
    found = columns_of(site_of(folder, "csv", text))
    expected = np.array(rows).T * np.array([1.0, 1e6, 1e6, 1e6])[:, None]
    np.testing.assert_allclose(list(found.values.values()), expected, rtol=1e-14)
    assert "1 lines above the header left out" in found.notes


POUND, KILOGRAM, FOOT = 4.4482216152605, 9.80665, 0.3048
"""Weights [N] and a length [m]."""


@pytest.mark.parametrize(
    ("unit", "size"),
    [
        ("kg/cm^2", KILOGRAM / 1e-4),
        ("kgf/cm\u00b2", KILOGRAM / 1e-4),
        ("mH2O", 1000.0 * KILOGRAM),
        ("m H2O", 1000.0 * KILOGRAM),
        ("mwc", 1000.0 * KILOGRAM),
        ("tsf", 2000.0 * POUND / FOOT**2),
        ("KSF", 1000.0 * POUND / FOOT**2),
        ("psi", POUND / (FOOT / 12.0) ** 2),
        ("N/mm2", 1e6),
    ],
)
def test_units_of_other_countries(folder: Path, unit: str, size: float) -> None:
    rows = rows_of(folder)
    table = [f"{z / FOOT!r},{1e6 * qc / size!r},{1e6 * fs / size!r}" for z, qc, fs, _ in rows]
    text = "\n".join([f"depth [ft],qc [{unit}],fs [{unit}]", *table])
    found = columns_of(site_of(folder, "csv", text, ("area_ratio = 0.8", "area_ratio = 1"))).values
    for name, column in zip(("depth", "qc", "fs"), np.array(rows).T, strict=False):
        expected = column * (1.0 if name == "depth" else 1e6)
        np.testing.assert_allclose(found[name], expected, rtol=1e-7)


def test_levels_become_depths_without_rounding(folder: Path) -> None:
    """0.3 and 0.6 are 0.9 m, where a layer may end or u0 begin."""
    text = "depth [m],qc [MPa],fs [kPa],u2 [kPa]\n-0.6,0.2,5,0\n-0.7,0.2,5,0\n"
    found = columns_of(site_of(folder, "csv", text, ("[test]", "[test]\nground_level = 0.3")))
    assert found.values["depth"].tolist() == [0.9, 1.0]


@pytest.mark.parametrize(("kind", "end"), [("ags", "/1"), ("cpt", "")])
def test_of_several_soundings_one_is_named(folder: Path, kind: str, end: str) -> None:
    writer = {"ags": as_ags, "cpt": as_sgf}[kind]
    named = ("[test]", f'[test]\nsounding = "CPT2{end}"')
    path = site_of(folder, kind, writer(rows_of(folder), "CPT1", "CPT2"), named)
    assert len(columns_of(path).values["depth"]) == len(rows_of(folder))
    with pytest.raises(StudyError, match=f"'CPT3{end}': is not there.*; has CPT1{end}, CPT2{end}"):
        columns_of(changed(folder, (f"CPT2{end}", f"CPT3{end}")))
