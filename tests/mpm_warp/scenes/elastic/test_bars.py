"""Bars: struck against the exact shock, and drawn out, less than in `harness verify --extreme`."""

import math

import numpy as np
import pytest

from mpm_warp.bodies.body import critical_time_step
from mpm_warp.plan.plan import SLACK
from mpm_warp.scenes.elastic import stretched_bar
from mpm_warp.scenes.elastic.impact import SHOCK_TRAVEL, Impact, StruckBar, StruckColumn
from mpm_warp.scenes.elastic.stretched_bar import StretchedBar

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("struck", [StruckBar, StruckColumn])
@pytest.mark.parametrize("speed_ratio", [0.1, 0.5, 0.9])
def test_shock(struck: type[Impact], speed_ratio: float) -> None:
    """It is as sharp as a cell, over the half of its way in which its speed is taken."""
    cells = 40
    result = struck(speed_ratio=speed_ratio, cell_count=cells).run()
    assert float(result.error) <= 1.0 / (0.5 * SHOCK_TRAVEL * cells)


def test_shock_relations_hold_and_become_those_of_waves() -> None:
    fast, slow = (StruckBar(speed_ratio=ratio) for ratio in (0.5, 1e-3))
    stretch = 1.0 - fast.speed / fast.front_speed
    momentum = fast.density * fast.front_speed * fast.speed
    assert -fast.modulus * math.log(stretch) == pytest.approx(momentum)
    assert fast.shock_stress == pytest.approx(fast.modulus * math.log(stretch))
    assert slow.front_speed == pytest.approx(slow.wave_speed, rel=1e-3)
    assert slow.shock_stress == pytest.approx(
        -slow.density * slow.wave_speed * slow.speed, rel=1e-3
    )


@pytest.mark.parametrize("stretch", [1.5, 4.0])
def test_bar_that_is_drawn_out(stretch: float) -> None:
    bar = StretchedBar(stretch=stretch)
    result = bar.run()
    # Inertia takes rho L^2 / 8 times the growth of the stretch rate from the force in the middle.
    inertia = (math.log(stretch) / stretched_bar.SLOWNESS) ** 2 / 8
    # A quadratic spline spreads by half a cell: second order in that over the bar's length.
    spread = (0.5 / bar.cell_count) ** 2
    assert float(result.error) <= inertia + spread
    assert float(result.stress_error) <= spread


def test_a_bar_that_is_drawn_out_takes_shorter_steps_and_no_more_than_it_needs() -> None:
    """Its viscous stress bounds them, in proportion to its density: to a third in the end."""
    bar = StretchedBar(stretch=3.0, cell_count=2)
    first = bar.plan().time_step
    result = bar.run()
    last = float(result.time_step)
    critical = critical_time_step(
        bar.cell_size, bar.build().bodies[0].material, bar.retardation_time, thinning=3.0
    )
    # As wanted, or less because the critical one falls by a tenth between two looks.
    assert 0.8 / 1.1 / SLACK < last / critical < 0.8 * SLACK
    assert bar.duration / first < float(result.step_count) < bar.duration / last
    assert float(result.error) < 0.01
    np.testing.assert_allclose(
        result.stretch_exact[-1], 3.0, rtol=2.0 * first / bar.duration * np.log(3.0) * 3.0
    )
