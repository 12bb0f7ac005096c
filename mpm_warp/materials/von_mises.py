"""The yield criterion of von Mises: sqrt(J2) = su."""

import functools
import math
from typing import Any

import warp as wp

from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic
from mpm_warp.precision import Precision


class VonMises(PerfectlyPlastic):
    """Yields where sqrt(J2) = su: matched to Tresca in pure shear, not in triaxial compression."""

    @classmethod
    def measure(cls, precision: Precision) -> Any:
        """sqrt(J2)."""
        return _make_root_of_j2(precision)

    @classmethod
    def within(cls, precision: Precision) -> Any:
        """Where J2 is at most su^2."""
        return _make_within(precision)

    @classmethod
    def nearest(cls, precision: Precision) -> Any:
        """The deviator made shorter: the radial return to the cylinder."""
        return _make_nearest(precision)

    def undrained_strength(self, test: str) -> float:
        """In plane strain and simple shear su, in triaxial modes sqrt(3)/2 su."""
        return math.sqrt(0.75) * self.strength if test.startswith("triaxial") else self.strength


@functools.cache
def make_j2(precision: Precision) -> Any:
    """The function stress -> J2 = s:s / 2, s the deviator [Pa2]."""
    real, vec4 = precision.real, precision.vec4

    @wp.func
    def j2(stress: vec4) -> real:
        mean = (stress[0] + stress[1] + stress[3]) / real(3.0)
        rr, zz, tt, rz = stress[0] - mean, stress[1] - mean, stress[3] - mean, stress[2]
        return real(0.5) * (rr * rr + zz * zz + tt * tt) + rz * rz

    return j2


@functools.cache
def _make_root_of_j2(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4
    j2 = make_j2(precision)

    @wp.func
    def root_of_j2(stress: vec4) -> real:
        return wp.sqrt(j2(stress))

    return root_of_j2


@functools.cache
def _make_within(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4
    j2 = make_j2(precision)

    @wp.func
    def within_cylinder(stress: vec4, strength: real) -> bool:
        return j2(stress) <= strength * strength

    return within_cylinder


@functools.cache
def _make_nearest(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4
    j2 = make_j2(precision)

    @wp.func
    def nearest_of_cylinder(trial: vec4, strength: real) -> vec4:
        scale = strength / wp.sqrt(j2(trial))
        mean = (trial[0] + trial[1] + trial[3]) / real(3.0)
        rr, zz, tt = trial[0] - mean, trial[1] - mean, trial[3] - mean
        return vec4(mean + scale * rr, mean + scale * zz, scale * trial[2], mean + scale * tt)

    return nearest_of_cylinder
