"""The error of a factor by further runs: exact where the laws hold, told where it is not."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp.errors import ParameterError, UnfinishedRun
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.full_flow.limit_load import limit_load
from mpm_warp.scenes.full_flow.penetration import BallPenetration, TBarPenetration
from mpm_warp.scenes.sounding.sounding import Sounding
from mpm_warp.uncertainty import cone, full_flow, further_runs
from mpm_warp.uncertainty.further_runs import CARRIED_ON
from mpm_warp.uncertainty.laws import EFFECTS, curvature_error
from tests.mpm_warp.conftest import MEASURABLE, SHORT_BAR
from tests.mpm_warp.uncertainty.conftest import steady_run

pytestmark = pytest.mark.slow

CONE = ConePenetration(uncertainty="measured", material="von_mises")
BALL = BallPenetration(adhesion_factor=0.5)
FACTOR = 11.0
"""Of the cone and of the ball, without error."""
MESH, GROWTH, SPEED, DOMAIN = -0.4, 1.2, 0.07, 0.03
"""What mesh, growth, speed and window add to that of the cone."""
BALL_MESH, BALL_SPEED, BOTH, BALL_DOMAIN = -3.0, 0.6, 4.0, 0.05
"""What mesh, speed, both together and window add to that of the ball."""


def cell_size(test: ConePenetration) -> float:
    return math.sqrt(3.0) / round(test.cells_per_radius * math.sqrt(3.0))


def curvature(size: float) -> float:
    """What is known of the error of the mesh of `CONE` before anything is measured."""
    clay = {"rigidity_index": CONE.rigidity_index, "adhesion_factor": CONE.adhesion_factor}
    return float(curvature_error(cell_size=size, **clay))


def simulated(test: Any) -> float:
    """A factor that follows the laws exactly."""
    if isinstance(test, BallPenetration):
        speed = (test.speed_ratio * math.sqrt(test.rigidity_index)) ** 1.4
        mesh = (BALL_MESH + BOTH * speed) / test.cells_per_radius**2
        domain = BALL_DOMAIN * BALL.domain_extent / test.domain_extent
        return FACTOR + mesh + BALL_SPEED * speed + domain
    size = cell_size(test)
    return (
        FACTOR
        + MESH * size
        + curvature(size)
        + GROWTH * test.cell_growth**1.5 * size**1.3
        + SPEED * test.rigidity_index * test.speed_ratio**2
        + DOMAIN * (CONE.domain_radius / test.domain_radius) ** 2
    )


def run(test: Any, progress: Progress) -> xr.Dataset:
    """What a run would leave behind, at once."""
    progress(1.0)
    if isinstance(test, BallPenetration):
        made = xr.Dataset({"resistance_factor_change": 0.001, "empty_cells": 0.0})
        made["resistance_factor"] = simulated(test)
    else:
        made = steady_run(test, simulated(test))
        made = made.assign(cone_factor_uncertainty=0.1, cone_factor_uncertainty_bottom=0.1)
    return made.assign(run_time=((), 2.0, {"role": "measured"}), particle_updates=1e6)


def measured(test: Any, run: Any = run) -> xr.Dataset:
    return further_runs.with_measured_error(test, run, lambda fraction: None)


@pytest.mark.parametrize(
    ("test", "name"), [(CONE, "cone_factor"), (BALL, "resistance_factor")], ids=["cone", "ball"]
)
def test_effects_that_follow_the_laws_are_taken_off_exactly(test: Any, name: str) -> None:
    results = measured(test)
    assert float(results[name]) == pytest.approx(FACTOR, rel=1e-12)
    correction = FACTOR - simulated(test)
    assert float(results[f"{name}_correction"]) == pytest.approx(correction, abs=1e-10)
    assert float(results[f"{name}_further_mesh"]) == simulated(test.further_tests()["mesh"])


@pytest.mark.parametrize("angle", [60.0, 125.0, 150.0])
def test_the_run_with_smaller_cells_has_a_row_more_at_least(angle: float) -> None:
    """Rounding left the 2 rows of 125 degrees and the one of 150 as they are: nothing to solve."""
    case = dataclasses.replace(CONE, apex_angle=angle)
    finer = case.further_tests()["mesh"]
    rows = [test.cone.penetrometer.rows_on_face(test.cell_size) for test in (case, finer)]
    assert rows[1] > rows[0]


@pytest.mark.parametrize(
    ("test", "name", "shares"),
    [
        (CONE, "cone_factor", {"mesh": 0.2, "domain": 0.5}),
        (BALL, "resistance_factor", {"mesh": 1.0, "mesh_and_speed": 0.5}),
    ],
    ids=["cone", "ball"],
)
def test_the_half_width_is_a_share_of_the_error_of_the_best_run(
    test: Any, name: str, shares: dict[str, float]
) -> None:
    """Of a ball all of the mesh. The squares of the parts of the uncertainty add up."""
    finest, results = test.further_tests()["mesh"], measured(test)
    if test is CONE:
        size = cell_size(finest)
        left = {"mesh": abs(MESH * size + curvature(size)), "domain": DOMAIN / 1.4**2}
        others, known = {*cone.DIFFERENCES, "steadiness", "points", "noise"}, {"limit": 0.045}
    else:
        square = finest.cells_per_radius**-2.0
        left = {"mesh": -BALL_MESH * square, "mesh_and_speed": BOTH * (0.5 * 0.3) ** 1.4 * square}
        others, known = {*full_flow.DIFFERENCES, "steadiness", "points", "poles"}, {}
    known |= {it: share * left[it] for it, share in shares.items()}
    parts = {it: float(results[f"{name}_uncertainty_{it}"]) for it in others | known.keys()}
    assert {it: parts[it] for it in known} == pytest.approx(known)
    assert float(results[f"{name}_uncertainty"]) == pytest.approx(math.hypot(*parts.values()))
    assert f"{name}_uncertainty_bottom" not in results


def test_a_small_window_has_the_half_width_of_a_known_error() -> None:
    """Further runs alone gave 9.91 +- 0.14 with a radius of 5, 10.40 +- 0.11 with 10, not 10.71."""
    name = "cone_factor_uncertainty_domain"
    small = dataclasses.replace(CONE, domain_radius=10.0)
    assert float(measured(small)[name]) == pytest.approx(0.035 * (4.0**2 - 1.0))
    assert float(measured(CONE)[name]) == pytest.approx(0.5 * DOMAIN / 1.4**2)


def test_in_a_wider_window_the_cone_goes_farther_at_the_speed_of_the_approach() -> None:
    """The soil to pass is more by 0.4 of the extent above, and 0.5 of the new one for settling."""
    wider = CONE.further_tests()["domain"]
    assert wider.domain_above == pytest.approx(1.4 * CONE.domain_above)
    for name in ("approach", "penetration"):
        way = getattr(wider, name) - getattr(CONE, name)
        assert way == pytest.approx((0.4 + 0.5 * 1.4) * CONE.domain_above)


def test_the_noise_of_all_runs_counts() -> None:
    """Shift one run after the other by its noise: the shifts of Nc add up as squares."""
    shifts = []
    for shifted in (CONE, *CONE.further_tests().values()):

        def noisy(test: ConePenetration, progress: Progress, shifted=shifted) -> xr.Dataset:
            made = run(test, progress)
            made["cone_factor_simulated"] += EFFECTS["noise_of_further_runs"].half_width * (
                test == shifted
            )
            return made

        results = measured(CONE, noisy)
        shifts.append(float(results.cone_factor) - FACTOR)
    noise = float(results.cone_factor_uncertainty_noise)
    assert noise == pytest.approx(math.hypot(*shifts), rel=1e-9)


def test_run_time_and_progress_include_the_further_runs() -> None:
    fractions: list[float] = []
    results = further_runs.with_measured_error(CONE, run, fractions.append)
    assert float(results.uncertainty_run_time) == 8.0
    assert float(results.run_time) == 10.0
    assert results.run_time.attrs == {"role": "measured"}
    assert float(results.particle_updates) == 5e6
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)
    # Each run by what it takes: the case is a small part of what a case with its runs does.
    updates = CONE.own_size.particle_updates
    assert fractions[0] == pytest.approx(updates / CONE.run_size().particle_updates)


def coarse(test: ConePenetration, progress: Progress) -> xr.Dataset:
    """Of meshes whose error is too large for linear laws."""
    made = run(test, progress)
    made["cone_factor_simulated"] -= 6.0 * cell_size(test)
    return made


def failing(test: ConePenetration, progress: Progress) -> xr.Dataset:
    if test.cell_growth > CONE.cell_growth:
        raise UnfinishedRun("the resistance still changes", xr.Dataset())
    return run(test, progress)


def leaving_a_hole(test: BallPenetration, progress: Progress) -> xr.Dataset:
    is_finer = test.cells_per_radius > BALL.cells_per_radius
    return run(test, progress).assign(empty_cells=float(is_finer))


@pytest.mark.parametrize(
    ("made", "off", "reason"),
    [
        (coarse, -6.0 * cell_size(CONE), "their laws would take off {:.0%}, and hold up to 8%"),
        (failing, 0.0, "the run with more growth: the resistance still changes"),
    ],
)
def test_where_further_runs_do_not_tell_the_error_the_usual_correction_goes_on(
    made: Any, off: float, reason: str
) -> None:
    """What is taken off is the error of Tresca clay."""
    results = measured(CONE, made)
    told = reason.format(1.0 - (simulated(CONE) + off) / FACTOR)
    assert results.why_no_uncertainty == f"further runs: {told}: {CARRIED_ON}"
    assert np.isnan(results.cone_factor_uncertainty)
    usual = float(CONE.laws(penetration=CONE.penetration).correction)
    assert float(results.cone_factor) == simulated(CONE) + off + usual


def test_where_a_run_leaves_a_hole_nothing_is_known() -> None:
    reason = "hole: soil leaves one behind the body: nothing is corrected"
    assert measured(BALL, leaving_a_hole).why_no_uncertainty == reason


@pytest.mark.parametrize(
    ("scene", "given", "message"),
    [
        (
            ConePenetration,
            {"speed_ratio": 0.11},
            "uncertainty = measured: .*speed: the speed is too high",
        ),
        (ConePenetration, {"accuracy": "quick"}, "uncertainty = measured: .*too wide"),
        (
            ConePenetration,
            {"apex_angle": 120.0, "speed_ratio": 0.04},
            r"rho V\^2 is above 0.15 su with 2 rows of cells; .* speed_ratio\^2 <= 0.15$",
        ),
        (ConePenetration, {"cell_growth": 1.5}, "run with more growth, where cell_growth = 3"),
        (TBarPenetration, {"domain_extent": 80}, "needs a run with a wider window, where domain_"),
        (TBarPenetration, {"cells_per_radius": 2}, "cells_per_radius = 2 must be >= 3 where"),
        (TBarPenetration, {"cell_growth": 1.1}, "cell_growth = 1.1 must be <= 1 where"),
    ],
)
def test_where_no_law_holds_or_a_further_run_is_none_the_case_is_refused(
    scene: Any, given: dict[str, Any], message: str
) -> None:
    with pytest.raises(ParameterError, match=message):
        scene(uncertainty="measured", material="von_mises", **given)


def test_a_cone_is_run_with_its_further_runs() -> None:
    """Small and short: the cone does not pass all soil, so that nothing is said to be known."""
    test = ConePenetration(**MEASURABLE)
    known = dataclasses.replace(test, uncertainty="known")
    alone, results = known.run(), test.run()
    assert float(results.cone_factor_simulated) == float(alone.cone_factor_simulated)
    assert float(results.cone_factor_further_mesh) != float(alone.cone_factor_simulated)
    reason = (
        "further runs: the case: settling: soil that the cone has not passed is still beside it"
    )
    assert reason in str(results.why_no_uncertainty.values)
    size, whole = known.run_size(), test.run_size()
    assert whole.particle_updates > 5.0 * size.particle_updates
    assert whole.byte_count > size.byte_count


CAM_CLAY = {"material": "modified_cam_clay"}


@pytest.mark.parametrize(
    ("scene", "clay"),
    [
        (ConePenetration, {"remoulded_strength_ratio": 0.2, "ductility": 5.0}),
        (Sounding, CAM_CLAY),
        (TBarPenetration, CAM_CLAY),
    ],
)
def test_runs_that_are_not_made_are_not_counted(scene: Any, clay: dict[str, Any]) -> None:
    alone, asked = scene(**clay), scene(uncertainty="measured", **clay)
    assert asked.run_size() == alone.run_size()


def test_a_bar_is_run_with_its_further_runs() -> None:
    """Small and short, and held against the limit load with its error taken off."""
    bar = TBarPenetration(uncertainty="measured", **SHORT_BAR)
    fractions: list[float] = []
    results = bar.run(fractions.append)
    assert fractions == sorted(fractions)
    off = float(results.resistance_factor) - limit_load(0.0)
    # Elastic strains, which the limit load leaves out, take some 3 / Ir off.
    assert abs(off) <= float(results.resistance_factor_uncertainty) + 3 / bar.rigidity_index
    assert float(results.error) == pytest.approx(abs(off) / limit_load(0.0))
    expected = bar.run_size().particle_updates
    assert float(results.particle_updates) == pytest.approx(expected, rel=0.5)


def test_factors_over_each_strength_are_corrected_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def corrected(case: Any, run: Any, progress: Progress) -> xr.Dataset:
        made = run(dataclasses.replace(case, uncertainty="known"), progress)
        return made.assign(cone_factor=made.cone_factor + 1.0)

    monkeypatch.setattr(further_runs, "with_measured_error", corrected)
    clay: Any = {"material": "modified_cam_clay"}
    results = ConePenetration(**MEASURABLE, **clay).run()
    share = float(results.cone_factor_by_compression / results.cone_factor)
    assert share == pytest.approx(2.0 / math.sqrt(3.0))
    assert float(results.Bq * results.cone_factor) == pytest.approx(float(results.N_du))
