"""Interpretation of measured cone tests: inputs, the table of factors, strength and its error."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.netcdf_files import read_attributes, write_netcdf
from harness.interpret.inference.draws import _in_table
from harness.interpret.inference.weights import LEFT_OUT, Measure
from harness.interpret.site import load_site
from harness.interpret.strength import interpret
from harness.interpret.tables.factors import PRESSURE, RANGES, SLEEVE, cone_factor, factors
from mpm_warp.errors import ParameterError
from mpm_warp.provenance import provenance
from tests.harness.conftest import Command, Refusal
from tests.harness.interpret.conftest import DEPTH, FACTOR, STRENGTH, changed, measured_rows


@pytest.mark.parametrize(
    ("index", "adhesion", "exact"), [(100, 0.0, 10.71), (100, 0.5, 11.51), (100, 1.0, 12.16)]
)
def test_the_table_has_the_known_factors(index: float, adhesion: float, exact: float) -> None:
    factor, half_width = cone_factor(rigidity_index=index, adhesion_factor=adhesion)
    assert abs(factor - exact) < half_width


def test_cases_kept_out_of_the_fit_are_within_its_error() -> None:
    table = factors()
    for name, errors in table.fit_errors.items():
        assert len(errors) >= 90
        assert np.mean(np.abs(errors) <= table.half_widths[name]) >= 0.95
    assert np.quantile(np.abs(table.fit_errors["cone_factor"]), 0.95) < 0.015


@pytest.mark.parametrize(
    ("adhesion", "fine"), [(0.0, 4.99), (0.25, 4.63), (0.5, 4.42), (1.0, 4.27)]
)
def test_the_table_gives_the_pore_pressure_of_fine_meshes(adhesion: float, fine: float) -> None:
    """At Ir 100: of 40 rows beside the face, the layer as narrow columns have it."""
    own = dict.fromkeys(RANGES, 0.0) | {"rigidity_index": 100.0, "adhesion_factor": adhesion}
    own |= {"remoulded_strength_ratio": 1.0, "ductility": 20.0}
    table = factors()
    told = table.at(own)[PRESSURE]
    assert abs(told / fine - 1.0) < table.half_widths[PRESSURE]


def test_ductility_says_nothing_of_clay_that_does_not_soften() -> None:
    own = {name: 0.5 * (low + high) for name, (low, high) in RANGES.items()}
    own["remoulded_strength_ratio"] = 1.0
    brittle, ductile = (factors().at(own | {"ductility": end}) for end in RANGES["ductility"])
    assert brittle == ductile
    soft = {"rigidity_index": 100.0, "remoulded_strength_ratio": 0.5}
    assert cone_factor(**soft, ductility=5.0)[0] < 0.97 * cone_factor(**soft, ductility=60.0)[0]


def test_a_factor_follows_the_rate_at_which_the_strength_is_told() -> None:
    """The same ground, told at another rate: Nkt su is the same force."""
    rate, share = 1e-4, 0.1
    at_table = cone_factor(
        rigidity_index=100, stress_anisotropy=0.2, rate_factor=share, reference_strain_rate=1e-6
    )[0]
    over = 1.0 + share * math.log10(rate / 1e-6)
    faster = cone_factor(
        rigidity_index=100 / over,
        stress_anisotropy=0.2 / over,
        rate_factor=share / over,
        reference_strain_rate=rate,
    )[0]
    assert faster * over == pytest.approx(at_table, rel=1e-12)


@pytest.mark.parametrize("name", [*RANGES, "reference_strain_rate"])
def test_a_factor_outside_the_table_is_refused(name: str) -> None:
    soil = {"rigidity_index": 100.0, "reference_strain_rate": 1e-6}
    low, high = RANGES.get(name, (1e-6, 1e-2))
    for value in (low - 0.01, high + 0.01, *([math.nan] if name == "ductility" else [])):
        with pytest.raises(ParameterError, match=f"^{name} = .* must be "):
            cone_factor(**{**soil, name: value})


def test_a_rate_effect_needs_the_rate_of_the_strength() -> None:
    with pytest.raises(ParameterError, match=r"^rate_factor needs a reference"):
        cone_factor(rigidity_index=100.0, rate_factor=[0.0, 0.1])


def test_the_strength_of_an_exact_test_is_that_of_the_ground(folder: Path) -> None:
    """All inputs known: the one error left is the table's, around the exact strength."""
    found = interpret(load_site(folder / "site.toml"))
    inside = (found.depth >= 2.0) & (found.depth <= 10.0)
    assert bool((found.reason[inside] == 0).all())
    assert bool((found.reason[~inside] != 0).all())
    strength = found.strength.sel(percentile=50.0)[inside] / STRENGTH[inside.values]
    # Of 2048 draws in strata the median is off by less than a stratum's width.
    np.testing.assert_allclose(strength, 1.0, rtol=2e-4)
    share = found.error_share[inside].mean("depth")
    assert float(share.sel(cause="numerical")) > 0.99


