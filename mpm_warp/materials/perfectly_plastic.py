"""Soil with an undrained shear strength: elastic up to it, then perfectly plastic and isochoric.

Symbols: f measure of a stress by the yield criterion [Pa], su strength, tau elastic trial stress.

    sigma = tau                                 where f(tau) <= su
    sigma = nearest stress with f = su          elsewhere, in the metric of elastic energy
"""

import functools
import math
from dataclasses import dataclass
from typing import Any, ClassVar

import warp as wp

from mpm_warp.arguments import POSITIVE, checked
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import real, vec1, vec2, vec3, vec4
from mpm_warp.materials.elasticity import Isotropic, elastic_increment

STRENGTH = 2
"""Place of su among the properties, behind the moduli."""


@dataclass(frozen=True, kw_only=True)
class UndrainedClay(Isotropic):
    """The base of all clays whose volume stays elastic: it has a strength.

    Attributes:
        strength: undrained shear strength in pure shear su [Pa], > 0.
    """

    strength: float = checked(POSITIVE, unit="Pa")

    @property
    def properties(self) -> tuple[float, ...]:
        """(G, K, su) [Pa]."""
        return (*super().properties, self.strength)

    def properties_at(self, place: Floats) -> Floats:
        """See `Material`; the strength varies too."""
        own = super().properties_at(place)
        own[..., STRENGTH] *= self.strength_ratio_at(place)
        return own

    @property
    def limit_pressure(self) -> float:
        """Of a spherical cavity: 4/3 su (1 + ln(G / su)) [Pa] (Hill 1950)."""
        return limit_pressure(self.shear_modulus, self.strength)


def limit_pressure(shear_modulus: float, strength: float) -> float:
    """Of a spherical cavity in perfectly plastic clay [Pa] (Hill 1950).

    Args:
        shear_modulus: G [Pa].
        strength: su [Pa].
    """
    return 4.0 / 3.0 * strength * (1.0 + math.log(shear_modulus / strength))


class PerfectlyPlastic(UndrainedClay):
    """Perfect plasticity with a yield criterion, which another law may take at any strength.

    A criterion is three functions on the device.

    Attributes:
        measure: stress -> f, its measure by the criterion [Pa].
        within: (stress, strength) -> whether the stress is within the yield surface. It is asked of
            every point in every step, and takes no root.
        nearest: (trial stress outside, strength) -> nearest stress of the yield surface.
    """

    measure: ClassVar[Any]
    within: ClassVar[Any]
    nearest: ClassVar[Any]

    def update(self) -> Any:
        """Return to the yield surface from outside."""
        return _make_update(self.within, self.nearest)

    def yield_function(self) -> Any:
        """(f, su)."""
        return _make_yield_function(self.measure)


@functools.cache
def _make_yield_function(measure: Any) -> Any:
    @wp.func
    def measure_and_strength(stress: vec4, properties: vec3, state: vec1) -> vec2:
        return vec2(measure(stress), properties[wp.static(STRENGTH)])

    return measure_and_strength


@functools.cache
def _make_update(within: Any, nearest: Any) -> Any:
    @wp.func
    def elastic_then_return(
        stress: vec4, strain: vec4, time_step: real, properties: vec3, state: vec1
    ):
        trial = stress + elastic_increment(strain, properties[0], properties[1])
        strength = properties[wp.static(STRENGTH)]
        if within(trial, strength):
            return trial, state
        return nearest(trial, strength), state

    return elastic_then_return
