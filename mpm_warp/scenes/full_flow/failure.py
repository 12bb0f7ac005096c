"""What a test of ball or T-bar is likely to fail by: soil is thrown off, or the clay is brittle."""

import math

from mpm_warp.scenes.clay import Clay
from mpm_warp.scenes.full_flow.degradation import strength_left

SANE_INERTIA, GREATEST_INERTIA = 1.0, 5.0
"""Inertia, rho V^2 over the remaining strength: most cases complete below the first, few above the
second."""
BRITTLE_STRENGTH, BRITTLE_STRAIN = 0.15, 5.0
"""Remoulded strength ratio and ductility of brittle clay. Where both are less, soil shears in
layers thinner than cells: 3 of 20 random balls complete, of the others 37 of 62."""


def inertia(clay: Clay, speed_ratio: float, last_cycle: float) -> float:
    """Inertia: rho V^2 over the strength in the last passage."""
    return clay.rigidity_index * speed_ratio**2 / strength_left(clay, last_cycle)


def thrown_off(clay: Clay, speed_ratio: float, last_cycle: float, limit: float) -> str:
    """Message for an inertia above `limit`: why the run fails, and the speed to take."""
    left = strength_left(clay, last_cycle)
    sane = math.sqrt(SANE_INERTIA * left / clay.rigidity_index)
    return (
        f"rho V^2 is {inertia(clay, speed_ratio, last_cycle):.3g} of the strength that is left in "
        f"the end, and above {limit:g} soil is thrown off; try speed_ratio = {sane:.2g} or less"
    )


def brittle(clay: Clay) -> str:
    """Why a push in brittle clay is likely to fail; "" where the clay is not brittle."""
    strain = math.inf if clay.ductility is None else clay.ductility
    if clay.remoulded_strength_ratio >= BRITTLE_STRENGTH or strain >= BRITTLE_STRAIN:
        return ""
    return (
        "the clay is brittle, and shears in layers thinner than the cells; no choice of the "
        f"method is known to help below a ductility of {BRITTLE_STRAIN:g} with a "
        f"remoulded_strength_ratio below {BRITTLE_STRENGTH:g}"
    )
