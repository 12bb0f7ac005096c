"""The yield criterion of Tresca, the usual one of undrained clay: (sigma_1 - sigma_3) / 2 = su.

The hoop stress is a principal stress. The other two are centre +- radius of Mohr's circle.
"""

from typing import Any

import warp as wp

from mpm_warp.kernel_types import half, real, two, vec4, zero
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic


@wp.func
def greatest_shear(stress: vec4, shape: Any) -> real:
    """(sigma_1 - sigma_3) / 2."""
    centre = half * (stress[0] + stress[1])
    half_difference = half * (stress[0] - stress[1])
    radius = wp.sqrt(half_difference * half_difference + stress[2] * stress[2])
    highest = wp.max(centre + radius, stress[3])
    lowest = wp.min(centre - radius, stress[3])
    return half * (highest - lowest)


@wp.func
def within_hexagon(stress: vec4, strength: real, shape: Any) -> bool:
    """Whether neither 2 radius nor radius + |centre - hoop| of Mohr's circle exceeds 2 su."""
    centre = half * (stress[0] + stress[1])
    half_difference = half * (stress[0] - stress[1])
    square = half_difference * half_difference + stress[2] * stress[2]
    room = wp.min(strength, two * strength - wp.abs(centre - stress[3]))
    return room >= zero and square <= room * room


@wp.func
def nearest_of_hexagon(trial: vec4, strength: real, shape: Any) -> vec4:
    """The nearest stress on the hexagon."""
    centre = half * (trial[0] + trial[1])
    half_difference = half * (trial[0] - trial[1])
    radius = wp.sqrt(half_difference * half_difference + trial[2] * trial[2])
    hoop = trial[3]
    highest = wp.max(centre + radius, hoop)
    lowest = wp.min(centre - radius, hoop)

    # The nearest stress is on a side, where the middle stress does not change ...
    trace = two * centre + hoop
    middle = trace - highest - lowest
    mean_of_extremes = half * (highest + lowest)
    new_highest = mean_of_extremes + strength
    new_lowest = mean_of_extremes - strength
    new_middle = middle
    # ... or at a corner, where the middle stress would not lie between the other two.
    third = strength / real(3.0)
    mean = trace / real(3.0)
    if middle > new_highest:
        new_highest = mean + two * third
        new_middle = new_highest
        new_lowest = mean - real(4.0) * third
    elif middle < new_lowest:
        new_lowest = mean - two * third
        new_middle = new_lowest
        new_highest = mean + real(4.0) * third

    # Principal directions do not change, so the hoop stress keeps its rank among the three.
    major, minor, new_hoop = new_highest, new_lowest, new_middle
    if hoop >= centre + radius:
        major, minor, new_hoop = new_middle, new_lowest, new_highest
    elif hoop <= centre - radius:
        major, minor, new_hoop = new_highest, new_middle, new_lowest
    new_centre = half * (major + minor)
    scale = real(0.0)
    if radius > zero:
        scale = half * (major - minor) / radius
    return vec4(
        new_centre + scale * half_difference,
        new_centre - scale * half_difference,
        scale * trial[2],
        new_hoop,
    )


class Tresca(PerfectlyPlastic):
    """Yields where (sigma_1 - sigma_3) / 2 = su.

    Example:
        >>> clay = Tresca(strength=10e3, shear_modulus=1e6, poissons_ratio=0.49, density=1700.0)
        >>> clay.undrained_strength("triaxial_compression")  # [Pa]
        10000.0
    """

    measure = greatest_shear
    within = within_hexagon
    nearest = nearest_of_hexagon
    shear_measure = greatest_shear

    def undrained_strength(self, test: str) -> float:
        """See `Material`; su in every test."""
        return self.strength
