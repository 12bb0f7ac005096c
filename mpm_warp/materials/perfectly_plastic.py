"""Soil with an undrained shear strength: elastic up to it, then perfectly plastic and isochoric.

Symbols: f measure of a stress by the yield criterion [Pa], su strength, tau elastic trial stress.

    sigma = tau                                 where f(tau) <= su
    sigma = nearest stress with f = su          elsewhere, in the metric of elastic energy
"""

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import warp as wp

from mpm_warp.arguments import POSITIVE, checked
from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import real, vec2, vec4, vector
from mpm_warp.materials.elasticity import Isotropic, elastic_increment

STRENGTH = 2
"""Place of su among the properties, behind the moduli."""
ROUNDING = 1e-9
"""Share of the strength by which a stress at rest may be outside the yield surface."""


@dataclass(frozen=True, kw_only=True)
class UndrainedClay(Isotropic):
    """The base of all clays whose volume stays elastic: it has a strength.

    Attributes:
        strength: undrained shear strength su [Pa], > 0: in pure shear, or in triaxial compression
            where it depends on direction.
    """

    strength: float = checked(POSITIVE, unit="Pa")

    @property
    def properties(self) -> tuple[float, ...]:
        """(G, K, su) [Pa]."""
        return (*super().properties, self.strength)

    def properties_at(self, place: Floats) -> Floats:
        """See `Material`; the strength varies too, and the shape where the ground says so."""
        own = super().properties_at(place)
        own[..., STRENGTH] *= self.ratio_at(place, "strength_ratio")
        if self.shape:
            own[..., -len(self.shape) :] = self.by_depth(place, lambda material: material.shape)
        return own

    @property
    def limit_pressure(self) -> float:
        """Of a spherical cavity: 4/3 su (1 + ln(G / su)) [Pa] (Hill 1950)."""
        return limit_pressure(self.shear_modulus, self.strength)


def limit_pressure(shear_modulus: float, strength: float) -> float:
    """Of a spherical cavity in perfectly plastic clay [Pa] (Hill 1950), by G and su [Pa]."""
    return 4.0 / 3.0 * strength * (1.0 + math.log(shear_modulus / strength))


class PerfectlyPlastic(UndrainedClay):
    """Perfect plasticity with a yield criterion, which another law may take at any strength.

    A criterion is some functions on the device. Their last argument `shape` is a vector of the
    numbers of shape and axis; of length 1 where there are none.
    """

    measure: ClassVar[Any]  # (stress, shape) -> f, its measure by the criterion [Pa]
    # (stress, strength, shape) -> whether the stress is within the yield surface; it is asked of
    # every point in every step, and takes no root
    within: ClassVar[Any]
    # (trial stress outside, strength, shape) -> nearest stress of the yield surface
    nearest: ClassVar[Any]
    # (strain, shape) -> half its shear strain, as the criterion counts it
    shear_measure: ClassVar[Any]
    # (trial stress, k, what of it can be lost, G, decay, shape) -> what a return leaves of that,
    # see `EinavRandolph`; None where the measure less k is G times the plastic shear strain
    softened: ClassVar[Any] = None
    shape_count: ClassVar[int] = 0  # how many numbers of shape it has
    # numbers of state that say how the axis of the ground stands, and what they start as
    axis: ClassVar[Mapping[str, float]] = {}

    @property
    def properties(self) -> tuple[float, ...]:
        """(G, K, su) [Pa], and the shape."""
        return (*super().properties, *self.shape)

    @property
    def state(self) -> tuple[str, ...]:
        """The axis."""
        return tuple(self.axis)

    def state_at(self, stress: Floats, place: Floats) -> Floats:
        """See `Material`; the axis is vertical."""
        return np.tile(tuple(self.axis.values()), (*place.shape[:-1], 1))

    def check_stress_at_rest(self, stress: Floats) -> None:
        """See `Material`; ground of alike horizontal stresses yields as triaxial tests do."""
        mode = "compression" if stress[1] < stress[0] else "extension"
        strength = self.undrained_strength(f"triaxial_{mode}")
        difference = abs(float(stress[1] - stress[0]))
        is_triaxial = stress[0] == stress[3]
        if strength is not None and is_triaxial and difference > 2.0 * strength * (1.0 + ROUNDING):
            raise SceneError(
                f"{type(self).__name__}: the stress of the ground is outside the yield surface: "
                f"vertical and horizontal stress differ by {difference:.6g} Pa, which must be <= "
                f"{2.0 * strength:.6g} Pa in {mode}"
            )

    def update(self) -> Any:
        """Return to the yield surface from outside."""
        return _make_functions(type(self))[0]

    def yield_function(self) -> Any:
        """(f, su)."""
        return _make_functions(type(self))[1]


@functools.cache
def make_shape(criterion: type[PerfectlyPlastic]) -> Any:
    """The function (properties, state) -> numbers of shape and axis, the last of both."""
    shapes, axes = criterion.shape_count, len(criterion.axis)
    shape_type = vector(max(1, shapes + axes))

    @wp.func
    def shape_of(properties: Any, state: Any) -> shape_type:
        shape = shape_type()
        for number in range(wp.static(shapes)):
            shape[number] = properties[len(properties) - wp.static(shapes) + number]
        for number in range(wp.static(axes)):
            shape[wp.static(shapes) + number] = state[len(state) - wp.static(axes) + number]
        return shape

    return shape_of


@functools.cache
def _make_functions(criterion: type[PerfectlyPlastic]) -> tuple[Any, Any]:
    """The update and the yield function."""
    measure, within, nearest = criterion.measure, criterion.within, criterion.nearest
    shape_of = make_shape(criterion)

    @wp.func
    def measure_and_strength(stress: vec4, properties: Any, state: Any) -> vec2:
        return vec2(measure(stress, shape_of(properties, state)), properties[wp.static(STRENGTH)])

    @wp.func
    def elastic_then_return(
        stress: vec4, strain: vec4, time_step: real, properties: Any, state: Any
    ):
        trial = stress + elastic_increment(strain, properties[0], properties[1])
        strength = properties[wp.static(STRENGTH)]
        shape = shape_of(properties, state)
        if within(trial, strength, shape):
            return trial, state
        return nearest(trial, strength, shape), state

    return elastic_then_return, measure_and_strength