def test_an_error_of_the_test_is_its_share_and_width(folder: Path) -> None:
    """With qnet off by 10 % at 10 m and all else known, su is off by 10 % there."""
    half = 0.1 * FACTOR * float(STRENGTH[90]) / 1e3
    site = load_site(changed(folder, ("{ qc = 0,", f"{{ qc = {half},")))
    found = interpret(site).isel(depth=90)
    low, middle, high = found.strength.values
    told = 0.5 * (high - low) / middle
    table = factors().half_widths["cone_factor"]
    assert told == pytest.approx(math.hypot(0.1, table) * 1.645 / 1.96, rel=0.02)
    expected = 0.01 / (0.01 + table**2)
    assert float(found.error_share.sel(cause="test")) == pytest.approx(expected, abs=0.03)


def test_the_sleeve_tells_the_adhesion(folder: Path) -> None:
    """An unknown adhesion is narrower, and around the true one, where the sleeve tells of it."""
    wide = ("adhesion_factor = 0.4", "adhesion_factor = { low = 0.0, high = 1.0 }")
    site = changed(folder, wide)
    without = interpret(load_site(site))
    weighed = interpret(load_site(changed(folder, ("[test]", 'use = ["tip", "sleeve"]\n[test]'))))
    by_sleeve = interpret(load_site(changed(folder, (wide[1], 'adhesion_factor = "sleeve"'))))
    low, middle, high = weighed.input_after.sel(cause="adhesion_factor").values[0]
    before = without.input_after.sel(cause="adhesion_factor").values[0]
    assert high - low < 0.7 * (before[2] - before[0])
    assert low < 0.4 < high
    assert abs(middle - 0.4) < 0.1
    widths = [
        float(np.ptp(found.strength.isel(depth=50).values / STRENGTH[50]))
        for found in (by_sleeve, weighed, without)
    ]
    # The sleeve tells the same whether the adhesion follows from it or is weighed by it.
    assert widths[0] == pytest.approx(widths[1], rel=0.1)
    assert max(widths[:2]) < 0.95 * widths[2]


def test_the_error_of_a_sleeve_that_tells_the_adhesion_has_a_share(
    folder: Path,
) -> None:
    """As far as the strength by a sleeve friction off by its standard deviation differs."""
    site = load_site(changed(folder, ("adhesion_factor = 0.4", 'adhesion_factor = "sleeve"')))
    found = interpret(site).isel(depth=50)
    off, medians = math.hypot(LEFT_OUT, factors().half_widths[SLEEVE] / 1.96), []
    for friction in (1.0 - off, 1.0 + off):
        rows = measured_rows(DEPTH, FACTOR * STRENGTH, 0.4 * friction * STRENGTH)
        (folder / "test.csv").write_text(rows)
        medians.append(float(interpret(site).strength.sel(percentile=50.0)[50]))
    by_sleeve = 0.5 * abs(math.log(medians[1] / medians[0]))
    low, _, high = np.log(found.strength.values)
    share = (by_sleeve / ((high - low) / 2.0 / 1.645)) ** 2
    assert share > 0.2
    assert float(found.error_share.sel(cause="sleeve_friction")) == pytest.approx(share, abs=0.05)


