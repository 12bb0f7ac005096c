"""The straight line of strength in a layer: by hand, and of a site whose strength is one."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t

from harness.interpret.inference.line import PIECE, strength_line
from harness.interpret.lines import line_rows, line_table, lines_in_words
from harness.interpret.site import load_site
from harness.interpret.strength import interpret
from harness.interpret.tables.factors import factors
from mpm_warp.grid.fitted import Floats
from tests.harness.interpret.conftest import DEPTH, FACTOR, STRENGTH, changed, measured_rows

DRAWS = 4000
WIDTH = 2.0 * 1.645
"""Width of a band of 90 % over the deviation."""


def lines(depth: Floats, strength: Floats, within: float = 0.0) -> Floats:
    """Draws of intercept and slope of a layer that is the same in all draws."""
    drawn, every = np.tile(strength[:, None], DRAWS), np.arange(DRAWS)
    return strength_line(depth, drawn, np.full(DRAWS, within), every, seed=1)


def width(draws: Floats) -> float:
    low, high = np.quantile(draws, [0.05, 0.95])
    return float(high - low)


def test_a_straight_strength_is_its_own_line() -> None:
    depth = np.linspace(3.0, 9.0, 61)
    line = lines(depth, 8e3 + 1.5e3 * depth)
    np.testing.assert_allclose(line, np.tile([[8e3], [1.5e3]], DRAWS), rtol=1e-9)


@pytest.mark.parametrize("pieces", [20, 80, 320])
@pytest.mark.parametrize("cause", ["departure of a depth", "scatter about the line"])
def test_what_differs_from_depth_to_depth_averages_out(cause: str, pieces: int) -> None:
    """The mean has the deviation sigma / sqrt(n), the slope this over the deviation of z."""
    depth = (np.arange(pieces) + 0.5) * PIECE
    strength = 100e3 * (1.0 + depth / depth[-1])
    if cause == "departure of a depth":
        sigma, found = 0.1 * strength, lines(depth, strength, within=0.1)
    else:  # signs that change neither mean nor slope
        scatter = 10e3 * np.resize([1.0, -1.0, -1.0, 1.0], pieces)
        found = lines(depth, strength + scatter)
        by_student = 2.0 * t.ppf(0.95, pieces - 2) / WIDTH
        sigma = np.abs(scatter) * math.sqrt(pieces / (pieces - 2)) * by_student
    intercept, slope = found
    mean = WIDTH * math.sqrt(np.mean(sigma**2) / pieces)
    assert width(intercept + slope * depth.mean()) == pytest.approx(mean, rel=0.06)
    assert width(slope) == pytest.approx(mean / depth.std(), rel=0.06)


def test_the_band_holds_a_line_with_random_scatter() -> None:
    depth, random = np.arange(0.0, 20.0, 0.25), np.random.default_rng(7)
    truth, inside = 20e3 + 2e3 * depth, []
    for _ in range(200):
        strength = truth * (1.0 + 0.15 * random.normal(size=len(depth)))
        intercept, slope = lines(depth, strength)
        for at in (0, -1):
            low, high = np.quantile(intercept + slope * depth[at], [0.05, 0.95])
            inside.append(low <= truth[at] <= high)
    assert 0.84 < np.mean(inside) < 0.96


@pytest.mark.parametrize(
    ("length", "slope", "scatter", "is_sloped"),
    [
        (1.9, 5e3, 0.0, False),  # two pieces
        (2.9, 5e3, 0.0, True),
        (2.9, -5e3, 0.0, True),
        (20.0, 0.1e3, 10e3, False),
        (20.0, 2e3, 10e3, True),
    ],
)
def test_a_slope_is_there_if_it_is_significant(
    length: float, slope: float, scatter: float, is_sloped: bool
) -> None:
    depth = np.arange(4.0, 4.0 + length, 0.1)
    signs = np.where((depth - depth[0]) // PIECE % 2 == 0, 1.0, -1.0)
    strength = 50e3 + slope * depth + scatter * signs
    intercept, found = lines(depth, strength)
    assert bool(found.any()) is is_sloped
    if not is_sloped:
        assert np.median(intercept) == pytest.approx(strength.mean(), rel=0.01)


def test_the_line_of_an_exact_site_is_that_of_the_ground(folder: Path) -> None:
    """All inputs known: the error of the table is left, the same for all depths."""
    site = load_site(folder / "site.toml")
    found = interpret(site)
    own = found.isel(layer=0)
    np.testing.assert_allclose(own.line_depth, [2.0, 10.0])
    np.testing.assert_allclose(own.line_strength.sel(percentile=50), [11e3, 23e3], rtol=3e-4)
    half = 1.645 / 1.96 * factors().half_widths["cone_factor"]
    for figure, exact in (("intercept", 8e3), ("slope", 1.5e3)):
        low, middle, high = own[f"line_{figure}"].values
        assert middle == pytest.approx(exact, rel=3e-4)
        assert (high - low) / middle == pytest.approx(2.0 * half, rel=0.02)
    (said,) = lines_in_words(found)
    assert said.startswith("2 to 10 m: line su = a + b z = 8.")
    assert " z kPa from z = 2 to 10 m. It has 11." in said
    heading, row = line_table(site, found)
    assert dict(zip(heading, row, strict=True))["b 50% [kPa/m]"].startswith("1.5")
    assert len(line_rows(found)) == 2


def test_the_site_is_common_to_the_line_and_a_depth_is_not(folder: Path) -> None:
    """The band of the line is that of strength without the departure of a depth, and more."""
    mobilised = interpret(load_site(changed(folder, ('"isotropic"', '"mobilised"'))))
    line = mobilised.line_strength.mean("end").values[0]
    depth = mobilised.sel(depth=6.0, method="nearest")
    of_depth, of_line = (math.log(it[2] / it[0]) for it in (depth.strength.values, line))
    share = depth.error_share
    site = math.sqrt(float(share.sel(cause="site_factor") + share.sel(cause="numerical")))
    assert of_depth * site < of_line < 0.95 * of_depth


def test_depths_that_feel_another_layer_are_left_out(folder: Path) -> None:
    """Three times the strength below 6 m: the line of the upper layer does not see it."""
    strength = np.where(DEPTH > 6.0, 3.0, 1.0) * STRENGTH
    strength[(DEPTH > 5.99) & (DEPTH < 6.15)] *= 0.7
    (folder / "test.csv").write_text(measured_rows(DEPTH, FACTOR * strength, 0.4 * strength))
    text = (folder / "site.toml").read_text()
    layer = text[text.index("[[layer]]") :]
    lower = layer.replace("from = 2", "from = 6")
    upper = layer.replace("to = 10", "to = 6")
    thin = layer.replace("from = 2", "from = 10").replace("to = 10", "to = 10.15")
    (folder / "site.toml").write_text(text.replace(layer, upper + lower + thin))
    site = load_site(folder / "site.toml")
    found = interpret(site)
    slope = found.line_slope.sel(percentile=50).values
    np.testing.assert_allclose(slope[:2], [1.5e3, 4.5e3], rtol=1e-3)
    assert np.isnan(slope[2])
    assert lines_in_words(found)[2].endswith(
        "m: no line; no depth with a strength is free of other layers."
    )
    assert len(line_rows(found)) == 3
    assert [*csv.reader(map(",".join, line_table(site, found)))][3][4:] == [""] * 12
