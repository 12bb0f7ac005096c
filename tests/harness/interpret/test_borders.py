"""Borders of layers: their effect on a resistance, its inversion, and the loop closed."""

import csv
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.interpret.inference import borders
from harness.interpret.inference.borders import sharpened
from harness.interpret.measured import NO_INDEX, REASONS
from harness.interpret.site import load_site
from harness.interpret.strength import interpret
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.sounding.sounding import Sounding
from tests.harness.conftest import Command
from tests.harness.interpret.conftest import FACTOR, LAYER, SITE, changed, measured_rows

RADIUS = 0.01785
BORDER = 5.0
DEPTH = np.arange(3.0, 7.0, 0.02)
WAY = (DEPTH - BORDER) / RADIUS
NET = {"above": 200e3, "below": 400e3}


def felt(ratio: float, factor_ratio: float) -> tuple[Floats, Floats]:
    """Net resistance of two uniform layers as a cone feels it, and of each layer alone."""
    logarithm = np.log(ratio) * borders.share_below(WAY, borders.NEAR)
    logarithm += np.log(factor_ratio) * borders.share_below(WAY, borders.FAR)
    own = np.where(WAY < 0.0, 1.0, ratio * factor_ratio)
    return NET["above"] * np.exp(logarithm), NET["above"] * own


@pytest.mark.parametrize("kernel", [borders.NEAR, borders.FAR])
def test_the_shares_of_the_soil_are_all_of_the_weight(kernel: tuple[float, float]) -> None:
    edges = np.linspace(-100.0, 100.0, 101)
    shares = borders.averaging(WAY, edges, kernel)
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, rtol=0.0, atol=1e-14)
    below = shares @ (edges[:-1] >= 0.0)
    np.testing.assert_allclose(below, borders.share_below(WAY, kernel), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("told", [-5.0, 0.0, 5.0])
@pytest.mark.parametrize("ratio", [0.25, 0.5, 2.0, 4.0])
def test_strength_is_told_exactly_where_only_it_changes(ratio: float, told: float) -> None:
    """Uniform layers have no curvature and no jump of Nkt: the least squares are 0, their rounding
    is that of 1e-16 times the condition of the normal equations, below 1e9."""
    net, own = felt(ratio, 1.0)
    found, placed = sharpened(DEPTH, net, [BORDER + told * RADIUS], RADIUS)
    np.testing.assert_allclose(found, own, rtol=1e-6)
    np.testing.assert_allclose(placed, BORDER, rtol=1e-12)


@pytest.mark.parametrize("factor_ratio", [0.75, 4 / 3])
def test_stiffness_acts_from_farther_away(factor_ratio: float) -> None:
    """At least half of what a change of Nkt does is taken away: its place and size compete."""
    net, own = felt(1.0, factor_ratio)
    near = np.abs(WAY) < 15.0
    both = net, sharpened(DEPTH, net, [BORDER], RADIUS)[0]
    before, after = (np.abs(np.log(it / own))[near].mean() for it in both)
    assert after < 0.5 * before


def test_uniform_ground_and_what_is_missing_stay() -> None:
    net = np.full_like(DEPTH, NET["above"])
    net[[0, 50, -1]] = np.nan
    np.testing.assert_allclose(sharpened(DEPTH, net, [BORDER], RADIUS)[0], net, rtol=1e-12)
    sharp, placed = sharpened(DEPTH, net, [2.0, 8.0], RADIUS)
    np.testing.assert_array_equal(sharp, net)
    assert placed == [2.0, 8.0]


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.03])
def test_a_border_that_the_resistance_does_not_show_stays_where_it_is_told(noise: float) -> None:
    for seed in range(10 if noise else 1):
        scatter = np.random.default_rng(seed).normal(0.0, noise, DEPTH.size)
        growing = NET["above"] * (DEPTH + 2.0) * np.exp(scatter)
        assert sharpened(DEPTH, growing, [BORDER], RADIUS)[1] == [BORDER]


