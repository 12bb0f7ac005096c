"""Perfect plasticity with the yield criterion of Tresca, as suits undrained clay."""

import functools
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.materials.perfectly_plastic import YieldCriterion
from mpm_warp.precision import Precision


@dataclass(frozen=True, kw_only=True)
class Tresca(YieldCriterion):
    """Yields where (sigma_1 - sigma_3) / 2 = su; in axisymmetry the hoop stress is principal."""

    def update(self, precision: Precision) -> Any:
        """Return to the nearest point of the hexagon, a side of it or a corner."""
        return _make_update(precision)

    def yield_function(self, precision: Precision) -> Any:
        """((sigma_1 - sigma_3) / 2, su)."""
        return _make_yield_function(precision)

    def within(self, precision: Precision) -> Any:
        """Where neither 2 radius nor radius + |centre - hoop| of Mohr's circle exceeds 2 su."""
        return _make_within(precision)


@functools.cache
def _make_yield_function(precision: Precision) -> Any:
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    vec1 = precision.vector(1)

    @wp.func
    def greatest_shear(stress: vec4, properties: vec1, state: vec1) -> vec2:
        centre = real(0.5) * (stress[0] + stress[1])
        half_difference = real(0.5) * (stress[0] - stress[1])
        radius = wp.sqrt(half_difference * half_difference + stress[2] * stress[2])
        highest = wp.max(centre + radius, stress[3])
        lowest = wp.min(centre - radius, stress[3])
        return vec2(real(0.5) * (highest - lowest), properties[0])

    return greatest_shear


@functools.cache
def _make_within(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4

    @wp.func
    def within_hexagon(stress: vec4, strength: real) -> bool:
        centre = real(0.5) * (stress[0] + stress[1])
        half_difference = real(0.5) * (stress[0] - stress[1])
        square = half_difference * half_difference + stress[2] * stress[2]
        room = wp.min(strength, real(2.0) * strength - wp.abs(centre - stress[3]))
        return room >= real(0.0) and square <= room * room

    return within_hexagon


@functools.cache
def _make_update(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4
    vec1 = precision.vector(1)
    within = _make_within(precision)

    @wp.func
    def return_to_tresca(trial: vec4, strain: vec4, time_step: real, properties: vec1, state: vec1):
        strength = properties[0]
        if within(trial, strength):
            return trial, state
        # Principal stresses: two in the plane, centre +- radius, and the hoop stress.
        centre = real(0.5) * (trial[0] + trial[1])
        half_difference = real(0.5) * (trial[0] - trial[1])
        radius = wp.sqrt(half_difference * half_difference + trial[2] * trial[2])
        hoop = trial[3]
        highest = wp.max(centre + radius, hoop)
        lowest = wp.min(centre - radius, hoop)

        # The nearest point of the hexagon: its side, where the middle stress does not change ...
        trace = real(2.0) * centre + hoop
        middle = trace - highest - lowest
        mean_of_extremes = real(0.5) * (highest + lowest)
        new_highest = mean_of_extremes + strength
        new_lowest = mean_of_extremes - strength
        new_middle = middle
        # ... or its corner, where the middle one would leave the range of the two.
        third = strength / real(3.0)
        mean = trace / real(3.0)
        if middle > new_highest:
            new_highest = mean + real(2.0) * third
            new_middle = new_highest
            new_lowest = mean - real(4.0) * third
        elif middle < new_lowest:
            new_lowest = mean - real(2.0) * third
            new_middle = new_lowest
            new_highest = mean + real(4.0) * third

        # Principal directions stay; which of the three is the hoop stress is known by its rank.
        major, minor, new_hoop = new_highest, new_lowest, new_middle
        if hoop >= centre + radius:
            major, minor, new_hoop = new_middle, new_lowest, new_highest
        elif hoop <= centre - radius:
            major, minor, new_hoop = new_highest, new_middle, new_lowest
        new_centre = real(0.5) * (major + minor)
        scale = real(0.0)
        if radius > real(0.0):
            scale = real(0.5) * (major - minor) / radius
        returned = vec4(
            new_centre + scale * half_difference,
            new_centre - scale * half_difference,
            scale * trial[2],
            new_hoop,
        )
        return returned, state

    return return_to_tresca
