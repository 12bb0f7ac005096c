"""Extreme cases, shortened, against their exact answers: whole in `harness verify --extreme`."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mpm_warp.scenes import stretched_bar
from mpm_warp.scenes.elastic_column_wave import ElasticColumnWave
from mpm_warp.scenes.flying_block import TIME_STEP_FRACTION, FlyingBlock
from mpm_warp.scenes.sliding_block import SlidingBlock
from mpm_warp.scenes.stretched_bar import StretchedBar
from mpm_warp.scenes.struck_bar import StruckBar
from mpm_warp.scenes.struck_column import StruckColumn
from mpm_warp.shock import TRAVEL, Shock


def test_free_flight_keeps_momentum_spin_and_shape() -> None:
    steps, rim_speed = 10_000, 0.02
    block = FlyingBlock(step_count=steps, rim_speed=rim_speed)
    result = block.run()
    rounding = steps * np.finfo(float).eps
    assert float(result.momentum_error) <= rounding
    assert float(result.spin_error) <= rounding
    # Of a finite turn second order is kept, the third is left over; and inertia strains the block
    # by rho (w l)^2 / E at most.
    turn = rim_speed * TIME_STEP_FRACTION / block.cells_per_side
    assert float(result.error) <= steps * turn**3 + rim_speed**2


@pytest.mark.parametrize("stretch", [1.5, 4.0])
def test_bar_that_is_drawn_out(stretch: float) -> None:
    bar = StretchedBar(stretch=stretch)
    result = bar.run()
    # Inertia takes rho L^2 / 8 times the growth of the stretch rate from the force in the middle.
    assert float(result.error) <= (math.log(stretch) / stretched_bar.SLOWNESS) ** 2 / 8 + spread(
        bar
    )
    assert float(result.stress_error) <= spread(bar)


def spread(bar: StretchedBar) -> float:
    """A quadratic spline spreads by half a cell: second order in that over the bar's length."""
    return (0.5 / bar.cell_count) ** 2


@pytest.mark.parametrize("struck", [StruckBar, StruckColumn])
@pytest.mark.parametrize("speed_ratio", [0.1, 0.5, 0.9])
def test_shock(struck: type[StruckBar] | type[StruckColumn], speed_ratio: float) -> None:
    """It is as sharp as a cell, over the half of its way in which its speed is taken."""
    cells = 40
    result = struck(speed_ratio=speed_ratio, cell_count=cells).run()
    assert float(result.error) <= 1.0 / (0.5 * TRAVEL * cells)


def test_shock_relations_hold_and_become_those_of_waves() -> None:
    fast, slow = (Shock(modulus=8.0, density=2.0, speed=ratio * 2.0) for ratio in (0.5, 1e-3))
    stretch = 1.0 - fast.speed / fast.front_speed
    assert -8.0 * math.log(stretch) == pytest.approx(2.0 * fast.front_speed * fast.speed)
    assert fast.stress == pytest.approx(8.0 * math.log(stretch))
    assert slow.front_speed == pytest.approx(2.0, rel=1e-3)
    assert slow.stress == pytest.approx(-2.0 * 2.0 * slow.speed, rel=1e-3)


def test_energy_of_many_load_cycles() -> None:
    """Within a period energy swings by omega dt; its mean over one may lack a step of that."""
    cycles = 100
    result = ElasticColumnWave(cell_count=10, period_count=cycles).run()
    steps = float(result.step_count) / cycles
    assert float(result.energy_drift) <= 2.0 * math.pi / steps**2
    # The first and the last period are sampled, of the others some.
    assert float(result.phase[0]) == 0.0
    assert float(result.phase[-1]) == pytest.approx(cycles, rel=1e-3)
    assert len(result.phase) < 11 * steps


@pytest.mark.parametrize("stiffness_ratio", [1e-3, 1e3])
def test_sliding_on_a_base_of_another_stiffness(stiffness_ratio: float) -> None:
    block = SlidingBlock(
        stiffness_ratio=stiffness_ratio,
        cells_per_length=6,
        height_ratio=0.5,
        drive=2e4,
        travel=0.01,
    )
    assert float(block.run().error) <= 0.01


@pytest.mark.parametrize("grid_angle", [0.0, 20.0])
def test_block_at_rest_does_not_creep(grid_angle: float) -> None:
    """A share of the 1e-4 of its length that it may creep in a million steps."""
    block = SlidingBlock(
        friction=0.8, cells_per_length=6, height_ratio=0.5, grid_angle=grid_angle, rest_time=50.0
    )
    result = block.run()
    assert float(result.error) <= 1e-4 * float(result.step_count) / 1e6
