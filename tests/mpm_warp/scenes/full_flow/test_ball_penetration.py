"""Steady flow round a ball against its limit load."""

import pytest

from mpm_warp.scenes.full_flow.limit_load import FullFlowSphere
from mpm_warp.scenes.full_flow.penetration import BallPenetration

pytestmark = pytest.mark.slow

CELLS = 4


def test_steady_flow_round_a_smooth_ball_has_its_limit_load() -> None:
    limit = float(FullFlowSphere(cells_per_radius=CELLS).run().bearing_capacity)
    ball = BallPenetration(
        cells_per_radius=CELLS, shaft_radius_ratio=0.0, penetration=5.0, particles_per_cell=4
    )
    factor = float(ball.run().resistance_factor)
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    assert factor == pytest.approx(limit, rel=1 / (CELLS * limit))


def test_a_shaft_bears_the_soil_from_the_area_that_it_covers() -> None:
    """It is a tenth of the ball's; soil that the shaft pushes aside gives some of it back."""
    ball = BallPenetration(cells_per_radius=3, penetration=5.0, adhesion_factor=1.0)
    result = ball.run()
    assert abs(float(result.energy_error)) < 0.02
    limit = float(FullFlowSphere(cells_per_radius=3, adhesion_factor=1.0).run().bearing_capacity)
    covered = ball.shaft_radius_ratio**2
    assert (1.0 - covered) * limit < float(result.resistance_factor) < limit
