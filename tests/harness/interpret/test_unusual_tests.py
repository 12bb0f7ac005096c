"""Tests in unusual ground, and readings that tell nothing: what is given, what is left out, why."""

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.interpret import strength
from harness.interpret.check import checked, misfit_in_words
from harness.interpret.forms import WATER
from harness.interpret.inference.weights import Measure
from harness.interpret.measured import CLAY_INDEX, REASONS
from harness.interpret.result import in_digits, in_words
from harness.interpret.site import load_site
from harness.interpret.strength import interpret
from harness.interpret.tables.factors import PRESSURE, RANGES, factors
from harness.interpret.tables.model_factor import pressure_factor
from harness.pictures.measured.interpreted import interpretation_figure
from tests.harness.conftest import Refusal
from tests.harness.interpret.conftest import DEPTH, FACTOR, STRENGTH, changed, measured_rows

LAYER_ENDS = "from = 2\nto = 10"
ROW = 50
"""A row within the layer of the site."""


@pytest.fixture
def folder(folder: Path) -> Path:
    """As few draws as there may be: what is left out, and why, needs no more."""
    changed(folder, ("[test]", "samples = 512\n[test]"))
    return folder


def rewritten(folder: Path, column: str, change: object, rows: slice = slice(None)) -> Path:
    """The site file, when a column of its test has been changed: by what is added, or to a text."""
    lines = (folder / "test.csv").read_text().splitlines()
    place = [name.split()[0] for name in lines[0].split(",")].index(column)
    table = [line.split(",") for line in lines[1:]]
    for cells in table[rows]:
        cells[place] = change if isinstance(change, str) else f"{float(cells[place]) + change:.9g}"
    text = "\n".join([lines[0], *(",".join(cells) for cells in table)])
    (folder / "test.csv").write_text(text + "\n")
    return folder / "site.toml"


def reasons(found: xr.Dataset) -> list[str]:
    return [REASONS[number] for number in found.reason.values]


def test_water_on_the_ground_weighs_on_it(folder: Path) -> None:
    """The same ground below 30 m of water, whose pressure qc and u2 then have, is as strong."""
    on_land = interpret(load_site(changed(folder, ("water_level = 1.0", "water_level = 0"))))
    sea = 30.0 * WATER / 1e3  # kPa
    rewritten(folder, "u2", sea)
    # qt = qc + (1 - a) u2 has all of it, by the part of the cone that no water is behind.
    rewritten(folder, "qc", 0.8 * sea / 1e3)
    below = interpret(load_site(changed(folder, ("water_level = 0", "water_level = -30"))))
    np.testing.assert_allclose(below.net_resistance, on_land.net_resistance, rtol=1e-6)
    np.testing.assert_allclose(below.strength, on_land.strength, rtol=1e-6)
    stresses = [it.vertical_stress - it.water_pressure for it in (on_land, below)]
    np.testing.assert_allclose(*stresses, rtol=1e-6)


def test_suction_at_the_surface_weighs_nothing(folder: Path) -> None:
    """And water that stands on the ground weighs as much where u0 tells of it from above on."""
    plain = interpret(load_site(folder / "site.toml"))
    suction = "u0 = { depth = [0, 3, 12], value = [-20, 0, 88.29] }"
    dry = interpret(load_site(changed(folder, ("water_level = 1.0", suction))))
    np.testing.assert_array_equal(dry.vertical_stress, plain.vertical_stress)
    sea = "u0 = { depth = [-3, 12], value = [0, 147.15] }"
    below = interpret(load_site(changed(folder, (suction, sea))))
    np.testing.assert_allclose(below.vertical_stress, plain.vertical_stress + 3.0 * WATER)


def test_layers_that_go_beyond_the_test_are_told(folder: Path) -> None:
    inside = interpret(load_site(folder / "site.toml"))
    assert inside.attrs["notes"] == ""
    beyond = interpret(load_site(changed(folder, (LAYER_ENDS, "from = 0\nto = 30"))))
    assert beyond.attrs["notes"] == (
        "a layer begins at 0 m, the test at 1 m; a layer ends at 30 m, the test at 11.9 m"
    )


