"""What the method of a cone test is by default: cheaper where laws take its error off."""

import dataclasses
import math
from typing import Any

import pytest

from mpm_warp.errors import ParameterError
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.sounding.sounding import Sounding
from mpm_warp.uncertainty.cone import why_laws_do_not_hold
from mpm_warp.uncertainty.laws import LARGEST_INERTIA

ROUNDING = 1e-9
SOFTENING = {"remoulded_strength_ratio": 0.5, "ductility": 10.0}


@pytest.mark.parametrize(
    ("rigidity_index", "changes", "name", "value"),
    [
        (100.0, {}, "approach_speed_ratio", 0.25),
        (5000.0, {}, "approach_speed_ratio", math.sqrt(7.0 / 5000.0)),
        (100.0, {"apex_angle": 90.0}, "approach_speed_ratio", 0.25),
        (100.0, {"apex_angle": 91.0}, "approach_speed_ratio", math.sqrt(1.4 / 100.0)),
        # Ir V^2 over the square of the shear wave's speed is that at Ir 100, 0.09.
        (64.0, {}, "speed_ratio", 0.0375),
        (25.0, {}, "speed_ratio", 0.05),
        (400.0, {}, "speed_ratio", 0.03),
        (25.0, {"accuracy": "quick"}, "speed_ratio", 0.045),
        (25.0, {"accuracy": "fine"}, "speed_ratio", 0.03),
        (64.0, {"material": "von_mises"}, "speed_ratio", 0.03),
        (64.0, SOFTENING, "speed_ratio", 0.0375),
        (99.0, {"accuracy": "quick"}, "cell_size", math.sqrt(3.0) / 4.0),
        (100.0, {"accuracy": "quick"}, "cell_size", math.sqrt(3.0) / 3.0),
        (99.0, {}, "cell_size", math.sqrt(3.0) / 6.0),
        (100.0, {}, "cell_size", math.sqrt(3.0) / 5.0),
        (300.0, {}, "cell_size", math.sqrt(3.0) / 5.0),
        (301.0, {}, "cell_size", math.sqrt(3.0) / 4.0),
        (301.0, {"accuracy": "fine"}, "cell_size", math.sqrt(3.0) / 8.0),
        (500.0, {"accuracy": "fine"}, "speed_ratio", 0.02),
        (301.0, {"uncertainty": "measured"}, "cell_size", math.sqrt(3.0) / 5.0),
        (64.0, SOFTENING, "cell_size", math.sqrt(3.0) / 6.0),
        (64.0, {"material": "von_mises"}, "cell_size", math.sqrt(3.0) / 5.0),
        (301.0, {"apex_angle": 75.0}, "cell_size", math.tan(math.radians(52.5)) / 3.0),
        (301.0, {"apex_angle": 76.0}, "cell_size", math.tan(math.radians(52.0)) / 4.0),
        (99.0, {}, "poissons_ratio_bound", 0.475),
    ],
)
def test_speed_and_cells_follow_the_clay(
    rigidity_index: float, changes: dict[str, Any], name: str, value: float
) -> None:
    test = ConePenetration(rigidity_index=rigidity_index, cone_radius=1.0, **changes)
    assert getattr(test, name) == pytest.approx(value, rel=ROUNDING)


def test_quick_tests_in_very_stiff_clay_are_no_faster_than_their_error_is_known() -> None:
    test = ConePenetration(accuracy="quick", rigidity_index=2000.0)
    assert why_laws_do_not_hold(test.laws(penetration=test.penetration)) == []
    inertia = test.rigidity_index * test.speed_ratio**2
    assert inertia == pytest.approx(LARGEST_INERTIA, rel=2.0 * ROUNDING)


@pytest.mark.parametrize(
    ("rigidity_index", "accuracy", "bulk_modulus"),
    [(200.0, "standard", 5e3), (20.0, "quick", 250.0), (400.0, "fine", 1e4)],
)
def test_stiff_clay_whose_error_is_known_has_a_bulk_modulus_that_is_bounded(
    rigidity_index: float, accuracy: str, bulk_modulus: float
) -> None:
    """K / G = 2 (1 + nu) / (3 (1 - 2 nu)), and K is given over su."""
    test = ConePenetration(rigidity_index=rigidity_index, accuracy=accuracy)
    bound = test.poissons_ratio_bound
    over_shear = 2.0 * (1.0 + bound) / (3.0 * (1.0 - 2.0 * bound))
    assert over_shear * test.rigidity_index == pytest.approx(bulk_modulus, rel=1e-12)


