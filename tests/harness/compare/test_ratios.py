"""Ratios, differences and slopes with their half widths: closed forms, samples, and real cases."""

from pathlib import Path

import numpy as np
import pytest

from harness.compare.differences import difference, ratio, slope
from harness.compare.result_table import result_table
from mpm_warp.results import labelled
from tests.harness.compare.test_result_table import cone_and_bar, footings

STUDIES = Path(__file__).parents[3] / "studies"


def test_half_widths_are_those_of_samples() -> None:
    """Normal numbers of these means; a half width of 95 % is twice the standard deviation."""
    places = np.array([0.0, 1.0, 3.0])
    values = np.array([[11.4, 0.11], [10.8, 0.08], [9.9, 0.10]])
    drawn = np.random.default_rng(1).normal(values[:, 0], values[:, 1] / 2.0, (40_000, 3))
    for found, samples in (
        (difference((11.4, 0.11), (10.8, 0.08)), drawn[:, 0] - drawn[:, 1]),
        (ratio((11.4, 0.11), (10.8, 0.08)), drawn[:, 0] / drawn[:, 1]),
        (slope(places, values), np.polyfit(places, drawn.T, 1)[0]),
    ):
        # Samples tell a standard deviation to 0.35 %, a mean to half a percent of it.
        assert found[0] == pytest.approx(samples.mean(), abs=0.02 * found[1])
        assert found[1] == pytest.approx(2.0 * samples.std(), rel=0.02)


def test_differences_and_ratios_of_random_cases_are_inside() -> None:
    default, held_out = (
        np.genfromtxt(STUDIES / f"{name}.csv", delimiter=",", names=True)
        for name in ("held_out_default", "held_out")
    )
    known = list(zip(default["cone_factor"], default["cone_factor_uncertainty"], strict=True))
    fine = held_out["cone_factor_simulated"]
    pairs = [(i, j) for i in range(len(known)) for j in range(i)]
    found = []
    for i, j in pairs:
        for (value, half), truth in (
            (difference(known[i], known[j]), fine[i] - fine[j]),
            (ratio(known[i], known[j]), fine[i] / fine[j]),
        ):
            found.append(abs(value - truth) / half)
    assert len(pairs) == 276
    assert max(found) <= 1.0
    assert np.mean(np.array(found) <= 0.8) == pytest.approx(0.98, abs=0.006)
    errors = fine - np.array(known)[:, 0]
    # Of two cases: their mean square in common over the whole mean square.
    assert 1.0 - errors.var(ddof=1) / np.mean(errors**2) == pytest.approx(0.03, abs=0.005)


def test_the_ratio_of_two_scenes_in_one_soil_stands_below_the_tables() -> None:
    lines = result_table(cone_and_bar()).splitlines()
    said = "cone penetration over t bar penetration, adhesion_factor=0.5: 1.051 +- 0.012"
    assert said in lines
    assert not any("adhesion_factor=0.0:" in it for it in lines)  # no cone there
    assert not any(" over t bar" in it for it in result_table(footings(["completed"] * 2)))


def test_of_one_varied_number_difference_ratio_and_slope_stand_below() -> None:
    half_width = ([0.02, 0.03], "1", "uncertainty of the limit load")
    known = footings(["completed", "completed"]).assign(
        labelled(
            dims=("adhesion_factor",), role="uncertainty", bearing_capacity_uncertainty=half_width
        )
    )
    said = (
        "adhesion_factor from 0 to 1: difference 0.35 +- 0.04, ratio 1.061 +- 0.006, "
        "slope of the straight line 0.35 +- 0.04"
    )
    assert said in result_table(known).splitlines()
    assert "difference" not in result_table(footings(["completed", "completed"]))
    meshes = known.rename(adhesion_factor="cells_per_radius").assign_attrs(scene="cone_penetration")
    assert "difference" not in result_table(meshes)