def test_a_row_on_a_border_is_of_the_lower_layer_alone(folder: Path) -> None:
    """In the numbers, and where they are counted and averaged."""
    lower = (folder / "site.toml").read_text().partition("[[layer]]")[2]
    more = "[[layer]]" + lower.replace("from = 2\nto = 10", "from = 6\nto = 10")
    path = changed(folder, (LAYER_ENDS, "from = 2\nto = 6"))
    path.write_text(path.read_text() + more.replace("rate_factor = 0", "rate_factor = 0.1"))
    site = load_site(path)
    found = interpret(site)
    upper, below = in_words(site, found)
    assert "on average over 40 depths" in upper  # 2.0 to 5.9 m
    assert "on average over 41 depths" in below
    row = found.sel(depth=6.0, method="nearest")
    assert float(row.strength[1] / found.sel(depth=5.9, method="nearest").strength[1]) < 0.9


@pytest.mark.parametrize("below", ["sand", "another layer"])
def test_nkt_of_a_sample_is_by_the_clay_of_its_layer(folder: Path, below: str) -> None:
    tables = '[[laboratory]]\ndepth = 5.95\nstrength = 20\ntest = "CAUC"\n'
    path = changed(folder, ('"isotropic"', '"mobilised"'))
    path.write_text(path.read_text() + tables)
    plain = interpret(load_site(path))
    if below == "sand":
        rewritten(folder, "qc", 10.0, slice(ROW, ROW + 2))
        rewritten(folder, "u2", "49.05", slice(ROW, ROW + 2))
    else:
        rewritten(folder, "qc", 0.5, slice(ROW, None))
        layer = path.read_text().partition("[[layer]]")[2].partition("[[laboratory]]")[0]
        changed(
            folder,
            (LAYER_ENDS, "from = 2\nto = 6"),
            ("[[laboratory]]", f"[[layer]]{layer}{tables[:14]}"),
        )
        changed(folder, (LAYER_ENDS, "from = 6\nto = 10"))
    other = interpret(load_site(path))
    np.testing.assert_allclose(other.laboratory_factor, plain.laboratory_factor, rtol=0.02)


def test_the_mean_bq_is_that_of_the_depths_with_a_pore_pressure(folder: Path) -> None:
    """Where qc is corrected, a depth without u2 has a strength."""
    rewritten(folder, "u2", "", slice(ROW, None))
    site = load_site(changed(folder, ("area_ratio = 0.8", "area_ratio = 1")))
    found = interpret(site)
    own = found.isel(depth=(found.reason.values == 0) & found.pore_pressure.notnull().values)
    ratio = float((own.pore_pressure - own.water_pressure).mean() / own.net_resistance.mean())
    assert f"Bq is {ratio:.2f}, " in in_words(site, found)[0]


@pytest.mark.parametrize("friction", ["0.3", "0"])
def test_high_pore_pressure_is_clay_whatever_the_sleeve_says(folder: Path, friction: str) -> None:
    """Sensitive clay has an Ic below that of clay; with the pore pressure of sand it is none."""
    rewritten(folder, "qc", 0.4, slice(ROW, ROW + 10))
    rewritten(folder, "fs", friction, slice(ROW, ROW + 10))
    rewritten(folder, "u2", 250.0, slice(ROW, ROW + 5))
    rewritten(folder, "u2", "60", slice(ROW + 5, ROW + 10))
    found = interpret(load_site(folder / "site.toml"))
    rows = slice(ROW, ROW + 10)
    assert (found.soil_index[rows] < CLAY_INDEX).all() or friction == "0"
    assert reasons(found)[ROW : ROW + 5] == ["used"] * 5
    assert "used" not in reasons(found)[ROW + 5 : ROW + 10]


@pytest.mark.parametrize("friction", ["0", "-5", ""])
def test_what_may_be_sand_by_the_tip_alone_has_no_strength(folder: Path, friction: str) -> None:
    rewritten(folder, "fs", friction, slice(ROW, None))
    rewritten(folder, "qc", 10.0, slice(ROW, ROW + 5))
    found = interpret(load_site(folder / "site.toml"))
    assert reasons(found)[ROW : ROW + 5] == ["no fs and it may be sand"] * 5
    assert reasons(found)[ROW + 5 : ROW + 9] == ["used"] * 4  # too weak to be sand
    assert found.soil_index[ROW:].isnull().all()


