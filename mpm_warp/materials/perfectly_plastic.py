"""Soil with an undrained shear strength: elastic up to it, then perfectly plastic and isochoric.

Symbols: f measure of a stress by the yield criterion [Pa], su strength, tau elastic trial stress.

    sigma = tau                                 where f(tau) <= su
    sigma = nearest stress with f = su          elsewhere; the metric is the elastic energy
"""

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.fields.checks import check_kind
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import real, vec2, vec4, vector
from mpm_warp.materials.elasticity import Isotropic, elastic_increment
from mpm_warp.materials.material import Material

STRENGTH = 2
"""Position of su in the properties, after the moduli."""
ROUNDING = 1e-9
"""Distance of an in-situ stress from the yield surface, over su, that counts as rounding."""
OF_UPDATE = (
    "update",
    "properties",
    "state",
    "state_at",
    "bulk_modulus",
    "yield_function",
    "strength_function",
)
"""What clay whose strength changes does not take from its criterion."""


@dataclass(frozen=True, kw_only=True)
class UndrainedClay(Isotropic):
    """The base of clays with an undrained strength whose plastic strain keeps the volume."""

    # in pure shear; in triaxial compression where it depends on direction
    strength: float = parameter(None, "undrained shear strength su", unit="Pa", above=0)

    @property
    def properties(self) -> tuple[float, ...]:
        """(G, K, su) [Pa]."""
        return (*super().properties, self.strength)

    def properties_at(self, place: Floats) -> Floats:
        """See `Material`; strength and shape vary too."""
        own = super().properties_at(place)
        own[..., STRENGTH] *= self.ratio_at(place, "strength_ratio")
        if self.shape:
            own[..., -len(self.shape) :] = self.by_depth(place, lambda material: material.shape)
        return own

    @property
    def limit_pressure(self) -> float:
        """See `limit_pressure`."""
        return limit_pressure(self.shear_modulus, self.strength)


def limit_pressure(shear_modulus: float, strength: float) -> float:
    """Limit pressure of a spherical cavity in perfectly plastic clay [Pa] (Hill 1950)."""
    return 4.0 / 3.0 * strength * (1.0 + math.log(shear_modulus / strength))


class PerfectlyPlastic(UndrainedClay):
    """Perfect plasticity with a yield criterion; `EinavRandolph` uses the criterion too.

    A criterion is a set of device functions. Their last argument `shape` is the vector of the
    numbers of `shape` and `axis`; its length is 1 where there are none. The measure is a shear
    stress: a return lowers it by G times the plastic shear strain, or else `softened` is given.
    """

    measure: ClassVar[Any]  # (stress, shape) -> f [Pa]
    # (stress, strength, shape) -> whether the stress is within the yield surface. Every point calls
    # it in every step, so it takes no root
    within: ClassVar[Any]
    # (trial stress outside, strength, shape) -> nearest stress on the yield surface
    nearest: ClassVar[Any]
    shear_measure: ClassVar[Any]  # (strain, shape) -> half its shear strain, by the criterion
    # (trial stress, k, part of k that can be lost, G, decay, shape) -> share of this part that
    # remains after a return. None: f - k is G times the plastic shear strain
    softened: ClassVar[Any] = None
    axis: ClassVar[Mapping[str, float]] = {}  # state variables of the axis, initial values

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        own = vars(cls)
        if "measure" in own and "undrained_strength" not in own:  # that of its base is another's
            cls.undrained_strength = Material.undrained_strength  # type: ignore[method-assign]
        for name in ("moduli", "properties"):
            if not cls._keeps(name) and cls._keeps("update"):
                raise TypeError(
                    f"{cls.__name__} has {name} of its own, so it needs an update of its own too: "
                    "that of a yield criterion takes G, K, su and the numbers of `shape`"
                )

    @classmethod
    def returns_to_criterion(cls) -> bool:
        """Whether the criterion says all of the update, so that its strength may change."""
        return all(map(cls._keeps, OF_UPDATE))

    @classmethod
    def functions(cls) -> tuple[Any, Any, Any]:
        """`measure`, `within` and `nearest`; `SceneError` if one is no function of the device."""
        for name in ("measure", "within", "nearest"):
            check_kind(f"{cls.__name__}.{name}", getattr(cls, name, None), wp.Function)
        return cls.measure, cls.within, cls.nearest

    @classmethod
    def _keeps(cls, name: str) -> bool:
        return getattr(cls, name) is getattr(PerfectlyPlastic, name)

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
        """See `Material`; if both horizontal stresses are equal, the limit is a triaxial test.

        A criterion with a measure of its own and no strengths has the limit of its base.
        """
        mode = "compression" if stress[1] < stress[0] else "extension"
        criteria = (kind for kind in type(self).__mro__ if issubclass(kind, PerfectlyPlastic))
        known = (kind.undrained_strength(self, f"triaxial_{mode}") for kind in criteria)
        strength = next((it for it in known if it is not None), None)
        difference = abs(float(stress[1] - stress[0]))
        is_triaxial = stress[0] == stress[3]
        if strength is not None and is_triaxial and difference > 2.0 * strength * (1.0 + ROUNDING):
            raise SceneError(
                f"{type(self).__name__}: the stress of the ground is outside the yield surface: "
                f"vertical and horizontal stress differ by {difference:.6g} Pa, which must be <= "
                f"{2.0 * strength:.6g} Pa in {mode}"
            )

    def update(self) -> Any:
        """See `Material`; return to the nearest stress on the yield surface."""
        return _make_functions(type(self), len(self.shape))[0]

    def yield_function(self) -> Any:
        """(f, su)."""
        return _make_functions(type(self), len(self.shape))[1]


@functools.cache
def make_shape(criterion: type[PerfectlyPlastic], shapes: int) -> Any:
    """The function (properties, state) -> shape, the last of the properties and of the state."""
    axes = len(criterion.axis)
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
def _make_functions(criterion: type[PerfectlyPlastic], shapes: int) -> tuple[Any, Any]:
    measure, within, nearest = criterion.functions()
    shape_of = make_shape(criterion, shapes)

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
