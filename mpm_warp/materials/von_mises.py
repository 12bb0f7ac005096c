"""The yield criterion of von Mises: sqrt(J2) = su."""

import math
from typing import Any

import warp as wp

from mpm_warp.kernel_types import half, real, vec4
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic


@wp.func
def j2(stress: vec4) -> real:
    """J2 = s:s / 2 of the deviator s [Pa2]."""
    mean = (stress[0] + stress[1] + stress[3]) / real(3.0)
    rr, zz, tt, rz = stress[0] - mean, stress[1] - mean, stress[3] - mean, stress[2]
    return half * (rr * rr + zz * zz + tt * tt) + rz * rz


@wp.func
def root_of_j2(stress: vec4, shape: Any) -> real:
    """sqrt(J2) [Pa]."""
    return wp.sqrt(j2(stress))


@wp.func
def within_cylinder(stress: vec4, strength: real, shape: Any) -> bool:
    """Whether J2 <= su^2."""
    return j2(stress) <= strength * strength


@wp.func
def nearest_of_cylinder(trial: vec4, strength: real, shape: Any) -> vec4:
    """The radial return to the cylinder."""
    scale = strength / wp.sqrt(j2(trial))
    mean = (trial[0] + trial[1] + trial[3]) / real(3.0)
    rr, zz, tt = trial[0] - mean, trial[1] - mean, trial[3] - mean
    return vec4(mean + scale * rr, mean + scale * zz, scale * trial[2], mean + scale * tt)


class VonMises(PerfectlyPlastic):
    """Yields where sqrt(J2) = su: matched to Tresca in pure shear, not in triaxial compression.

    Example:
        >>> clay = VonMises(strength=10e3, shear_modulus=1e6, poissons_ratio=0.49, density=1700.0)
        >>> round(clay.undrained_strength("triaxial_compression"))  # [Pa]
        8660
    """

    measure = root_of_j2
    within = within_cylinder
    nearest = nearest_of_cylinder
    shear_measure = root_of_j2

    def undrained_strength(self, test: str) -> float:
        """See `Material`; sqrt(3)/2 su in triaxial tests, su in all others."""
        return math.sqrt(0.75) * self.strength if test.startswith("triaxial") else self.strength
