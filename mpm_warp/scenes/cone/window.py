"""The window of a cone penetration test: how fast the penetrometer goes, and what it has room for.

Until the resistance is of interest the penetrometer goes faster; at last it has the speed asked
for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from mpm_warp.parts.window import Approach, Window
from mpm_warp.scenes.catalogue import CatalogueScene
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING, STEADY_SAMPLES

RAMP = 1.0
"""Penetration in which the speed rises from rest, in cone radii."""
SLOWING = 2.0
"""Penetration in which the speed falls to the final one, in cone radii."""
FORGETTING, FORGETTING_OF_STIFFNESS, LONGEST_FORGETTING = 1.5, 150.0, 10.0
"""Penetration at the final speed in which the soil forgets the approach, in cone radii: at least
the first, the second over the rigidity index, and at most the third."""
PUSHED = 0.5
"""Penetration after the approach in which the soil that was slowed down still pushes, in cone
radii."""
MEANS = 2.0 * STEADY_SAMPLES * SAMPLE_SPACING
"""Penetration over which two means of the resistance are compared, in cone radii."""
FROM_REST = 2.0
"""Penetration without an approach before which no resistance counts as steady, in cone radii."""
SPARE_FRACTION, SPARE_FRACTION_OF_FRICTION = 0.15, 0.4
"""Slots for material points beside those that fill the grid, over their number: the cells along a
rough shaft come to hold the many small ones from near the axis, with friction more of them."""
ALL_PASSED = 1.5
"""Penetration beyond the extent of the window above the shoulder at which all soil beside the shaft
has been passed by the cone, in cone radii."""
INERTIA_OF_APPROACH, SPEED_RATIO_OF_APPROACH = 7.0, 0.25
"""What rho V^2 / su and V over the speed of shear waves may be during the approach by default."""


def approach_speed_ratio(rigidity_index: float) -> float:
    """Speed of the approach by default, over that of shear waves."""
    return min(SPEED_RATIO_OF_APPROACH, math.sqrt(INERTIA_OF_APPROACH / rigidity_index))


def forgetting(rigidity_index: float) -> float:
    """Penetration at the final speed in which the soil forgets the approach, in cone radii."""
    return min(LONGEST_FORGETTING, max(FORGETTING, FORGETTING_OF_STIFFNESS / rigidity_index))


def steady_penetration(rigidity_index: float) -> float:
    """Penetration at the final speed before a resistance counts as steady, in cone radii."""
    return forgetting(rigidity_index) + MEANS


def smallness(test: CatalogueScene, default_extents: Mapping[str, float]) -> float:
    """Greatest ratio of an extent of the window by default to that of a test, by its parameters."""
    ratios: list[float] = [it / getattr(test, name) for name, it in default_extents.items()]
    return max(ratios)


def window_of_test(
    *,
    radius: float,
    shear_wave_speed: float,
    speed_ratio: float,
    approach_speed_ratio: float,
    approach: float,
    penetration: float,
    steady_penetration: float,
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
        steady_penetration: the last of it, at the final speed at the least, over the radius.
        rubs: whether there is friction between penetrometer and soil.
    """
    speed = speed_ratio * shear_wave_speed
    travel = min(approach, penetration - steady_penetration)
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


def unsteady_penetration(window: Window, radius: float, rigidity_index: float) -> float:
    """Penetration before which no mean of the resistance is taken, over the radius.

    Args:
        window: of the test.
        radius: of the penetrometer [m].
        rigidity_index: G/su.
    """
    if window.approach is None:
        return FROM_REST
    return window.approach.travel / radius + forgetting(rigidity_index)


def slowing_penetration(window: Window, radius: float) -> tuple[float, float] | None:
    """Penetrations between which the soil is slowed down, over the radius; or none.

    Its inertia then takes from the resistance up to 1.3 su.

    Args:
        window: of the test.
        radius: of the penetrometer [m].
    """
    approach = window.approach
    if approach is None:
        return None
    return (approach.travel - approach.slowing_travel) / radius, approach.travel / radius + PUSHED
