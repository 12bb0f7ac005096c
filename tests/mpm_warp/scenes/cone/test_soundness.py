"""What is no cone factor: one that still changes, one that soil cannot give; where work goes."""

import dataclasses
import math
from contextlib import nullcontext
from typing import Any

import pytest
import xarray as xr

from mpm_warp import EnergyBalance, InaccurateRun, Tresca, UnfinishedRun
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.soundness import (
    LARGEST_RESIDUAL,
    MEANING,
    check_bound,
    check_levelled,
)
from tests.mpm_warp.conftest import SMALL_WINDOW
from tests.mpm_warp.scenes.cone.conftest import LONGER

pytestmark = pytest.mark.slow

SHORT = ConePenetration(**SMALL_WINDOW, cells_per_radius=1, penetration=2)


def test_a_run_that_was_to_be_steady_and_still_rises_is_unfinished_and_keeps_its_numbers() -> None:
    expected = dataclasses.replace(SHORT, steady_tolerance=0.0).run()
    with pytest.raises(
        UnfinishedRun, match=r"still changes by \d+% .* 2 radii; try more penetration"
    ) as end:
        SHORT.run()
    assert end.value.status == "unfinished"
    assert float(end.value.curves.cone_factor) == float(expected.cone_factor)
    xr.testing.assert_equal(
        end.value.curves.penetration_resistance, expected.penetration_resistance
    )


def test_the_resistance_may_still_change_by_a_twentieth() -> None:
    results = xr.Dataset({"cone_factor_variation": 0.049, "penetration_reached": 30.0})
    check_levelled(results)
    with pytest.raises(UnfinishedRun):
        check_levelled(results.assign(cone_factor_variation=0.051))


@pytest.mark.parametrize(
    ("changed", "share"),
    [
        ({}, 1.0),
        ({"adhesion_factor": 0.5}, 1.0),
        ({"material": "von_mises"}, 2 / math.sqrt(3)),
        # 20 mm/s over 17.85 mm is 1.12 1/s: 2.05 log cycles.
        ({"rate_factor": 0.1, "reference_strain_rate": 0.01}, 1.205),
        ({"speed_ratio": 0.3}, 1.0),
    ],
)
def test_no_cone_factor_is_above_twice_the_estimate_and_inertia(
    changed: dict[str, Any], share: float
) -> None:
    test = dataclasses.replace(SHORT, **changed)
    # The shear on the face of 60 degrees: the adhesion over tan(30 degrees).
    estimate = 4 / 3 * share * (1 + math.log(100 / share))
    estimate += test.adhesion_factor * math.sqrt(3)
    # The face of 60 degrees moves out at half the speed of the cone.
    bound = 2 * estimate + 3 / 2 * 100 * (test.speed_ratio / 2) ** 2
    for factor in (0.999, 1.001):
        results = xr.Dataset({"cone_factor": factor * bound})
        with nullcontext() if factor < 1 else pytest.raises(InaccurateRun, match=r"is above"):
            check_bound(results, test.build(), test.undrained_shear_strength)


def test_the_bound_is_that_of_the_soil_built() -> None:
    """A subclass may build a soil that its parameters do not tell of."""
    scene = SHORT.build()
    assert isinstance(scene.material, Tresca)
    twice = dataclasses.replace(scene.material, strength=2 * SHORT.undrained_shear_strength)
    results = xr.Dataset({"cone_factor": 20.0})
    with pytest.raises(InaccurateRun):
        check_bound(results, scene, SHORT.undrained_shear_strength)
    stronger = dataclasses.replace(scene, material=twice)
    check_bound(results, stronger, SHORT.undrained_shear_strength)


def test_a_cone_too_fast_for_its_soil_has_no_cone_factor() -> None:
    """The inertia of the soil, rho V^2 / su = 45, is more than its strength."""
    with pytest.raises(InaccurateRun) as end:
        dataclasses.replace(SHORT, rigidity_index=5000, speed_ratio=0.095, steady_tolerance=0).run()
    assert end.value.curves.cone_factor > 2 * 4 / 3 * (1 + math.log(5000))


def shares(results: xr.Dataset) -> dict[str, float]:
    return {name: float(results[f"work_share_{name}"]) for name in MEANING}


def test_the_balance_closes(rough: xr.Dataset) -> None:
    """It changes no bit of a run, see `test_history.py`, and is kept where it is asked for."""
    assert abs(float(rough.energy_residual)) < LARGEST_RESIDUAL
    assert sum(shares(rough).values()) + float(rough.energy_residual) == pytest.approx(1.0)
    assert LONGER.build().find(EnergyBalance) is None


def test_a_smooth_cone_loses_nothing_by_sliding(rough: xr.Dataset) -> None:
    """Its soil takes all of the work; a rough one loses what the adhesion takes along its way."""
    smooth = shares(dataclasses.replace(LONGER, energy_audit="balance").run())
    assert smooth["sliding"] == pytest.approx(0.0, abs=1e-3)
    of_soil = smooth["plastic"] + smooth["elastic"] + smooth["ground"]
    assert of_soil == pytest.approx(1.0, abs=0.02)
    # On the shaft, 6 radii long, soil hardly moves: at an adhesion of 0.5 su that is 6 of Nc.
    on_shaft = 6.0 / (6.0 + float(rough.cone_factor_simulated))
    assert shares(rough)["sliding"] > 0.9 * on_shaft
