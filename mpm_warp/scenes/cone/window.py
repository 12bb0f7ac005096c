"""The window of a cone penetration test: how fast the penetrometer goes, and what it has room for.

Until the resistance is of interest the penetrometer goes faster; at last it has the speed asked
for.
"""

from __future__ import annotations

import math

from mpm_warp.parts.window import Approach, Window
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING, STEADY_SAMPLES

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
"""Slots for material points beside those that fill the grid, over their number: the cells along a
rough shaft come to hold the many small ones from near the axis, with friction more of them."""
LARGEST_INERTIA = 7.0
"""What rho V^2 / su may be during the approach by default."""


def approach_speed_ratio(speed_ratio: float, rigidity_index: float) -> float:
    """Speed of the approach by default, over that of shear waves.

    Args:
        speed_ratio: final speed over that of shear waves.
        rigidity_index: G/su.
    """
    return min(4 * speed_ratio, math.sqrt(LARGEST_INERTIA / rigidity_index))


def window_of_test(
    *,
    radius: float,
    shear_wave_speed: float,
    speed_ratio: float,
    approach_speed_ratio: float,
    approach: float,
    penetration: float,
    rubs: bool,
) -> Window:
    """The window of a test.

    Args:
        radius: radius of the penetrometer [m].
        shear_wave_speed: of the soil [m/s].
        speed_ratio: final speed over that of shear waves.
        approach_speed_ratio: speed of the approach over that of shear waves; where it is not above
            the final one there is no approach.
        approach: penetration of the approach, over the radius.
        penetration: greatest penetration, over the radius.
        rubs: whether there is friction between penetrometer and soil.
    """
    speed = speed_ratio * shear_wave_speed
    travel = min(approach, penetration - STEADY_PENETRATION)
    faster = None
    if travel > RAMP + SLOWING and approach_speed_ratio > speed_ratio:
        faster = Approach(
            speed=speed * approach_speed_ratio / speed_ratio,
            travel=travel * radius,
            slowing_travel=SLOWING * radius,
        )
    return Window(
        speed=speed,
        ramp_travel=RAMP * radius,
        approach=faster,
        spare_fraction=SPARE_FRACTION_OF_FRICTION if rubs else SPARE_FRACTION,
    )


def unsteady_penetration(window: Window, radius: float) -> float:
    """Penetration before which no resistance counts as steady, over the radius [m]."""
    if window.approach is None:
        return FROM_REST
    return window.approach.travel / radius + FORGETTING
