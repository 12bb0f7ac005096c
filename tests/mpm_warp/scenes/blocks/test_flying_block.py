"""Free flight, shortened; the whole one is in `harness verify --extreme`."""

import numpy as np
import pytest

from mpm_warp.scenes.blocks.flying_block import TIME_STEP_FRACTION, FlyingBlock

pytestmark = pytest.mark.slow


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
