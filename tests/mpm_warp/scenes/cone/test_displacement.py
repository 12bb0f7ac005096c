"""The displacement of soil that the cone has passed, against incompressible expansion."""

import numpy as np
import pytest

from mpm_warp import ConePenetration, Snapshots

pytestmark = pytest.mark.slow

WITHIN = 0.05
"""Error that is allowed of a displacement behind the cone."""
BEHIND = 1.0
"""Depth below the top of the window in which soil is taken, over the cone's radius."""


def test_soil_has_made_room_for_the_shaft_like_soil_around_a_cylinder() -> None:
    """Near the shaft, far behind the tip; no soil moves further than around an endless cylinder."""
    test = ConePenetration(accuracy="quick", penetration=22, steady_tolerance=0)
    snapshots = Snapshots([22])
    test.run(snapshots=snapshots)
    fields = snapshots.dataset().isel(penetration=-1)
    r, z, moved = (
        fields[name].values / test.cone_radius for name in ("point_r", "point_z", "displacement_r")
    )
    high = z > np.nanmax(z) - BEHIND
    beside = high & (r > 1.6) & (r < 2.4)
    of_cylinder = r - np.sqrt(np.maximum(r * r - 1.0, 0.0))
    assert beside.sum() >= 5
    assert abs(np.mean(moved[beside] / of_cylinder[beside]) - 1.0) < WITHIN
    assert np.all(moved[high & (r > 1.6)] < of_cylinder[high & (r > 1.6)])
