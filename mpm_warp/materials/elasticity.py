"""Isotropic linear elasticity, the base of laws with constant moduli, and soil that never yields.

Symbols: sigma stress (rr, zz, rz, tt), L velocity gradient, e strain of a step, which is dt times
the symmetric part of L, R rotation by the spin in a step, K bulk modulus, G shear modulus.

    sigma <- law(R sigma R', e, dt)                     every law; axes of the ground turn too
    trial  = R sigma R' + K tr e + 2 G dev e            laws with constant moduli
"""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import half, one, quarter, real, third, two, vec1, vec2, vec4, vec5, vec7
from mpm_warp.materials.material import Law, Material

SHEAR_MODULUS, BULK_MODULUS = 0, 1
"""Positions of G and K in the properties of an isotropic material."""


@dataclass(frozen=True, kw_only=True)
class Isotropic(Material):
    """The base of laws with constant elastic moduli whose plastic strain keeps the volume.

    Example:
        >>> clay = Tresca(strength=10e3, shear_modulus=1e6, poissons_ratio=0.49, density=1700.0)
        >>> isinstance(clay, Isotropic), round(clay.pressure_wave_speed)  # [m/s]
        (True, 173)
    """

    shear_modulus: float = parameter(None, "shear modulus G", unit="Pa", above=0)
    poissons_ratio: float = parameter(None, "Poisson's ratio nu", minimum=0, below=0.5)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.variation is not None and self.variation.rows is not None and not self.shape:
            raise SceneError(
                f"{type(self).__name__}: variation.rows: stiffness and strength vary by the ratios "
                "of the variation, and nothing else does"
            )

    @property
    def shape(self) -> tuple[float, ...]:
        """The last properties; in ground that varies they are interpolated between its rows."""
        return ()

    @property
    def properties(self) -> tuple[float, ...]:
        """(G, K) [Pa]; a subclass appends its own."""
        return (self.shear_modulus, self.bulk_modulus)

    def properties_at(self, place: Floats) -> Floats:
        """See `Material`; both moduli are in proportion to the stiffness ratio."""
        own = np.tile(self.properties, (*place.shape[:-1], 1))
        own[..., :2] *= self.ratio_at(place, "stiffness_ratio")[..., None]
        return own

    def moduli(self) -> Any:
        """(G, K)."""
        return constant_moduli

    def mean_stress_change(
        self, volume_strain: Floats, properties: Floats, state: tuple[Floats, Floats] | None
    ) -> Floats:
        """K tr e."""
        return properties[:, BULK_MODULUS] * volume_strain

    @property
    def bulk_modulus(self) -> float:
        """K = 2 G (1 + nu) / (3 (1 - 2 nu)) [Pa]."""
        nu = self.poissons_ratio
        return 2.0 * self.shear_modulus * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))

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
    """Soil or a body that never yields, with the Jaumann rate of stress.

    Example:
        >>> steel = LinearElastic(shear_modulus=80e9, poissons_ratio=0.3, density=7850.0)
        >>> round(steel.shear_wave_speed)  # [m/s]
        3192
    """

    def update(self) -> Any:
        """Elastic."""
        return stays_elastic


@wp.func
def elastic_increment(e: vec4, G: real, K: real) -> vec4:
    """K tr e + 2 G dev e, (rr, zz, rz, tt) [Pa]."""
    two_shear = two * G
    mean = (K - third * two_shear) * (e[0] + e[1] + e[3])
    return vec4(
        two_shear * e[0] + mean,
        two_shear * e[1] + mean,
        two_shear * e[2],
        two_shear * e[3] + mean,
    )


@wp.func
def motion_of(L: vec5, time_step: real) -> vec7:
    """Strain and rotation of a step, by the velocity gradient L (rr, rz, zr, zz, tt).

    The strain is (rr, zz, rz, tt). The rotation by the angle a is (sin^2 a, sin 2a, cos 2a).
    """
    # Cayley's formula: the rotation is orthogonal in steps of any size.
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


@wp.func
def rotated(stress: vec4, motion: vec7) -> vec4:
    """R sigma R'."""
    rz, difference = stress[2], stress[1] - stress[0]
    square, double_sine, double_cosine = motion[4], motion[5], motion[6]
    change = square * difference + double_sine * rz
    return vec4(
        stress[0] + change,
        stress[1] - change,
        double_cosine * rz + half * double_sine * difference,
        stress[3],
    )


@functools.cache
def make_stress_update(law: Law) -> Any:
    """The function (stress, motion, time step, properties, state) -> (stress, state) after a step.

    It turns stress and axis by the spin before it applies the law.
    """

    @wp.func
    def stress_update(stress: vec4, motion: vec7, time_step: real, properties: Any, state: Any):
        strain = vec4(motion[0], motion[1], motion[2], motion[3])
        turned = rotated(stress, motion)
        if wp.static(law.turn is not None):
            state = law.turn(state, motion)
        sigma, remembered = law.update(turned, strain, time_step, properties, state)
        return sigma, remembered

    return stress_update


@functools.cache
def make_plastic_step(law: Law) -> Any:
    """The function (stress, motion, time step, properties, state) -> stress, difference, (G, K).

    The difference is the elastic trial stress, by the moduli (G, K), less the stress after a step.
    """

    @wp.func
    def plastic_step(stress: vec4, motion: vec7, time_step: real, properties: Any, state: Any):
        strain = vec4(motion[0], motion[1], motion[2], motion[3])
        turned = rotated(stress, motion)
        if wp.static(law.turn is not None):
            state = law.turn(state, motion)
        moduli = law.moduli(turned, properties, state)
        trial = turned + elastic_increment(strain, moduli[0], moduli[1])
        sigma, _ = law.update(turned, strain, time_step, properties, state)
        return sigma, trial - sigma, moduli

    return plastic_step


@wp.func
def constant_moduli(stress: vec4, properties: Any, state: Any) -> vec2:
    """(G, K)."""
    return vec2(properties[0], properties[1])


@wp.func
def stays_elastic(stress: vec4, strain: vec4, time_step: real, properties: vec2, state: vec1):
    """The elastic trial stress."""
    return stress + elastic_increment(strain, properties[0], properties[1]), state