@pytest.mark.parametrize(("ratio", "before", "behind"), [(2.0, 3.0, 9.0), (0.5, 7.0, 4.0)])
def test_borders_reach_far_in_the_stronger_layer(
    ratio: float, before: float, behind: float
) -> None:
    net, _ = felt(ratio, 1.0)
    marked = WAY[borders.near_border(DEPTH, net, [1.0, BORDER, 9.0], RADIUS)]
    spacing = 0.02 / RADIUS
    assert -before < marked[0] < -before + spacing
    assert behind - spacing < marked[-1] < behind


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.5, 2.0])
def test_the_effect_of_a_simulated_border_is_halved_at_least(ratio: float) -> None:
    """The runs of `two_layers`, to 32 radii behind the border: the error of su within 15 radii."""
    found = Sounding(
        cone_radius=1.0,
        rigidity_index=100.0,
        cells_per_radius=2.3,
        speed_ratio=0.1,
        from_depth=40.0,
        layer_top=56.0,
        to_depth=81.0,
        layer_strength_ratio=ratio,
    ).run()
    way, net = found.depth.values - 56.0, found.net_resistance.values
    own = np.where(way < 0.0, 1.0, ratio) * net[:100].mean()
    near = np.abs(way) < 15.0
    both = net, sharpened(found.depth.values, net, [56.0], 1.0)[0]
    before, after = (np.abs(it / own - 1.0)[near].mean() for it in both)
    assert after < 0.5 * before


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A site of two layers, of 20 and 40 kPa and one Nkt, all inputs and measured values exact."""
    net, _ = felt(2.0, 1.0)
    net *= FACTOR * 20e3 / NET["above"]
    (tmp_path / "test.csv").write_text(measured_rows(DEPTH, net, 0.04 * net))
    layers = [
        LAYER.replace("from = 2", f"from = {top}").replace("to = 10", f"to = {bottom}")
        for top, bottom in ((3.0, BORDER), (BORDER, 7.0))
    ]
    (tmp_path / "site.toml").write_text("".join([SITE, *layers]))
    return tmp_path


def test_a_site_of_two_layers_is_sharpened(folder: Path) -> None:
    """The strength is that of each layer up to its border; the effect widens the error of the test.

    Of 2048 draws the median is off by less than a stratum's width of the table's error; what is
    left of the border adds 1 of 2048 ranks of `LEFT` times the effect at most.
    """
    site = load_site(folder / "site.toml")
    blurred, sharp = interpret(site), interpret(site, sharpen=True)
    own = np.where(DEPTH < BORDER, 20e3, 40e3)
    near = np.abs(WAY) < 15.0
    error = np.abs(blurred.strength.sel(percentile=50.0).values / own - 1.0)
    assert error[near].max() > 0.2
    np.testing.assert_allclose(sharp.strength.sel(percentile=50.0), own, rtol=5e-4)
    effect = np.abs(sharp.sharpened_resistance - sharp.net_resistance).values
    widest = int(effect.argmax())
    half = borders.LEFT * effect[widest] / sharp.sharpened_resistance.values[widest]
    low, middle, high = sharp.strength.values[widest]
    assert (high - low) / 2.0 / middle > half * 1.645 / 1.96
    assert 0 < int(sharp.near_border.sum()) == int(blurred.near_border.sum())


@pytest.mark.parametrize("shift", [-5.5, 5.5])
def test_no_strength_between_border_told_and_border_found(folder: Path, shift: float) -> None:
    """There the layer whose inputs hold by the site file is not that of the resistance."""
    told = BORDER + shift * RADIUS
    path = changed(folder, ("to = 5.0", f"to = {told}"), ("from = 5.0", f"from = {told}"))
    site = load_site(path)
    found, as_told = interpret(site, sharpen=True), interpret(site)
    off = np.abs(DEPTH - BORDER) > 0.005  # that row is just above or just below what is found
    between = (np.sign(DEPTH - told) != np.sign(DEPTH - BORDER)) & off
    left = found.reason.values == REASONS.index("between border told and found")
    assert between.any()
    np.testing.assert_array_equal(left[off], between[off])
    for name in ("strength", "ground_strength"):  # the second is what --check simulates
        assert np.isnan(found[name].values[left]).all()
    own = np.where(DEPTH < BORDER, 20e3, 40e3)
    used = (found.reason.values == 0) & off
    middle = found.strength.sel(percentile=50.0).values
    np.testing.assert_allclose(middle[used], own[used], rtol=5e-4)
    assert f"border told at {told:.2f} m, found at 5.00 m" in found.attrs["notes"]
    assert not as_told.attrs["notes"]
    assert (as_told.reason.values[between] == 0).all()


@pytest.mark.parametrize("has_sleeve", [True, False])
def test_clay_beside_sand_in_a_layer_feels_another_layer(folder: Path, has_sleeve: bool) -> None:
    """In rows 1.12 radii apart 2 of the 3 radii above it, and 3 of the 4 below; 3 rows are none.

    Without fs, beside what may be sand as well.
    """
    first, end = 30, 45
    table = [line.split(",") for line in (folder / "test.csv").read_text().splitlines()]
    for row in (*range(first, end), 60, 61, 62):
        table[1 + row][1] = "10"
    if not has_sleeve:
        table[1:] = [[depth, qc, "", u2] for depth, qc, _, u2 in table[1:]]
    (folder / "test.csv").write_text("\n".join(map(",".join, table)))
    found = interpret(load_site(folder / "site.toml"))
    sand = REASONS.index("not undrained clay" if has_sleeve else NO_INDEX)
    assert (found.reason[[*range(first, end), 60, 61, 62]] == sand).all()
    felt = (found.near_border.values == 1) & (found.reason.values == 0) & (DEPTH < BORDER - 0.2)
    np.testing.assert_array_equal(
        np.flatnonzero(felt), [first - 2, first - 1, *range(end, end + 3)]
    )


@pytest.mark.usefixtures("undrawn")
def test_a_table_has_the_resistance_that_its_strength_is_by(folder: Path, command: Command) -> None:
    """su Nkt, both medians, is qnet, or qnet without borders where these are taken away."""
    for out, title, options in (
        ("as_measured", "qnet [kPa]", ()),
        ("sharp", "qnet without borders [kPa]", ("--sharpen",)),
    ):
        told = command("interpret", folder / "site.toml", *options, "--out", folder / out)
        assert ("and its effect is removed at borders" in told.out) == (out == "sharp")
        rows = csv.DictReader((folder / out / "site_interpretation.csv").read_text().splitlines())
        used = [row for row in rows if row["reason"] == "used"]
        products = [float(row["su 50% [kPa]"]) * float(row["Nkt 50% [1]"]) for row in used]
        np.testing.assert_allclose(products, [float(row[title]) for row in used], rtol=1e-3)


@pytest.mark.slow
def test_the_loop_is_closed_from_the_command_line(folder: Path, command: Command) -> None:
    """A sounding through what was found gives what was measured.

    Away from the border within the numerical errors of the table and of the simulation, 3 % and
    1.5 %.
    """
    out, rows = folder / "out", (folder / "test.csv").read_text().splitlines()
    (folder / "test.csv").write_text("\n".join([rows[0], *rows[36:-35]]))  # what is simulated
    asked = "--sharpen", "--check", "--out", out, "--format", "pdf"
    told = command("interpret", folder / "site.toml", *asked)
    assert told.out.count("simulated net resistance differs from the expected one") == 2
    assert "simulating the sounding, quick: about " in told.err
    found = xr.open_dataset(out / "site_check.nc")
    away = (np.abs(found.depth - BORDER) > 15.0 * RADIUS) & np.isfinite(found.misfit)
    assert away.sum() > 100
    assert np.abs(found.misfit[away]).mean() < np.hypot(0.03, 0.015)
    assert (out / "site_check.pdf").exists()
    assert not (out / "site_check.png").exists()
