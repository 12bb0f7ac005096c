"""A law like modified Cam clay, undrained, in one file that only the tests know.

Symbols, compression positive: p' effective mean stress, q sqrt(3 J2), M slope of the critical state
line, p_c size of the yield surface, v specific volume, lambda and kappa slopes of compression and
swelling, e_v volume strain, K_w / n stiffness of the pore water, u excess pore pressure.

    f = q^2 / M^2 + p' (p' - p_c),    dp_c / p_c = v / (lambda - kappa) de_v^p
    dp' / p' = v / kappa (de_v - de_v^p),    K' = v p' / kappa,    G constant over K'
    du = K_w / n de_v,    total mean stress = p' + u

Undrained, from an isotropic start at R = p_c / p0', with Lambda = 1 - kappa / lambda and
eta = q / p':

    p' / p'_y = ((M^2 + eta_y^2) / (M^2 + eta^2))^Lambda,    eta_y^2 = M^2 (R - 1)
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from mpm_warp import Material, parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import half, one, real, two, vec2, vec3, vec4, vec5, zero
from mpm_warp.materials.von_mises import j2

WATER_RATIO = 100.0
"""Stiffness of the water in the pores, K_w / n, over G at the start."""
STIFFEST = 4.0
"""Greatest effective mean stress that the wave speed allows for, over that at the start."""


@dataclass(frozen=True, kw_only=True)
class CamClay(Material):
    """Its state is (p', p_c, u); the stress of the grid is total, over that at the start."""

    critical_state_ratio: float = parameter(1.0, "slope M of the critical state line", above=0)
    compression_slope: float = parameter(0.2, "slope lambda of compression", above=0)
    swelling_slope: float = parameter(0.04, "slope kappa of swelling", above=0)
    specific_volume: float = parameter(2.0, "specific volume v", above=1)
    mean_effective_stress: float = parameter(50e3, "p' at the start", unit="Pa", above=0)
    overconsolidation_ratio: float = parameter(1.0, "R, p_c over p' at the start", minimum=1)
    effective_poissons_ratio: float = parameter(0.25, "nu' of the skeleton", minimum=0, below=0.5)

    @property
    def state(self) -> tuple[str, ...]:
        return ("effective_mean_stress", "yield_stress", "pore_pressure")

    def state_at(self, stress: Floats, place: Floats) -> Floats:
        """Undisturbed: the stress over that at the start is shear alone, or none."""
        p = np.full(place.shape[:-1], self.mean_effective_stress)
        added = -(stress[..., 0] + stress[..., 1] + stress[..., 3]) / 3.0
        return np.stack([p, self.overconsolidation_ratio * p, added], axis=-1)

    @property
    def shear_over_bulk(self) -> float:
        """G / K' of the skeleton."""
        nu = self.effective_poissons_ratio
        return 1.5 * (1.0 - 2.0 * nu) / (1.0 + nu)

    @property
    def ground_shear_modulus(self) -> float:
        bulk = self.specific_volume * self.mean_effective_stress / self.swelling_slope
        return self.shear_over_bulk * bulk

    @property
    def water_modulus(self) -> float:
        """K_w / n [Pa]."""
        return WATER_RATIO * self.ground_shear_modulus

    @property
    def pressure_wave_speed(self) -> float:
        bulk = STIFFEST * self.ground_shear_modulus * (1.0 / self.shear_over_bulk + 4.0 / 3.0)
        return math.sqrt((self.water_modulus + bulk) / self.density)

    @property
    def strength(self) -> float:
        """Undrained, in triaxial compression: M p0' / 2 (R / 2)^Lambda [Pa]."""
        drop = (0.5 * self.overconsolidation_ratio) ** self.plastic_share
        return 0.5 * self.critical_state_ratio * self.mean_effective_stress * drop

    @property
    def plastic_share(self) -> float:
        """Lambda, 1 - kappa / lambda."""
        return 1.0 - self.swelling_slope / self.compression_slope

    @property
    def properties(self) -> tuple[float, ...]:
        """(M, v / kappa, v / (lambda - kappa), G / K', K_w / n)."""
        return (
            self.critical_state_ratio,
            self.specific_volume / self.swelling_slope,
            self.specific_volume / (self.compression_slope - self.swelling_slope),
            self.shear_over_bulk,
            self.water_modulus,
        )

    def mean_stress_change(
        self, volume_strain: Floats, properties: Floats, state: tuple[Floats, Floats] | None
    ) -> Floats:
        """By the skeleton, as its state says, and by the water, as the volume says."""
        assert state is not None
        before, after = state
        change: Floats = before[:, 0] - after[:, 0] + properties[:, 4] * volume_strain
        return change

    def update(self) -> Any:
        return update

    def moduli(self) -> Any:
        return moduli

    def yield_function(self) -> Any:
        return measure_and_size

    def strength_function(self) -> Any:
        return frictional


@wp.func
def moduli(stress: vec4, properties: vec5, state: vec3) -> vec2:
    bulk = properties[1] * state[0]
    return vec2(properties[3] * bulk, bulk + properties[4])


@wp.func
def measure_and_size(stress: vec4, properties: vec5, state: vec3) -> vec2:
    p, M = state[0], properties[0]
    return vec2(p + real(3.0) * j2(stress) / (M * M * p), state[1])


@wp.func
def frictional(stress: vec4, properties: vec5, state: vec3) -> real:
    return properties[0] * state[0] / wp.sqrt(real(3.0))


three = wp.constant(real(3.0))
rounding = wp.constant(real(1e-13))


@wp.func
def on_surface(x: real, p0: real, pc0: real, J: real, e_v: real, properties: vec5) -> vec4:
    """(f / p_c^2, p', p_c, share of the deviator) where the plastic volume strain is x."""
    p = p0 * wp.exp(properties[1] * (e_v - x))
    pc = pc0 * wp.exp(properties[2] * x)
    M = properties[0]
    G = properties[3] * properties[1] * half * (p0 + p)
    # Associated flow: de_v^p = L (2 p' - p_c), deviator 3 s / M^2 L.
    rate = two * p - pc
    share = zero  # at the critical state
    if wp.abs(rate) > real(1e-14) * pc:
        share = one / (one + real(6.0) * G * (x / rate) / (M * M))
    f = (three * J * share * share / (M * M) + p * (p - pc)) / (pc * pc)
    return vec4(f, p, pc, share)


@wp.func
def update(stress: vec4, strain: vec4, time_step: real, properties: vec5, state: vec3):
    e_v = -(strain[0] + strain[1] + strain[3])
    M, p0, pc0 = properties[0], state[0], state[1]
    u = state[2] + properties[4] * e_v
    p = p0 * wp.exp(properties[1] * e_v)
    G = properties[3] * properties[1] * half * (p0 + p)
    mean = (stress[0] + stress[1] + stress[3]) / three
    third = -e_v / three
    s = vec4(
        stress[0] - mean + two * G * (strain[0] - third),
        stress[1] - mean + two * G * (strain[1] - third),
        stress[2] + two * G * strain[2],
        stress[3] - mean + two * G * (strain[3] - third),
    )
    pc = real(1.0) * pc0
    share = real(1.0)
    J = j2(s)
    if three * J / (M * M) + p * (p - pc0) > rounding * pc0 * pc0:
        # The surface is met between no plastic volume strain and where 2 p' = p_c.
        low = real(0.0)
        high = wp.log(two * p / pc0) / (properties[1] + properties[2])
        if wp.abs(high) < real(1e-12):
            share, pc = M * p / wp.sqrt(three * J), two * p
        else:
            for _k in range(50):
                x = half * (low + high)
                tried = on_surface(x, p0, pc0, J, e_v, properties)
                if tried[0] > zero:
                    low = x
                else:
                    high = x
            tried = on_surface(half * (low + high), p0, pc0, J, e_v, properties)
            p, pc, share = tried[1], tried[2], tried[3]
            # What bisection leaves goes to the size of the surface, a rounding.
            pc = wp.max(pc, p + three * J * share * share / (M * M * p))
    start = p0 + state[2] + mean
    total = start - p - u
    return vec4(
        share * s[0] + total, share * s[1] + total, share * s[2], share * s[3] + total
    ), vec3(p, pc, u)
