"""Isotropic linear elasticity: what laws with constant moduli share, and soil that never yields.

Symbols: sigma stress (rr, zz, rz, tt), L velocity gradient, e strain of a step, dt times the
symmetric part of L, R rotation by the spin in a step, K bulk modulus, G shear modulus.

    sigma <- law(R sigma R', e, dt)                     of any law
    trial  = R sigma R' + K tr e + 2 G dev e            of one with these elastic moduli
"""

import functools
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.arguments import POSITIVE, Range, checked
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Law, Material
from mpm_warp.precision import Precision

SHEAR_MODULUS, BULK_MODULUS = 0, 1
"""Places of G and K among the properties of an isotropic material."""


@dataclass(frozen=True, kw_only=True)
class Isotropic(Material):
    """Isotropic linear elasticity, up to what the law of a subclass makes of it.

    Its mean stress follows its volume elastically: plastic strain keeps the volume.

    Attributes:
        shear_modulus: G [Pa], > 0.
        poissons_ratio: nu, dimensionless, 0 <= nu < 0.5.
    """

    shear_modulus: float = checked(POSITIVE, unit="Pa")
    poissons_ratio: float = checked(Range(minimum=0, below=0.5))

    @property
    def properties(self) -> tuple[float, ...]:
        """(G, K) [Pa]; a subclass puts its own behind them."""
        return (self.shear_modulus, self.bulk_modulus)

    def properties_at(self, place: Floats) -> Floats:
        """See `Material`; both moduli are in proportion to the stiffness."""
        own = super().properties_at(place)
        own[..., :2] *= self.stiffness_ratio_at(place)[..., None]
        return own

    def moduli(self, precision: Precision) -> Any:
        """The first two properties."""
        lengths = len(self.properties), max(1, len(self.state))
        return _make_moduli(*lengths, precision)

    def mean_stress_change(
        self, volume_strain: Floats, properties: Floats, state: tuple[Floats, Floats] | None
    ) -> Floats:
        """K tr e."""
        change: Floats = properties[:, BULK_MODULUS] * volume_strain
        return change

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
    def ground_shear_modulus(self) -> float:
        """G [Pa]."""
        return self.shear_modulus

    @property
    def pressure_wave_speed(self) -> float:
        """sqrt((K + 4 G / 3) / rho) [m/s]."""
        return float(((self.bulk_modulus + 4.0 / 3.0 * self.shear_modulus) / self.density) ** 0.5)


@dataclass(frozen=True, kw_only=True)
class LinearElastic(Isotropic):
    """Soil or a body that never yields; the rate of its stress is that of Jaumann."""

    def update(self, precision: Precision) -> Any:
        """The trial stress is the stress."""
        return _make_elastic_update(precision)


@functools.cache
def make_elastic_increment(precision: Precision) -> Any:
    """The function (e, G, K) -> K tr e + 2 G dev e, (rr, zz, rz, tt) [Pa]."""
    real, vec4 = precision.real, precision.vec4
    two, third = wp.constant(real(2.0)), wp.constant(real(1.0 / 3.0))  # a division takes longer

    @wp.func
    def elastic_increment(e: vec4, shear: real, bulk: real) -> vec4:
        two_shear = two * shear
        mean = (bulk - third * two_shear) * (e[0] + e[1] + e[3])
        return vec4(
            two_shear * e[0] + mean,
            two_shear * e[1] + mean,
            two_shear * e[2],
            two_shear * e[3] + mean,
        )

    return elastic_increment


