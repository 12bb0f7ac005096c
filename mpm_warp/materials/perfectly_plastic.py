"""Soil with an undrained shear strength: elastic up to it, then perfectly plastic and isochoric.

Symbols: f measure of a stress by the yield criterion [Pa], su strength, tau elastic trial stress.

    sigma = tau                                 where f(tau) <= su
    sigma = nearest stress with f = su          elsewhere, in the metric of elastic energy
"""

import functools
import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.arguments import POSITIVE, checked
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.elasticity import Isotropic, make_elastic_increment
from mpm_warp.precision import Precision

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
    """Perfect plasticity with a yield criterion, which another law may take at any strength."""

    @classmethod
    @abstractmethod
    def measure(cls, precision: Precision) -> Any:
        """The function stress -> f, its measure by the criterion [Pa]."""

    @classmethod
    @abstractmethod
    def within(cls, precision: Precision) -> Any:
        """The function (stress, strength) -> whether the stress is within the yield surface.

        It is asked of every point in every step, and takes no root.
        """

    @classmethod
    @abstractmethod
    def nearest(cls, precision: Precision) -> Any:
        """The function (trial stress outside, strength) -> nearest stress of the yield surface."""

    def update(self, precision: Precision) -> Any:
        """Return to the yield surface from outside."""
        return _make_update(self.within(precision), self.nearest(precision), precision)

    def yield_function(self, precision: Precision) -> Any:
        """(f, su)."""
        return _make_yield_function(self.measure(precision), precision)


@functools.cache
def _make_yield_function(measure: Any, precision: Precision) -> Any:
    vec1, vec2, vec3, vec4 = (precision.vector(length) for length in (1, 2, 3, 4))

    @wp.func
    def measure_and_strength(stress: vec4, properties: vec3, state: vec1) -> vec2:
        return vec2(measure(stress), properties[wp.static(STRENGTH)])

    return measure_and_strength


@functools.cache
def _make_update(within: Any, nearest: Any, precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4
    vec1, vec3 = precision.vector(1), precision.vec3
    elastic_increment = make_elastic_increment(precision)

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
