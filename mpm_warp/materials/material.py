"""What every material is: elastic constants, and a law that takes a trial stress to the stress.

A material is one file: its properties, what a material point of it remembers, its stress update as
a function on the device, and what its stress must not exceed. A new one is a subclass of `Material`
in a file of its own, which may be a user's. Such a file must not have `from __future__ import
annotations`: Warp reads the types of a kernel from its annotations, and would raise a `NameError`.
"""

import functools
import math
import re
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.arguments import POSITIVE, Range, check_kind, check_number
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.variation import Variation
from mpm_warp.precision import Precision

PROPERTIES = "particle.properties"
"""The array of the properties of each point of a material that varies, shape [slot_count]."""


@dataclass(frozen=True)
class Law:
    """The functions of a material on the device, in one precision.

    Stresses and strains are (rr, zz, rz, tt), tension positive, rz that of the tensor. `properties`
    holds the material's `properties`, `state` what the point remembers, both as vectors. Where the
    material varies from place to place a stiffness ratio stands before the properties, and each
    point has its own.

    Attributes:
        key: of this law alone: where its class is, and how many properties and numbers of state it
            has, by which a class that was defined anew differs from the one before.
        update: (trial stress, strain increment, time step, properties, state) -> (stress, state).
        yield_function: (stress, properties, state) -> (f, k): the material yields where the
            measure f of the stress [Pa] reaches the strength k [Pa]; None where it never does.
        properties_type: type of the vector of properties.
        state_type: type of the vector that a point remembers.
        remembers: whether points remember anything; otherwise `state` is of length 1 and is not
            kept.
        varies: whether each point has properties of its own.
        varies_adhesion: whether the last of them is the adhesion ratio of a surface beside it.
    """

    key: str
    update: Any
    yield_function: Any | None
    properties_type: Any
    state_type: Any
    remembers: bool
    varies: bool = False
    varies_adhesion: bool = False

    @property
    def properties_argument(self) -> Any:
        """Type of the argument of a kernel that holds the properties: one for all, or an array."""
        return wp.array(dtype=self.properties_type) if self.varies else self.properties_type


@dataclass(frozen=True, kw_only=True)
class Material(ABC):
    """Isotropic linear elasticity in rate form, up to what the law of a subclass makes of it.

    Attributes:
        shear_modulus: G [Pa], > 0.
        poissons_ratio: nu, dimensionless, 0 <= nu < 0.5.
        density: rho [kg/m3], > 0.
        variation: strength and stiffness from place to place, over those of the material; None:
            they are the same everywhere.

    Raises:
        SceneError: a value is not allowed.
    """

    shear_modulus: float
    poissons_ratio: float
    density: float
    variation: Variation | None = None

    def __post_init__(self) -> None:
        check_number("material: shear_modulus", self.shear_modulus, POSITIVE, unit="Pa")
        check_number("material: poissons_ratio", self.poissons_ratio, Range(minimum=0, below=0.5))
        check_number("material: density", self.density, POSITIVE, unit="kg/m3")
        check_kind("material: variation", self.variation, (Variation, type(None)))

    @property
    def properties(self) -> tuple[float, ...]:
        """The numbers that the law takes beside stress, strain and state; at least one.

        The strength comes first, where there is one: it is what a variation varies.
        """
        return (0.0,)

    @property
    def state(self) -> tuple[str, ...]:
        """Names of the numbers that a material point remembers; all are 0 at the start."""
        return ()

    def stiffness_ratio_at(self, place: Floats) -> Floats:
        """Shear modulus over `shear_modulus` at places in the ground.

        Args:
            place: (r, z) in the ground [m], shape [..., 2]; see `Variation`.
        """
        if self.variation is None:
            return np.ones(place.shape[:-1])
        return self.variation.stiffness_ratio_at(place)

    def strength_ratio_at(self, place: Floats) -> Floats:
        """Strength over that of the material at places in the ground, as `stiffness_ratio_at`."""
        if self.variation is None:
            return np.ones(place.shape[:-1])
        return self.variation.strength_ratio_at(place)

    def relative_adhesion_at(self, place: Floats) -> Floats:
        """Adhesion of a surface over what it is beside soil of the material itself, likewise."""
        ratio = self.strength_ratio_at(place)
        return ratio if self.variation is None else ratio * self.variation.adhesion_ratio_at(place)

    @property
    def varies_adhesion(self) -> bool:
        """Whether the adhesion factor of a surface varies with the soil beside it."""
        return self.variation is not None and self.variation.adhesion_ratio is not None

    def properties_at(self, place: Floats) -> Floats:
        """Stiffness ratio and `properties` of points whose material varies, shape [..., 1 + n].

        Behind them stands the adhesion ratio, where it varies.

        Args:
            place: (r, z) in the ground where they come from [m], shape [..., 2].
        """
        count = len(self.properties)
        own = np.empty((*place.shape[:-1], 1 + count + self.varies_adhesion))
        own[..., 0] = self.stiffness_ratio_at(place)
        own[..., 1 : 1 + count] = self.properties
        own[..., 1] *= self.strength_ratio_at(place)
        if self.variation is not None and self.varies_adhesion:
            own[..., -1] = self.variation.adhesion_ratio_at(place)
        return own

    @abstractmethod
    def update(self, precision: Precision) -> Any:
        """The stress update on the device; what it takes and gives is said in `Law`."""

    def yield_function(self, precision: Precision) -> Any | None:
        """The yield function on the device; what it takes and gives is said in `Law`."""
        return None

    def law(self, precision: Precision) -> Law:
        """The material's functions on the device in one precision."""
        name = f"{type(self).__module__}.{type(self).__qualname__}".replace("<locals>.", "")
        law = Law(
            key=f"{name}.{len(self.properties)}.{len(self.state)}",
            update=self.update(precision),
            yield_function=self.yield_function(precision),
            properties_type=precision.vector(len(self.properties)),
            state_type=precision.vector(max(1, len(self.state))),
            remembers=len(self.state) > 0,
        )
        if self.variation is None:
            return law
        return _varied(law, len(self.properties), self.varies_adhesion, precision)

    def launch_properties(self, law: Law) -> Any:
        """What a launch is given for the properties: one vector for all points, or an array."""
        return PROPERTIES if law.varies else law.properties_type(*self.properties)

    @property
    def limit_pressure(self) -> float:
        """Pressure [Pa] that a cavity in an endless body of the material cannot exceed."""
        return math.inf

    @property
    def bulk_modulus(self) -> float:
        """K = 2 G (1 + nu) / (3 (1 - 2 nu)) [Pa]."""
        return (
            2.0
            * self.shear_modulus
            * (1.0 + self.poissons_ratio)
            / (3.0 * (1.0 - 2.0 * self.poissons_ratio))
        )

    @property
    def shear_wave_speed(self) -> float:
        """sqrt(G / rho) [m/s]."""
        return float((self.shear_modulus / self.density) ** 0.5)

    @property
    def pressure_wave_speed(self) -> float:
        """sqrt((K + 4 G / 3) / rho) [m/s]."""
        return float(((self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus) / self.density) ** 0.5)