@functools.cache
def make_motion(precision: Precision) -> Any:
    """The function (L, time step) -> what a step at the velocity gradient L does to a point.

    L is (rr, rz, zr, zz, tt); the result holds the strain e (rr, zz, rz, tt) and, of the angle of
    the rotation, the square of the sine and the sine and cosine of the double.
    """
    real, vec5, vec7 = precision.real, precision.vec5, precision.vec7
    quarter, half, one, two = (wp.constant(real(x)) for x in (0.25, 0.5, 1.0, 2.0))

    @wp.func
    def motion(L: vec5, time_step: real) -> vec7:
        # Rotation by the angle of the spin, orthogonal whatever the size of the step (Cayley).
        t = quarter * time_step * (L[1] - L[2])
        scale = one / (one + t * t)
        cosine = (one - t * t) * scale
        sine = two * t * scale
        return vec7(
            time_step * L[0],
            time_step * L[3],
            half * time_step * (L[1] + L[2]),
            time_step * L[4],
            sine * sine,
            two * cosine * sine,
            one - two * sine * sine,
        )

    return motion


@functools.cache
def make_rotated(precision: Precision) -> Any:
    """The function (stress, motion) -> R sigma R'."""
    vec4, vec7 = precision.vec4, precision.vec7
    half = wp.constant(precision.real(0.5))

    @wp.func
    def rotated(stress: vec4, motion: vec7) -> vec4:
        rz, difference = stress[2], stress[1] - stress[0]
        square, double_sine, double_cosine = motion[4], motion[5], motion[6]
        change = square * difference + double_sine * rz
        return vec4(
            stress[0] + change,
            stress[1] - change,
            double_cosine * rz + half * double_sine * difference,
            stress[3],
        )

    return rotated


@functools.cache
def make_stress_update(law: Law, precision: Precision) -> Any:
    """The function (stress, motion, time step, properties, state) -> (stress, state) after a step.

    It is that of any law: the stress is turned, then the law does the rest.
    """
    real, vec4, vec7 = precision.real, precision.vec4, precision.vec7
    properties_type, state_type = law.properties_type, law.state_type
    rotated, update = make_rotated(precision), law.update

    @wp.func
    def stress_update(
        stress: vec4,
        motion: vec7,
        time_step: real,
        properties: properties_type,
        state: state_type,
    ):
        strain = vec4(motion[0], motion[1], motion[2], motion[3])
        turned = rotated(stress, motion)
        sigma, remembered = update(turned, strain, time_step, properties, state)
        return sigma, remembered

    return stress_update


@functools.cache
def make_plastic_step(law: Law, precision: Precision) -> Any:
    """The function of the arguments of `make_stress_update` -> what plastic strain follows from.

    It gives the stress after the step, the elastic trial stress less it, and the moduli (G, K)
    that the trial is made with.
    """
    real, vec4, vec7 = precision.real, precision.vec4, precision.vec7
    properties_type, state_type = law.properties_type, law.state_type
    rotated, elastic_increment = make_rotated(precision), make_elastic_increment(precision)
    update, moduli = law.update, law.moduli

    @wp.func
    def plastic_step(
        stress: vec4,
        motion: vec7,
        time_step: real,
        properties: properties_type,
        state: state_type,
    ):
        strain = vec4(motion[0], motion[1], motion[2], motion[3])
        turned = rotated(stress, motion)
        stiffness = moduli(turned, properties, state)
        trial = turned + elastic_increment(strain, stiffness[0], stiffness[1])
        sigma, _ = update(turned, strain, time_step, properties, state)
        return sigma, trial - sigma, stiffness

    return plastic_step


@functools.cache
def _make_moduli(property_count: int, state_count: int, precision: Precision) -> Any:
    vec2, vec4 = precision.vec2, precision.vec4
    properties_type, state_type = precision.vector(property_count), precision.vector(state_count)

    @wp.func
    def constant_moduli(stress: vec4, properties: properties_type, state: state_type) -> vec2:
        return vec2(properties[0], properties[1])

    return constant_moduli


@functools.cache
def _make_elastic_update(precision: Precision) -> Any:
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    vec1 = precision.vector(1)
    elastic_increment = make_elastic_increment(precision)

    @wp.func
    def stays_elastic(stress: vec4, strain: vec4, time_step: real, properties: vec2, state: vec1):
        return stress + elastic_increment(strain, properties[0], properties[1]), state

    return stays_elastic
