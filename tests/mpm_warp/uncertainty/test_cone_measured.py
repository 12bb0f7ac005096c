"""The error of a cone factor by further runs: exact where the laws hold, told where it is not."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp.errors import ParameterError, UnfinishedRun
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.uncertainty import further_runs
from mpm_warp.uncertainty.cone import DIFFERENCES, NOISE
from mpm_warp.uncertainty.further_runs import with_measured_error
from tests.mpm_warp.conftest import MEASURABLE

pytestmark = pytest.mark.slow

TEST = ConePenetration(uncertainty="measured", material="von_mises")
FACTOR, MESH, GROWTH, SPEED, DOMAIN = 11.0, -0.4, 1.2, 0.07, 0.03
"""A cone factor, and what mesh, speed and window add to it."""


def simulated(test: ConePenetration) -> float:
    """A cone factor that follows the laws exactly."""
    size = cell_size(test)
    assert test.domain_radius is not None
    assert TEST.domain_radius is not None
    return (
        FACTOR
        + MESH * size
        + GROWTH * test.cell_growth**1.5 * size**1.3
        + SPEED * test.rigidity_index * test.speed_ratio**2
        + DOMAIN * (TEST.domain_radius / test.domain_radius) ** 2
    )


def cell_size(test: ConePenetration) -> float:
    assert test.cells_per_radius is not None
    return math.sqrt(3.0) / round(test.cells_per_radius * math.sqrt(3.0))


def run(test: ConePenetration, progress: Progress) -> xr.Dataset:
    """What a run would leave behind, steady and at once."""
    progress(1.0)
    factor = simulated(test)
    resistance = factor * test.undrained_shear_strength * np.ones(60)
    return xr.Dataset(
        {
            "penetration_resistance": ("penetration", resistance),
            "cone_factor_simulated": factor,
            "cone_factor_shear": 0.0,
            "cone_factor_uncertainty": 0.1,
            "cone_factor_uncertainty_bottom": 0.1,
            "penetration_reached": test.penetration,
            "run_time": ((), 2.0, {"role": "measured"}),
            "particle_updates": 1e6,
        }
    )


def test_effects_that_follow_the_laws_are_taken_off_exactly() -> None:
    results = with_measured_error(TEST, run, lambda fraction: None)
    assert float(results.cone_factor) == pytest.approx(FACTOR, rel=1e-12)
    correction = FACTOR - simulated(TEST)
    assert float(results.cone_factor_correction) == pytest.approx(correction, abs=1e-10)


def test_half_of_what_the_best_run_still_has_is_left_open() -> None:
    results = with_measured_error(TEST, run, lambda fraction: None)
    finest = cell_size(TEST.further_tests()["mesh"])
    assert float(results.cone_factor_uncertainty_mesh) == pytest.approx(-0.5 * MESH * finest)
    assert float(results.cone_factor_uncertainty_domain) == pytest.approx(0.5 * DOMAIN / 1.4**2)
    parts = [*DIFFERENCES, "steadiness", "points", "noise"]
    squares = [float(results[f"cone_factor_uncertainty_{it}"]) ** 2 for it in parts]
    assert float(results.cone_factor_uncertainty) == pytest.approx(math.sqrt(sum(squares)))
    assert "cone_factor_uncertainty_bottom" not in results


def test_in_a_wider_window_the_cone_goes_farther_at_the_speed_of_the_approach() -> None:
    """The soil to pass is more by 0.4 of the extent above, and 0.5 of the new one for settling."""
    wider = TEST.further_tests()["domain"]
    assert wider.domain_above == pytest.approx(1.4 * TEST.domain_above)
    for name in ("approach", "penetration"):
        way = getattr(wider, name) - getattr(TEST, name)
        assert way == pytest.approx((0.4 + 0.5 * 1.4) * TEST.domain_above)


def test_an_error_too_large_for_linear_laws_is_not_known() -> None:
    def coarse(test: ConePenetration, progress: Progress) -> xr.Dataset:
        made = run(test, progress)
        made["cone_factor_simulated"] -= 4.0 * cell_size(test)
        return made

    results = with_measured_error(TEST, coarse, lambda fraction: None)
    reason = str(results.why_no_uncertainty.values)
    left = simulated(TEST) - 4.0 * cell_size(TEST)
    assert reason == (
        f"further runs: their laws would take off {1.0 - left / FACTOR:.0%}, and hold up to 12%"
    )
    assert float(results.cone_factor) == left


def test_the_noise_of_all_runs_counts() -> None:
    """Shift one run after the other by its noise: the shifts of Nc add up as squares."""
    shifts = []
    for shifted in (TEST, *TEST.further_tests().values()):

        def noisy(test: ConePenetration, progress: Progress, shifted=shifted) -> xr.Dataset:
            made = run(test, progress)
            if test == shifted:
                made["cone_factor_simulated"] += NOISE
            return made

        results = with_measured_error(TEST, noisy, lambda fraction: None)
        shifts.append(float(results.cone_factor) - FACTOR)
    noise = float(results.cone_factor_uncertainty_noise)
    assert noise == pytest.approx(math.hypot(*shifts), rel=1e-9)


def test_what_the_runs_took_is_told() -> None:
    fractions: list[float] = []
    results = with_measured_error(TEST, run, fractions.append)
    assert float(results.uncertainty_run_time) == 8.0
    assert float(results.run_time) == 10.0
    assert results.run_time.attrs == {"role": "measured"}
    assert float(results.particle_updates) == 5e6
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1.0)


def test_a_run_that_fails_leaves_the_case_without_a_known_error() -> None:
    def failing(test: ConePenetration, progress: Progress) -> xr.Dataset:
        if test.cell_growth > TEST.cell_growth:
            raise UnfinishedRun("the resistance still changes", xr.Dataset())
        return run(test, progress)

    results = with_measured_error(TEST, failing, lambda fraction: None)
    reason = "further runs: the run with more growth: the resistance still changes"
    assert results.why_no_uncertainty == reason
    assert np.isnan(results.cone_factor_uncertainty)
    assert float(results.cone_factor) == simulated(TEST)


@pytest.mark.parametrize(
    ("changed", "reason"),
    [({"speed_ratio": 0.2}, "speed: it is too high"), ({"accuracy": "quick"}, "too wide")],
)
def test_where_no_law_holds_the_case_is_refused(changed: dict[str, Any], reason: str) -> None:
    with pytest.raises(ParameterError, match=f"uncertainty = measured: .*{reason}"):
        ConePenetration(uncertainty="measured", material="von_mises", **changed)


def test_the_further_runs_are_checked_before_anything_runs() -> None:
    with pytest.raises(ParameterError, match="needs a run with more growth, where cell_growth = 3"):
        ConePenetration(uncertainty="measured", cell_growth=1.5)


def test_a_case_is_run_with_its_further_runs() -> None:
    """Small and short: the cone does not pass all soil, so that nothing is said to be known."""
    test = ConePenetration(**MEASURABLE)
    alone = dataclasses.replace(test, uncertainty="known").run()
    results = test.run()
    assert float(results.cone_factor_simulated) == float(alone.cone_factor_simulated)
    assert float(results.cone_factor_further_mesh) != float(alone.cone_factor_simulated)
    reason = (
        "further runs: the case: settling: soil that the cone has not passed is still beside it"
    )
    assert reason in str(results.why_no_uncertainty.values)
    size, whole = dataclasses.replace(test, uncertainty="known").run_size(), test.run_size()
    assert whole.particle_updates > 5.0 * size.particle_updates
    assert whole.byte_count > size.byte_count


def test_factors_by_each_strength_are_corrected_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def corrected(case: Any, run: Any, progress: Progress) -> xr.Dataset:
        made = run(dataclasses.replace(case, uncertainty="known"), progress)
        return made.assign(cone_factor=made.cone_factor + 1.0)

    monkeypatch.setattr(further_runs, "with_measured_error", corrected)
    clay: Any = {"material": "modified_cam_clay"}
    results = ConePenetration.offered()(**MEASURABLE, **clay).run()
    share = float(results.cone_factor_by_compression / results.cone_factor)
    assert share == pytest.approx(2.0 / math.sqrt(3.0))
    assert float(results.Bq * results.cone_factor) == pytest.approx(float(results.N_du))
