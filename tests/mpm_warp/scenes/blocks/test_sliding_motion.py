"""The exact motion of the rigid block, against the equation of motion that it solves."""

import numpy as np
import pytest

from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.blocks.block_on_base import SlidingMotion

TRAVEL = 0.7


def integral(values: Floats, step: float) -> Floats:
    sums: Floats = np.cumsum(0.5 * step * (values[1:] + values[:-1]))
    return np.concatenate([[0.0], sums])


@pytest.mark.parametrize("rise_time", [0.3, None])
def test_motion_solves_its_equation(rise_time: float | None) -> None:
    motion = SlidingMotion(mass=3.0, driving_force=20.0, resistance=8.0, rise_time=rise_time)
    since = np.linspace(0.0, motion.duration(TRAVEL), 20_001)
    velocity, displacement, shear = motion.at(since)
    rise = since[-1] if rise_time is None else rise_time
    force = 20.0 * np.minimum(since / rise, 1.0)
    step = since[1]
    # Trapezoids: off by a step of the force where it has a kink.
    gained = integral(force - shear, step)
    np.testing.assert_allclose(3.0 * velocity, gained, atol=20.0 * step)
    np.testing.assert_allclose(displacement, integral(velocity, step), atol=TRAVEL * step)
    if rise_time is None:
        assert displacement[-1] == pytest.approx(TRAVEL)
    else:
        at_rise = np.interp(rise, since, displacement)
        drift = np.interp(rise, since, velocity) * (since[-1] - rise)
        assert displacement[-1] - at_rise - drift == pytest.approx(TRAVEL, rel=1e-3)


def test_block_below_its_resistance_does_not_move() -> None:
    motion = SlidingMotion(mass=3.0, driving_force=5.0, resistance=8.0, rise_time=1.0)
    velocity, displacement, shear = motion.at(np.array([0.0, 0.5, 1.0, 4.0]))
    assert not motion.slides
    np.testing.assert_array_equal([velocity, displacement], 0.0)
    np.testing.assert_allclose(shear, [0.0, 2.5, 5.0, 5.0])
