"""The motion of a window: ramp, approach and final speed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mpm_warp.parts.window import Approach, Window

HURRIED = Window(
    speed=1.0,
    ramp_travel=1.0,
    spare_fraction=0.1,
    approach=Approach(speed=4.0, travel=8.0, slowing_travel=2.0),
)


def speed_at(window: Window, travel: float) -> float:
    """By travel: the square root of it in the ramp, linear in it where the speed falls."""
    fast = window.first_speed
    risen = fast * min(1.0, np.sqrt(travel / window.ramp_travel))
    if window.approach is None:
        return float(risen)
    left = (window.approach.travel - travel) / window.approach.slowing_travel
    return float(min(risen, window.speed + np.clip(left, 0, 1) * (fast - window.speed)))


@pytest.mark.parametrize("window", [HURRIED, dataclasses.replace(HURRIED, approach=None)])
@pytest.mark.parametrize("travel", [0.5, 1.0, 3.0, 7.0, 8.0, 12.0])
def test_time_to_a_travel_is_the_integral_of_one_over_the_speed(
    window: Window, travel: float
) -> None:
    # Over the root of the travel, in which the speed of the ramp is linear.
    roots = (np.arange(10_000) + 0.5) / 10_000
    expected = np.mean([2 * root * travel / speed_at(window, travel * root**2) for root in roots])
    assert window.time_to(travel) == pytest.approx(expected, rel=1e-3)


def test_no_speed_is_above_the_highest_beyond_a_travel() -> None:
    for travel in np.linspace(0.01, 12, 50):
        ahead = [speed_at(HURRIED, place) for place in np.linspace(travel, 12, 100)]
        assert max(ahead) <= HURRIED.highest_speed_from(travel)
