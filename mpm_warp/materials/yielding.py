"""Return of a trial stress to the yield surface: one function for each yield criterion.

Stresses are (rr, zz, rz, tt), tension positive; in axisymmetry the hoop stress tt is principal.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision
from mpm_warp.materials.materials import LinearElastic, Tresca, VonMises


def make_yielding(material: LinearElastic, precision: Precision) -> Any:
    """The function (trial stress, strength) -> stress; None for a material that never yields."""
    makers = {LinearElastic: lambda _: None, Tresca: _make_tresca, VonMises: _make_von_mises}
    return makers[type(material)](precision)


@functools.cache
def _make_von_mises(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4

    @wp.func
    def return_to_von_mises(stress: vec4, strength: real) -> vec4:
        mean = (stress[0] + stress[1] + stress[3]) / real(3.0)
        rr, zz, tt, rz = stress[0] - mean, stress[1] - mean, stress[3] - mean, stress[2]
        j2 = real(0.5) * (rr * rr + zz * zz + tt * tt) + rz * rz
        if j2 <= strength * strength:
            return stress
        scale = strength / wp.sqrt(j2)
        return vec4(mean + scale * rr, mean + scale * zz, scale * rz, mean + scale * tt)

    return return_to_von_mises


@functools.cache
def _make_tresca(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4

    @wp.func
    def return_to_tresca(stress: vec4, strength: real) -> vec4:
        # Principal stresses: two in the plane, centre +- radius, and the hoop stress.
        centre = real(0.5) * (stress[0] + stress[1])
        half_difference = real(0.5) * (stress[0] - stress[1])
        square = half_difference * half_difference + stress[2] * stress[2]
        hoop = stress[3]
        # Elastic where neither 2 radius nor radius + |centre - hoop| exceeds 2 su: without a root.
        room = wp.min(strength, real(2.0) * strength - wp.abs(centre - hoop))
        if room >= real(0.0) and square <= room * room:
            return stress
        radius = wp.sqrt(square)
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
        return vec4(
            new_centre + scale * half_difference,
            new_centre - scale * half_difference,
            scale * stress[2],
            new_hoop,
        )

    return return_to_tresca
