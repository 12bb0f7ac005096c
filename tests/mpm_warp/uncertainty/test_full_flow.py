"""The error of a resistance factor by further runs: exact where the laws hold, told where not."""

import math

import pytest
import xarray as xr

from mpm_warp.errors import ParameterError
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.full_flow.limit_load import limit_load
from mpm_warp.scenes.full_flow.penetration import BallPenetration, TBarPenetration
from mpm_warp.uncertainty.full_flow import DIFFERENCES
from mpm_warp.uncertainty.further_runs import with_measured_error

pytestmark = pytest.mark.slow

TEST = BallPenetration(adhesion_factor=0.5)
FACTOR, MESH, SPEED, BOTH, DOMAIN, CHANGE = 11.0, -3.0, 0.6, 4.0, 0.05, 0.001
"""A resistance factor, what mesh, speed, both together and window add to it, and its last change,
over it."""


def simulated(test: BallPenetration) -> float:
    """A resistance factor that follows the laws exactly."""
    assert test.speed_ratio is not None
    speed = (test.speed_ratio * math.sqrt(test.rigidity_index)) ** 1.4
    return (
        FACTOR
        + MESH / test.cells_per_radius**2
        + SPEED * speed
        + BOTH * speed / test.cells_per_radius**2
        + DOMAIN * TEST.domain_extent / test.domain_extent
    )


def run(test: BallPenetration, progress: Progress) -> xr.Dataset:
    """What a run would leave behind, at once."""
    progress(1.0)
    return xr.Dataset(
        {
            "resistance_factor": simulated(test),
            "resistance_factor_change": CHANGE,
            "empty_cells": 0.0,
            "run_time": ((), 2.0, {"role": "measured"}),
            "particle_updates": 1e6,
        }
    )


def test_errors_that_follow_the_laws_are_taken_off_exactly() -> None:
    results = with_measured_error(TEST, run, lambda fraction: None)
    assert float(results.resistance_factor) == pytest.approx(FACTOR, rel=1e-12)
    correction = FACTOR - simulated(TEST)
    assert float(results.resistance_factor_correction) == pytest.approx(correction, abs=1e-10)
    finer = TEST.further_tests()["mesh"]
    assert float(results.resistance_factor_further_mesh) == simulated(finer)


def test_of_what_the_best_run_still_has_the_mesh_leaves_all_open_and_the_rest_half() -> None:
    results = with_measured_error(TEST, run, lambda fraction: None)
    finest = TEST.further_tests()["mesh"].cells_per_radius
    left = float(results.resistance_factor_uncertainty_mesh)
    assert left == pytest.approx(-MESH / finest**2)
    slowest = (0.5 * 0.3) ** 1.4
    both = float(results.resistance_factor_uncertainty_mesh_and_speed)
    assert both == pytest.approx(0.5 * BOTH * slowest / finest**2)
    parts = [*DIFFERENCES, "steadiness", "points", "poles"]
    squares = [float(results[f"resistance_factor_uncertainty_{it}"]) ** 2 for it in parts]
    assert float(results.resistance_factor_uncertainty) == pytest.approx(math.sqrt(sum(squares)))


def test_the_further_runs_are_checked_before_anything_runs() -> None:
    with pytest.raises(ParameterError, match="needs a run with a wider window, where domain_"):
        TBarPenetration(uncertainty="measured", domain_extent=80)


def test_cells_too_wide_for_the_laws_are_refused() -> None:
    with pytest.raises(ParameterError, match="cells_per_radius = 2 must be >= 3 where uncertainty"):
        TBarPenetration(uncertainty="measured", cells_per_radius=2)


def test_where_a_run_leaves_a_hole_nothing_is_known() -> None:
    def leaving_a_hole(test: BallPenetration, progress: Progress) -> xr.Dataset:
        is_finer = test.cells_per_radius > TEST.cells_per_radius
        return run(test, progress).assign(empty_cells=float(is_finer))

    results = with_measured_error(TEST, leaving_a_hole, lambda fraction: None)
    reason = "hole: soil leaves one behind the body"
    assert results.why_no_uncertainty == reason


def test_a_case_is_run_with_its_further_runs() -> None:
    """Small and short, and held against the limit load with its error taken off."""
    bar = TBarPenetration(
        uncertainty="measured", cells_per_radius=3, domain_extent=4, penetration=6
    )
    fractions: list[float] = []
    results = bar.run(fractions.append)
    assert fractions == sorted(fractions)
    off = float(results.resistance_factor) - limit_load(0.0)
    # Elastic strains, which the limit load leaves out, take some 3 / Ir off.
    assert abs(off) <= float(results.resistance_factor_uncertainty) + 3 / bar.rigidity_index
    assert float(results.error) == pytest.approx(abs(off) / limit_load(0.0))
    expected = bar.run_size().particle_updates
    assert float(results.particle_updates) == pytest.approx(expected, rel=0.5)