def test_without_a_sleeve_clay_is_told_by_pore_pressure_and_tip(folder: Path) -> None:
    """As where fs has no value: clay by Bq, or by qt alone; nothing that asks for fs is given."""
    rewritten(folder, "qc", 0.4, slice(ROW, ROW + 10))
    rewritten(folder, "u2", 250.0, slice(ROW, ROW + 5))
    rewritten(folder, "fs", "")
    emptied = interpret(load_site(folder / "site.toml"))
    text = (folder / "test.csv").read_text()
    (folder / "test.csv").write_text(text.replace("fs [kPa]", "x [kPa]"))
    found = interpret(load_site(folder / "site.toml"))
    assert reasons(found)[ROW : ROW + 5] == ["used"] * 5
    assert reasons(found)[ROW + 5 : ROW + 10] == ["no fs and it may be sand"] * 5
    xr.testing.assert_equal(found, emptied)
    assert found.attrs["notes"].startswith("no column is taken as fs (columns = { fs =")
    legend = interpretation_figure(found).axes[0].get_legend()
    assert not any("f_" in text.get_text() for text in legend.get_texts())


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("[test]", 'use = ["tip", "sleeve"]\n[test]', "use asks for fs, which the test has not"),
        ("[test]", 'use = ["tip", "pore_pressure"]\n[test]', "use asks for u2"),
        ("= 0.4", '= "sleeve"', "adhesion_factor of 2 to 10 m asks for fs"),
    ],
)
def test_a_sleeve_or_filter_that_is_asked_has_to_be_there(
    folder: Path, old: str, new: str, told: str, refusal: Refusal
) -> None:
    rewritten(folder, "fs", "")
    rewritten(folder, "u2", "")
    path = changed(folder, (old, new), ("area_ratio = 0.8", "area_ratio = 1"))
    assert told in refusal(["interpret", str(path)])


@pytest.mark.parametrize("friction", ["0", "-1", ""])
def test_a_sleeve_that_is_to_tell_the_adhesion_has_values(folder: Path, friction: str) -> None:
    rewritten(folder, "fs", friction, slice(ROW, ROW + 1))
    path = changed(folder, ("adhesion_factor = 0.4", 'adhesion_factor = "sleeve"'))
    found = interpret(load_site(path))
    assert reasons(found)[ROW - 1 : ROW + 2] == ["used", "value missing", "used"]


@pytest.mark.parametrize(
    ("friction", "told"),
    [(None, "not undrained clay"), ("", "no fs and it may be sand")],
    ids=["sleeve", "no sleeve"],
)
def test_no_filter_is_blamed_above_the_water(folder: Path, friction: str | None, told: str) -> None:
    """Below the water table a filter that stands still is not saturated in any soil."""
    rewritten(folder, "u2", "0", slice(ROW, None))
    rewritten(folder, "qc", 8.0, slice(ROW, None))  # MPa
    if friction is not None:
        rewritten(folder, "fs", friction, slice(ROW, None))
    path = changed(folder, (LAYER_ENDS, "from = 2\nto = 12"))
    assert set(reasons(interpret(load_site(path)))[ROW:]) == {"filter not saturated"}
    dry = interpret(load_site(changed(folder, ("water_level = 1.0", "water_level = 9.0"))))
    above = int(np.searchsorted(dry.depth.values, 9.0))
    assert set(reasons(dry)[ROW:above]) == {told}
    assert set(reasons(dry)[above + 1 :]) == {"filter not saturated"}