def test_a_sleeve_that_tells_the_adhesion_is_not_counted_twice(folder: Path) -> None:
    """Each draw then meets the sleeve friction, with the error drawn for it."""
    by_sleeve = ("adhesion_factor = 0.4", 'adhesion_factor = "sleeve"')
    site = load_site(changed(folder, by_sleeve, ("[test]", 'use = ["tip", "sleeve"]\n[test]')))
    assert float(interpret(site).draws[0]) == pytest.approx(site.samples)


def test_one_reading_near_zero_does_not_silence_a_measure(folder: Path) -> None:
    """The likelihood is that of the mean, which such a reading hardly changes."""
    values = np.full(100, 200e3)
    expected = np.broadcast_to([150e3, 200e3, 260e3], (100, 3))
    of_all = Measure(SLEEVE, values, np.full(100, 1e3)).log_likelihood(expected)
    values[50] = 300.0
    with_one = Measure(SLEEVE, values, np.full(100, 1e3)).log_likelihood(expected)
    # A mean that is 1 % less changes it by 0.01 ln(4/3) / 0.2^2 at most.
    np.testing.assert_allclose(with_one, of_all, atol=0.073)


def test_a_measure_that_cannot_be_used_is_told(folder: Path) -> None:
    rows = [line.split(",") for line in (folder / "test.csv").read_text().splitlines()]
    dry = [",".join([*row[:3], f"{-5.0 * float(row[0]):g}"]) for row in rows[1:]]
    (folder / "test.csv").write_text("\n".join([",".join(rows[0]), *dry]))
    used = changed(folder, ("[test]", 'use = ["tip", "pore_pressure"]\n[test]'))
    told = "2 to 10 m: the pore pressure is not used, its mean is not above 0"
    assert told in interpret(load_site(used)).attrs["notes"]


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (("unit_weight = 17", "unit_weight = 17\npre_drilled = 4.0"), "pre-drilled"),
        (("stress_anisotropy = 0.2", "K0 = 0.05"), "Delta beyond the table"),
    ],
)
def test_no_strength_has_a_reason(folder: Path, change: tuple[str, str], reason: str) -> None:
    found = interpret(load_site(changed(folder, change)))
    words = found.reason.attrs["flag_meanings"].split()
    assert reason.replace(" ", "_") in {words[it] for it in found.reason.values}
    left = found.reason.values != 0
    assert np.isnan(found.strength.values[left]).all()


def test_values_that_cannot_be_clay_are_left_out(folder: Path) -> None:
    """Sand: ten times the resistance, the same friction; a filter that hardly moves."""
    lines = (folder / "test.csv").read_text().splitlines()
    for row in range(50, 60):
        depth, qc, *others = lines[row].split(",")
        lines[row] = ",".join([depth, f"{20.0 * float(qc):g}", *others])
    for row in range(70, 95):
        lines[row] = ",".join([*lines[row].split(",")[:3], f"{76 + row % 3}"])
    (folder / "test.csv").write_text("\n".join(lines))
    found = interpret(load_site(folder / "site.toml"))
    words = found.reason.attrs["flag_meanings"].split()
    reasons = [words[it] for it in found.reason.values]
    assert set(reasons[49:59]) == {"not_undrained_clay"}
    assert set(reasons[70:85]) == {"filter_not_saturated"}


