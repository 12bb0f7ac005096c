"""Perfect plasticity with the yield criterion of von Mises."""

import functools
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.materials.perfectly_plastic import YieldCriterion
from mpm_warp.precision import Precision


@dataclass(frozen=True, kw_only=True)
class VonMises(YieldCriterion):
    """Yields where sqrt(J2) = su: matched to Tresca in pure shear, not in triaxial compression."""

    def update(self, precision: Precision) -> Any:
        """Radial return of the deviator to the cylinder."""
        return _make_update(precision)

    def yield_function(self, precision: Precision) -> Any:
        """(sqrt(J2), su)."""
        return _make_yield_function(precision)

    def within(self, precision: Precision) -> Any:
        """Where J2 is at most su^2."""
        return _make_within(precision)


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
def _make_yield_function(precision: Precision) -> Any:
    vec1, vec2, vec4 = precision.vector(1), precision.vec2, precision.vec4
    j2 = make_j2(precision)

    @wp.func
    def root_of_j2(stress: vec4, properties: vec1, state: vec1) -> vec2:
        return vec2(wp.sqrt(j2(stress)), properties[0])

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
def _make_update(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4
    vec1 = precision.vector(1)
    j2, within = make_j2(precision), _make_within(precision)

    @wp.func
    def return_to_von_mises(
        trial: vec4, strain: vec4, time_step: real, properties: vec1, state: vec1
    ):
        strength = properties[0]
        if within(trial, strength):
            return trial, state
        scale = strength / wp.sqrt(j2(trial))
        mean = (trial[0] + trial[1] + trial[3]) / real(3.0)
        rr, zz, tt = trial[0] - mean, trial[1] - mean, trial[3] - mean
        returned = vec4(mean + scale * rr, mean + scale * zz, scale * trial[2], mean + scale * tt)
        return returned, state

    return return_to_von_mises
