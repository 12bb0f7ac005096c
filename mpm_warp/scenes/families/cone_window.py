"""The window of a cone penetration test: how fast the penetrometer goes, and what it has room for.

Until the resistance is of interest the penetrometer hurries; at last it has the speed asked for.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from mpm_warp.materials.materials import LinearElastic
from mpm_warp.penetration import SAMPLE_SPACING, STEADY_SAMPLES
from mpm_warp.parts.window import Approach, Window

if TYPE_CHECKING:
    from mpm_warp.scenes.cone_penetration import ConePenetration

RAMP = 1.0
"""Penetration in which the speed rises from rest, in cone radii."""
SLOWING = 2.0
"""Penetration in which the speed falls to the final one, in cone radii."""
FORGETTING = 1.5
"""Penetration at the final speed in which the soil forgets the approach, in cone radii."""
STEADY_PENETRATION = FORGETTING + 2.0 * STEADY_SAMPLES * SAMPLE_SPACING
"""Penetration at the final speed, at least, in cone radii: that, and two means to compare."""
FROM_REST = 2.0
"""Penetration without an approach before which no resistance counts as steady, in cone radii."""
SPARE_FRACTION, SPARE_FRACTION_OF_FRICTION = 0.15, 0.4
"""Places for material points beside those that fill the grid, over their number: the cells along a
rough shaft come to hold the many small ones from near the axis, with friction more of them."""
LARGEST_INERTIA = 7.0
"""What rho V^2 / su may be on the way by default."""


def cone_window(test: ConePenetration, material: LinearElastic) -> Window:
    """The window of a test.

    Args:
        test: the test.
        material: of its soil, whose shear wave its speed is measured by.
    """
    speed = test.speed_ratio * material.shear_wave_speed
    rubs = test.friction_coefficient > 0.0
    return Window(
        speed=speed,
        ramp_travel=RAMP * test.cone_radius,
        approach=_approach(test, speed),
        spare_fraction=SPARE_FRACTION_OF_FRICTION if rubs else SPARE_FRACTION,
    )


def _approach(test: ConePenetration, speed: float) -> Approach | None:
    ratio = test.approach_speed_ratio
    if ratio is None:
        ratio = min(4 * test.speed_ratio, math.sqrt(LARGEST_INERTIA / test.rigidity_index))
    travel = min(test.approach, test.penetration - STEADY_PENETRATION)
    if travel <= RAMP + SLOWING or ratio <= test.speed_ratio:
        return None
    return Approach(
        speed=speed * ratio / test.speed_ratio,
        travel=travel * test.cone_radius,
        slowing_travel=SLOWING * test.cone_radius,
    )


def unsteady_penetration(test: ConePenetration, window: Window | None) -> float:
    """Penetration before which no resistance counts as steady, over the radius."""
    if window is None or window.approach is None:
        return FROM_REST
    return window.approach.travel / test.cone_radius + FORGETTING
