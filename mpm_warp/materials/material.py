"""What every material is: elastic constants, and a law that takes a trial stress to the stress.

A material is one file: its properties, what a material point of it remembers, its stress update as
a function on the device, and what its stress must not exceed. A new one is a subclass of `Material`
in a file of its own, which may be a user's. Such a file must not have `from __future__ import
annotations`: Warp reads the types of a kernel from its annotations, and would raise a `NameError`.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

from mpm_warp.arguments import POSITIVE, Range, check_number
from mpm_warp.precision import Precision


@dataclass(frozen=True)
class Law:
    """The functions of a material on the device, in one precision.

    Stresses and strains are (rr, zz, rz, tt), tension positive, rz that of the tensor. `properties`
    holds the material's `properties`, `state` what the point remembers, both as vectors.

    Attributes:
        key: tells the law from all others: where its class is, and how many properties and numbers
            of state it has, by which a class that was defined anew differs from the one before.
        update: (trial stress, strain increment, time step, properties, state) -> (stress, state).
        yield_function: (stress, properties, state) -> (f, k): the material yields where the
            measure f of the stress [Pa] reaches the strength k [Pa]; None where it never does.
        properties_type: type of the vector of properties.
        state_type: type of the vector that a point remembers.
        remembers: whether points remember anything; otherwise `state` is of length 1 and is not
            kept.
    """

    key: str
    update: Any
    yield_function: Any | None
    properties_type: Any
    state_type: Any
    remembers: bool


@dataclass(frozen=True, kw_only=True)
class Material(ABC):
    """Isotropic linear elasticity in rate form, up to what the law of a subclass makes of it.

    Attributes:
        shear_modulus: G [Pa], > 0.
        poissons_ratio: nu, dimensionless, 0 <= nu < 0.5.
        density: rho [kg/m3], > 0.

    Raises:
        SceneError: a value is not allowed.
    """

    state: ClassVar[tuple[str, ...]] = ()
    """Names of the numbers that a material point remembers; all are 0 at the start."""

    shear_modulus: float
    poissons_ratio: float
    density: float

    def __post_init__(self) -> None:
        check_number("material: shear_modulus", self.shear_modulus, POSITIVE, unit="Pa")
        check_number("material: poissons_ratio", self.poissons_ratio, Range(minimum=0, below=0.5))
        check_number("material: density", self.density, POSITIVE, unit="kg/m3")

    @property
    def properties(self) -> tuple[float, ...]:
        """The numbers that the law takes beside stress, strain and state; at least one."""
        return (0.0,)

    @abstractmethod
    def update(self, precision: Precision) -> Any:
        """The stress update on the device; what it takes and gives is said in `Law`."""

    def yield_function(self, precision: Precision) -> Any | None:
        """The yield function on the device; what it takes and gives is said in `Law`."""
        return None

    def law(self, precision: Precision) -> Law:
        """The material's functions on the device in one precision."""
        name = f"{type(self).__module__}.{type(self).__qualname__}".replace("<locals>.", "")
        return Law(
            key=f"{name}.{len(self.properties)}.{len(self.state)}",
            update=self.update(precision),
            yield_function=self.yield_function(precision),
            properties_type=precision.vector(len(self.properties)),
            state_type=precision.vector(max(1, len(self.state))),
            remembers=len(self.state) > 0,
        )

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


@dataclass(frozen=True, kw_only=True)
class PerfectlyPlastic(Material):
    """Elastic up to an undrained shear strength, then perfectly plastic and isochoric.

    Attributes:
        strength: undrained shear strength in pure shear su [Pa], > 0.
    """

    strength: float

    def __post_init__(self) -> None:
        super().__post_init__()
        check_number("material: strength", self.strength, POSITIVE, unit="Pa")

    @property
    def properties(self) -> tuple[float, ...]:
        """The strength su [Pa]."""
        return (self.strength,)

    @property
    def limit_pressure(self) -> float:
        """Of a spherical cavity: 4/3 su (1 + ln(G / su)) [Pa] (Hill 1950)."""
        return 4.0 / 3.0 * self.strength * (1.0 + math.log(self.shear_modulus / self.strength))