def built_name(part: object) -> str:
    """What a part of a scene is, whatever its parameters are called.

    `tresca`, `penetrometer_contact`: the class in small letters; that of another package by its
    place, as `their_package.clay.HardeningClay`.
    """
    kind = type(part)
    if kind.__module__.partition(".")[0] == __package__.partition(".")[0]:
        return re.sub(r"(?<!^)(?=[A-Z])", "_", kind.__name__).lower()
    return f"{kind.__module__}.{kind.__qualname__}".replace("<locals>.", "")


@functools.cache
def make_properties_of_point(law: Law) -> Any:
    """The function (properties, number of a point) -> those of the point; see `Law`."""
    properties_type, properties_argument = law.properties_type, law.properties_argument

    if law.varies:

        @wp.func
        def own_properties(properties: properties_argument, point: int) -> properties_type:
            return properties[point]

        return own_properties

    @wp.func
    def common_properties(properties: properties_type, point: int) -> properties_type:
        return properties

    return common_properties


@functools.cache
def make_state_of_point(law: Law) -> Any:
    """The function (states, number of a point) -> what that point remembers; see `Law`."""
    state_type = law.state_type

    if law.remembers:

        @wp.func
        def own_state(states: wp.array(dtype=state_type), point: int) -> state_type:
            return states[point]

        return own_state

    @wp.func
    def no_state(states: wp.array(dtype=state_type), point: int) -> state_type:
        return state_type()

    return no_state


@functools.cache
def _varied(law: Law, property_count: int, varies_adhesion: bool, precision: Precision) -> Law:
    """The law of a material that varies: a stiffness ratio stands before the properties.

    Where it varies the adhesion ratio, that stands behind them, for a contact to read.
    """
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    state_type, common_type = law.state_type, law.properties_type
    own_type = precision.vector(1 + property_count + varies_adhesion)
    common_update: Any = law.update
    common_yield_function: Any = law.yield_function

    @wp.func
    def without_stiffness(own: own_type) -> common_type:
        properties = common_type()
        for k in range(wp.static(property_count)):
            properties[k] = own[k + 1]
        return properties

    @wp.func
    def update(trial: vec4, strain: vec4, time_step: real, own: own_type, state: state_type):
        stress, remembered = common_update(trial, strain, time_step, without_stiffness(own), state)
        return stress, remembered

    @wp.func
    def yield_function(stress: vec4, own: own_type, state: state_type) -> vec2:
        return common_yield_function(stress, without_stiffness(own), state)

    return replace(
        law,
        key=f"varied.{'adhesion.' if varies_adhesion else ''}{law.key}",
        update=update,
        yield_function=None if common_yield_function is None else yield_function,
        properties_type=own_type,
        varies=True,
        varies_adhesion=varies_adhesion,
    )