@pytest.mark.parametrize(
    "changes",
    [
        {"material": "von_mises"},
        {"apex_angle": 90.0},
        {"uncertainty": "measured"},
        {"rigidity_index": 2.0, "accuracy": "fine"},
    ],
)
def test_a_bulk_modulus_is_bounded_only_where_its_effect_is_corrected(
    changes: dict[str, Any],
) -> None:
    assert ConePenetration(**{"rigidity_index": 400.0} | changes).poissons_ratio_bound == 0.4999


def test_the_bound_by_default_takes_nothing_off_up_to_ir_100_and_has_a_least_value() -> None:
    assert ConePenetration().poissons_ratio_bound > ConePenetration().poissons_ratio
    assert ConePenetration(rigidity_index=2000.0).poissons_ratio_bound == 0.45


def test_a_scene_of_another_package_has_no_method_by_default_that_needs_a_known_error() -> None:
    """It may build another clay, whose error no law takes off."""

    class OwnTest(ConePenetration):
        pass

    for index in (50.0, 400.0):
        test = OwnTest(rigidity_index=index)
        assert (test.poissons_ratio_bound, test.speed_ratio) == (0.4999, 0.03)


@pytest.mark.parametrize("index", [50.0, 500.0])
def test_further_runs_have_the_method_of_the_test_whose_error_they_measure(index: float) -> None:
    test = ConePenetration(rigidity_index=index, uncertainty="measured")
    changed = {"mesh": "cells_per_radius", "speed": "speed_ratio"}
    for choice, further in test.further_tests().items():
        for name in ("cells_per_radius", "speed_ratio", "poissons_ratio_bound"):
            is_same = getattr(further, name) == getattr(test, name)
            assert is_same is (changed.get(choice) != name)


def test_waves_that_grow_on_many_rows_are_told_before_the_run() -> None:
    """Of 56 rows beside the face; slow soil or small steps are no reason, nor are fewer rows."""
    fine = ConePenetration(poissons_ratio=0.45, cells_per_radius=32.33, approach_speed_ratio=0.14)
    assert "crosses 929 rows of cells at 0.14" in fine.likely_failure
    for sound in (
        {"approach_speed_ratio": 0.07},
        {"time_step_fraction": 0.4},
        {"cells_per_radius": 16.17},
    ):
        assert dataclasses.replace(fine, **sound).likely_failure == ""


def sounding(rows: str, **given: float) -> Sounding:
    """From 3 to 5 m through ground of rows of depth [m], strength [kPa] and rigidity index."""
    profile = f"depth [m], strength [kPa], rigidity_index [1]; {rows}"
    return Sounding(profile=profile, from_depth=3.0, to_depth=5.0, **given)


def test_a_remedy_is_told_in_the_speed_of_the_scene() -> None:
    """That of a sounding is over the waves of the softest soil, here half as stiff."""
    rows = "0, 20, 100; 4, 20, 100; 4, 20, 200; 9, 20, 200"
    fast = sounding(rows, speed_ratio=0.45, cells_per_radius=1.5)
    scaled = math.sqrt(2.0) * math.sqrt(5.0 / 200.0)
    assert f"try speed_ratio = {scaled:.2g} or less" in fast.likely_failure


def test_what_a_sounding_is_likely_to_fail_by_is_told() -> None:
    """Speed, by the strongest soil, and wide cells, where it begins at the surface."""
    sound = sounding("0, 20, 100; 9, 20, 100", speed_ratio=0.22, cells_per_radius=1.4)
    assert sound.likely_failure == ""
    fast = dataclasses.replace(sound, speed_ratio=0.23)
    assert fast.likely_failure.startswith("of the strongest soil rho V^2 is 5.29 su")
    wide = dataclasses.replace(sound, from_depth=0.0)
    assert "try cells_per_radius = 1.5 or more" in wide.likely_failure
    assert dataclasses.replace(wide, cells_per_radius=1.5).likely_failure == ""


def test_a_cone_too_fast_for_any_result_is_refused() -> None:
    """Half the speed of shear waves is rho V^2 = Ir su / 4; the remedy is a speed that is sane."""
    coarse, fine = (
        ConePenetration(rigidity_index=199.0, speed_ratio=0.5, cells_per_radius=cells)
        for cells in (1.7, 1.9)
    )
    assert "rho V^2 is 49.8 su" in coarse.likely_failure
    assert fine.likely_failure == ""
    with pytest.raises(ParameterError, match=r"speed_ratio = 0\.5 is not allowed") as refusal:
        ConePenetration(rigidity_index=201.0, speed_ratio=0.5)
    assert refusal.value.key == "speed_ratio"
    assert "above 50 su soil is thrown off; try speed_ratio = 0.16 or less" in str(refusal.value)