def test_a_site_is_interpreted_from_the_command_line(here: Path, command: Command) -> None:
    """From the test alone: a site file is written, completed by hand, and interpreted."""
    (here / "triaxial.csv").write_text("depth [m],strength [kPa],test\n5,15.5,CAUC\n")
    command("new", "mine", "--interpret", "test.csv")
    assert "area_ratio: is missing" in command("interpret", "mine.toml", code=2).err
    text = (here / "mine.toml").read_text()
    (here / "mine.toml").write_text(text.replace("[test]", "[test]\narea_ratio = 0.8", 1))
    asked = "--laboratory", "triaxial.csv", "--format", "png", "svg"
    told = command("interpret", "mine.toml", *asked)
    assert told.out.startswith("2 to 10 m: su (mobilised")
    assert "by 1 laboratory test of this site" in told.out
    assert "assumed: water_level, unit_weight, accuracy, rate_factor, sensitivity" in told.out
    assert "no design value" in told.err
    written = sorted(it.name for it in (here / "results").iterdir())
    endings = ".csv", ".html", ".nc", ".png", ".svg", "_lines.csv"
    assert written == [f"mine_interpretation{it}" for it in endings]
    header, row, *_ = (here / "results/mine_interpretation.csv").read_text().splitlines()
    assert header.startswith("depth [m],qc [kPa],fs [kPa],u2 [kPa],qt [kPa],error of qt [kPa],")
    assert ",su 95% [kPa],share of rigidity_index [1]," in header
    assert header.endswith(",share of causes_together [1],reason")
    assert row.endswith(",no layer")
    said = read_attributes(here / "results/mine_interpretation.nc")
    assert [said[name] for name in ("commit", "mpm_warp_version")] == [
        provenance()[name] for name in ("commit", "mpm_warp_version")
    ]


@pytest.mark.usefixtures("undrawn")
def test_another_site_of_one_name_is_not_replaced_silently(here: Path, command: Command) -> None:
    told = 'site_interpretation.nc: was of a site with another title, "A site", and is replaced'
    for _ in range(2):
        assert told not in command("interpret", "site.toml").err
    changed(here, ("A site", "Another site"))
    assert told in command("interpret", "site.toml").err


@pytest.mark.parametrize("ending", [".nc", ".csv", "_lines.csv", ".png", ".html", "a result"])
def test_a_file_of_others_is_not_replaced(ending: str, here: Path, refusal: Refusal) -> None:
    """Nothing is written then, a table with the columns of a test and a result of a study too."""
    path = Path(f"results/site_interpretation{'.nc' if ending == 'a result' else ending}")
    path.parent.mkdir()
    path.write_text("depth [m],qc [kPa],fs [kPa],u2 [kPa]\n1,2,3,4\n", encoding="utf-8")
    if ending == "a result":
        write_netcdf(xr.Dataset(attrs={"study": "site", "title": "A study"}), path)
    before = path.read_bytes()
    line = refusal(["interpret", "site.toml"])
    assert str(path) in line
    assert re.search("(not written by this|written by another) program", line)
    assert path.read_bytes() == before
    assert [*path.parent.iterdir()] == [path]


def test_ground_that_is_not_simulated_is_told_with_its_site(here: Path, command: Command) -> None:
    rows = (here / "test.csv").read_text().splitlines()
    (here / "test.csv").write_text("\n".join([rows[0], rows[50]]))
    *_, line = command("interpret", "site.toml", "--check", code=2).err.splitlines()
    assert line.startswith("harness: site: the simulated sounding refused: to_depth = ")


def test_the_sleeve_tells_a_shift_of_the_test(folder: Path) -> None:
    """Friction of twice the adhesion asks for twice the resistance, as far as the test may be off.

    The resistance of the ground, over its factor, is the strength of the draws.
    """
    changes = ("qc = 0", "qc = 300"), ('title = "A site"', 'title = "A"\nuse = ["tip", "sleeve"]')
    (folder / "test.csv").write_text(measured_rows(DEPTH, FACTOR * STRENGTH, 0.8 * STRENGTH))
    found = interpret(load_site(changed(folder, *changes))).sel(depth=slice(2.05, 9.95))
    ratio = found.ground_resistance_ratio
    assert float(ratio.min()) > 1.2
    strength = found.net_resistance * ratio / FACTOR
    np.testing.assert_allclose(found.strength.sel(percentile=50.0), strength, rtol=0.01)