def test_more_draws_than_the_memory_holds_are_refused(
    folder: Path, refusal: Refusal, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(strength, "memory_of_machine", lambda: 20e6)
    site = changed(folder, ("samples = 512", "samples = 2048"))
    line = refusal(["interpret", str(site)])
    assert "site.toml: samples = 2048: with 81 depths in the layer 2 to 10 m at most 1543" in line


@pytest.mark.parametrize("ratio", [1.0, 0.8])
def test_u2_of_zeros_is_none(folder: Path, ratio: float) -> None:
    rewritten(folder, "u2", "0")
    found = interpret(load_site(changed(folder, ("area_ratio = 0.8", f"area_ratio = {ratio}"))))
    assert set(reasons(found)) == {"no layer", "used"}
    assert found.attrs["notes"].startswith("u2 is 0 in all rows, and taken as not measured")


@pytest.mark.parametrize("mode", ["isotropic", "mobilised"])
def test_an_unmeasured_u2_is_drawn(folder: Path, mode: str) -> None:
    """Around the one that the table expects, in real clay times the factor of the sites."""
    soil = {"rigidity_index": 120.0, "adhesion_factor": 0.4, "stress_anisotropy": 0.2}
    soil |= {"remoulded_strength_ratio": 1.0, "ductility": 20.0}
    table = factors().at(dict.fromkeys(RANGES, 0.0) | soil)
    share = float(table[PRESSURE] / table["cone_factor"])
    share *= math.exp(pressure_factor()[0]) if mode == "mobilised" else 1.0
    rows = measured_rows(DEPTH, FACTOR * STRENGTH, 0.4 * STRENGTH, share)
    (folder / "test.csv").write_text(rows)
    site = load_site(changed(folder, ("isotropic", mode)))
    measured = interpret(site).isel(depth=ROW)
    rewritten(folder, "u2", "")
    found = interpret(site).isel(depth=ROW)
    deviation = np.ptp(np.log(found.strength.values)) / 2.0 / 1.645
    # The median of 512 draws has 5.5 % of their deviation as its own, and both medians have it.
    noise = 3.0 * math.sqrt(2.0) * 0.055 * deviation
    assert abs(math.log(float(found.strength[1] / measured.strength[1]))) < noise
    # d ln qnet = (1 - a) Bq / (1 - (1 - a) Bq) d ln Bq
    width = Measure(PRESSURE, np.ones(1), np.ones(1)).width if mode == "isotropic" else 0.24
    by_u2 = 0.2 * share / (1.0 - 0.2 * share) * width
    told = float(found.error_share.sel(cause="pore_pressure"))
    assert told == pytest.approx((by_u2 / deviation) ** 2, abs=0.03)


@pytest.mark.filterwarnings("error")
def test_a_row_at_the_surface_alone_has_a_picture(folder: Path) -> None:
    (folder / "test.csv").write_text("depth [m],qc [MPa],fs [kPa],u2 [kPa]\n0,0.5,20,30\n")
    figure = interpretation_figure(interpret(load_site(folder / "site.toml")), [])
    assert figure.axes[0].get_ylim() == (1.0, 0.0)


def test_depths_beyond_the_simulated_sounding_are_told(folder: Path) -> None:
    site = load_site(folder / "site.toml")
    names = ("net_resistance", "sleeve_friction", "excess_pore_pressure", "strength")
    far = xr.Dataset({name: ("depth", [1.0, 1.0]) for name in names}, {"depth": [50.0, 51.0]})
    (told,) = misfit_in_words(site, checked(interpret(site), far))
    assert told == "2 to 10 m: no depth with a strength is in the simulated sounding"


def test_only_what_tells_something_is_named(folder: Path) -> None:
    rewritten(folder, "fs", "-1")
    path = changed(folder, ("[test]", 'use = ["tip", "sleeve", "pore_pressure"]\n[test]'))
    site = load_site(path)
    (told,) = in_words(site, interpret(site))
    assert " by tip, pore pressure with Nkt" in told


def test_no_digit_is_finer_than_a_tenth_of_the_band() -> None:
    """And a thousand is no power of ten."""
    assert in_digits(7.218, 12.94, 16.42) == ["7.2", "12.9", "16.4"]
    assert in_digits(1007.0, 1234.0, 2034.0) == ["1010", "1230", "2030"]
    assert in_digits(1000.0, 1000.0, 1000.0) == ["1000"] * 3


def test_rates_are_told_as_they_are_given(folder: Path) -> None:
    for rate in ("1.25 %/h", "125 %/h"):
        given = f'laboratory_rate = "{rate}"'
        now = (folder / "site.toml").read_text().partition("laboratory_rate")[2].splitlines()[0]
        site = load_site(changed(folder, (f"laboratory_rate{now}", given)))
        assert f"at {rate})" in in_words(site, interpret(site))[0]


def test_a_border_without_rows_on_both_sides_is_not_sharpened(folder: Path) -> None:
    header, *rows = (folder / "test.csv").read_text().splitlines()
    for kept in (rows[8:18], rows[10:11]):  # from 1.8 m, two rows above the layer; and one at 2 m
        (folder / "test.csv").write_text("\n".join([header, *kept]))
        found = interpret(load_site(folder / "site.toml"), sharpen=True)
        np.testing.assert_array_equal(found.sharpened_resistance, found.net_resistance)


def test_points_of_a_laboratory_are_all_in_the_picture(folder: Path) -> None:
    """The panel reaches to the strongest and the deepest."""
    strongest = 3.0 * float(STRENGTH.max())
    found = interpret(load_site(folder / "site.toml"))
    figure = interpretation_figure(found, [(5.0, strongest), (0.5, strongest), (15.0, strongest)])
    test, _, _, strength, _ = figure.axes
    assert strength.get_xlim()[1] > strongest / 1e3
    assert strength.get_ylim() == (15.0, 0.0)
    used = found.reason.values == 0
    assert test.get_xlim()[1] > max(
        float(line.get_xdata()[used].max()) for line in test.get_lines()
    )


def test_pore_pressure_below_zero_is_in_the_picture(folder: Path) -> None:
    for row in range(12, 17):  # near the top, where Bq is still one of clay
        rewritten(folder, "u2", str(9 - row), slice(row, row + 1))
    figure = interpretation_figure(interpret(load_site(folder / "site.toml")))
    assert figure.axes[0].get_xlim()[0] == pytest.approx(-1.05 * 7.0)


def test_a_test_that_is_all_pre_drilled_has_no_strength(folder: Path) -> None:
    """The unit of qc is not blamed, where no row is left to judge it by."""
    site = load_site(changed(folder, ("unit_weight = 17", "unit_weight = 17\npre_drilled = 300")))
    assert in_words(site, interpret(site)) == ["2 to 10 m: no strength; pre-drilled."]


def test_a_filter_set_to_zero_on_the_sea_bed_may_read_far_below(folder: Path) -> None:
    """There -1 MPa is no vacuum; -999 itself is a code for no value, and refused."""
    rewritten(folder, "u2", "-998", slice(ROW, ROW + 2))
    below = interpret(load_site(changed(folder, ("water_level = 1.0", "water_level = 0"))))
    assert float(below.pore_pressure[ROW]) == -998e3


TOO_HIGH = "".join(
    f'\n[[laboratory]]\ntest = "mobilised"\ndepth = {depth}\nstrength = 300'
    for depth in (4, 5, 6, 7)
)
CAUTIONS = {
    "as the measured sites": ({}, "", ""),
    "sensitive by Bq": ({"share": 0.9}, "", "it may be sensitive beyond the measured sites"),
    "sensitive by Fr": ({"friction": 0.03}, "", "it may be sensitive beyond the measured sites"),
    "overconsolidated": ({"times": 6.0, "friction": 0.9}, "", "it may be overconsolidated beyond"),
    "silt": ({"share": 0.2, "times": 2.8, "friction": 0.22}, "", "it may be silt that drains"),
    "a filter with air": ({"share": -0.05}, "", "it may be soft with u2 below u0, so that"),
    "laboratory tests ten times too high": (
        {},
        'strength = "mobilised"' + TOO_HIGH,
        "it may be read in wrong units, or beside wrong laboratory tests",
    ),
    "K0": (
        {"times": 2.0},
        'K0 = 1.2\nstrength = "simple_shear"',
        "Caution: K0 is above 1, simple_shear_ratio and extension_ratio assumed as in soft clay",
    ),
}


@pytest.mark.parametrize(("ground", "keys", "told"), CAUTIONS.values(), ids=list(CAUTIONS))
def test_clay_unlike_that_of_the_measured_sites_is_told(
    folder: Path, ground: dict[str, float], keys: str, told: str
) -> None:
    """Where the sounding shows it, and only there."""
    ground = {"times": 1.0, "friction": 0.4, "share": 0.5} | ground
    net = ground["times"] * FACTOR * STRENGTH
    friction = ground["friction"] * ground["times"] * STRENGTH
    (folder / "test.csv").write_text(measured_rows(DEPTH, net, friction, ground["share"]))
    anisotropy = ("stress_anisotropy = 0.2", "") if "K0" in keys else ("", "")
    mode = ('strength = "isotropic"', keys or 'strength = "mobilised"')
    site = load_site(changed(folder, mode, anisotropy))
    (sentence,) = in_words(site, interpret(site))
    assert told in sentence
    assert sentence.count("Caution") == bool(told)