def test_a_rigidity_index_of_another_strength_is_converted(folder: Path) -> None:
    """G is 120 su of compression, 158.2 of the average su."""
    ratios = "simple_shear_ratio = 0.75\nextension_ratio = 0.525\n"
    mode = f'{ratios}rigidity_strength = "triaxial_compression"\n'
    of_compression = interpret(load_site(changed(folder, ("rate_factor", f"{mode}rate_factor"))))
    nkt = of_compression.resistance_factor.sel(percentile=50.0, depth=slice(2.05, 9.95))
    soil = {"adhesion_factor": 0.4, "stress_anisotropy": 0.2}
    expected = float(cone_factor(rigidity_index=120.0 * 3.0 / 2.275, **soil)[0])
    np.testing.assert_allclose(nkt, expected, rtol=1e-3)
    assert expected == pytest.approx(1.05 * FACTOR, rel=0.01)


def test_the_ground_of_the_tip_has_the_measured_resistance(folder: Path) -> None:
    """Of a simulation of it, at the rate of the table, whatever the rate of the laboratory."""
    rate = ("rate_factor = 0", "rate_factor = 0.1"), ("= 1e-6", "= 1e-4")
    ratio = interpret(load_site(changed(folder, *rate))).ground_resistance_ratio
    np.testing.assert_allclose(ratio.dropna("depth"), 1.0, rtol=1e-3)


@pytest.mark.parametrize(("keys", "times"), [("speed = 2", 10.0), ("cone_area = 40", 2.0)])
def test_a_slower_cone_is_like_a_faster_laboratory(folder: Path, keys: str, times: float) -> None:
    """The strain rate of a cone is its speed over its radius."""
    site = changed(folder, ("rate_factor = 0", "rate_factor = 0.1"), ("= 1e-6", "= 1e-5"))
    changed(folder, ("[test]", f"[test]\n{keys}"))
    slower = interpret(load_site(site))
    changed(folder, (f"{keys}\n", ""), ("= 1e-5", f"= {1e-5 * times}"))
    np.testing.assert_allclose(slower.strength, interpret(load_site(site)).strength, rtol=1e-9)


def test_draws_beyond_the_rate_effect_of_the_table_count_as_at_its_edge(folder: Path) -> None:
    """Some have no strength left at the rate of the table, 1 - 4 mu; the band stays."""
    rate = 'rate_factor = { mean = 0.04, deviation = 0.05, shape = "lognormal" }'
    site = changed(
        folder, ("rate_factor = 0", rate), ("laboratory_rate = 1e-6", "laboratory_rate = 1e-2")
    )
    found = interpret(load_site(site))
    used = found.reason.values == 0
    assert np.isfinite(found.strength.values[used]).all()
    np.testing.assert_allclose(found.error_share.sum("cause").values[used], 1.0)


def test_a_draw_just_beyond_the_table_counts_like_one_far_beyond_it(folder: Path) -> None:
    """At 0.25 no strength is left at the rate of the table: on either side it is the same."""
    site = load_site(changed(folder, ("laboratory_rate = 1e-6", "laboratory_rate = 1e-2")))
    drawn = {"rigidity_index": [100.0], "sensitivity": [3.0], "ductility": [20.0]}
    inputs = {name: np.repeat(value, 1000) for name, value in drawn.items()}
    inputs["rate_factor"] = np.full(1000, 0.01)
    inputs["rate_factor"][-3:] = 0.2, 0.2499, 0.3
    held, ratio = _in_table(site, 0, site.layers[0].laboratory_rate, inputs)
    for values in (ratio, *held.values()):
        np.testing.assert_allclose(values[-3:], values[-3])
