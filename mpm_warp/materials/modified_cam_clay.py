"""Modified Cam clay, undrained: clay with effective stress, whose pore pressure is a result.

Roscoe & Burland (1968); the implicit return is after Borja & Lee (1990). Symbols, compression
positive: p effective mean stress p', q = sqrt(3 J2) of the deviator s, M slope of the critical
state line, p_c size of the yield surface, v specific volume, lambda and kappa slopes of compression
and swelling, e_v volume strain and x its plastic part in a step, K_w / n stiffness of the water in
the pores, u excess pore pressure, R = p_c / p0', Lam = 1 - kappa / lambda.

    f = q^2 / M^2 + p (p - p_c)                         yield surface, flow along its normal
    p_c <- p_c exp(b x),        b = v / (lambda - kappa)
    p   <- p exp(a (e_v - x)),  a = v / kappa           K' = a p,  G = r K' or constant
    s   <- share (s + 2 G dev e),  share = M^2 (2 p - p_c) / (M^2 (2 p - p_c) + 6 G x)
    u   <- u + K_w / n e_v,     total mean stress = p + u

The return is implicit: x is where f = 0, between 0 and where the soil is at its critical state, 2 p
= p_c. So the path of p over q is exact in steps of any size while the volume stays:

    p / p_y = ((M^2 + eta_y^2) / (M^2 + eta^2))^Lam,    eta = q / p, y where it yields

The strain along it has an error of first order; a long step is taken in parts. M is the same in all
directions, or follows the Lode angle t as the criterion of Matsuoka & Nakai (1974) does, with the
flow along s: 1 / M = A cos(acos(-B cos 3 t) / 3), in extension 6 sin(phi) / (3 + sin(phi)).
"""

import functools
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.arguments import Range, checked
from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import (
    half,
    one,
    quarter,
    real,
    third,
    two,
    vec2,
    vec3,
    vec4,
    vector,
    zero,
)
from mpm_warp.materials.material import EFFECTIVE_STRESS, PORE_PRESSURE, Law, Material
from mpm_warp.materials.von_mises import j2
from mpm_warp.parameters import parameter

FLOOR = 1e-6
"""Least effective mean stress, over that at the start."""
STIFFER = 2.0
"""Stiffness of the skeleton that the time step allows for, over that at the stiffest end of an
undrained path; beside the water it is a hundredth of the whole."""
PART, MOST_PARTS = 0.1, 40
"""Elastic change of q in one part of a step, over M p_c, and most parts of a step."""
ITERATIONS = 60
"""Of Newton's method between bounds that each iteration narrows: 60 halvings would do too."""
AT_CRITICAL_STATE = 1e-10
"""Distance to the critical state in the logarithm of 2 p / p_c, at which it is reached."""
CIRCLE, MATSUOKA_NAKAI = "circle", "matsuoka_nakai"

WATER = 5
"""Place of K_w / n among the properties."""

vec9 = vector(9)
three, six = wp.constant(real(3.0)), wp.constant(real(6.0))
of_angle = wp.constant(real(-1.5 * math.sqrt(3.0)))  # tension is positive in s
rounding, tolerance = wp.constant(real(1e-13)), wp.constant(real(1e-10))
small = wp.constant(real(1e-3))
near, longest = wp.constant(real(AT_CRITICAL_STATE)), wp.constant(real(PART))


@dataclass(frozen=True, kw_only=True)
class ModifiedCamClay(Material):
    """Clay with effective stress; the stress of the grid is total, over that of the ground.

    Attributes:
        poissons_ratio: of the undrained clay where it is stiffest, by which the stiffness of the
            water follows; dimensionless, below 0.5.

    Raises:
        SceneError: a value is not allowed, or two do not go together.
    """

    critical_state_ratio: float = parameter(
        1.0, "slope M of the critical state line in compression, q over p'", above=0, below=3
    )
    compression_slope: float = parameter(
        0.2, "slope lambda of compression, specific volume over ln p'; above kappa", above=0
    )
    swelling_slope: float = parameter(
        0.04, "slope kappa of swelling, specific volume over ln p'", above=0
    )
    specific_volume: float = parameter(2.0, "specific volume v, 1 + void ratio", above=1)
    mean_effective_stress: float = parameter(
        50e3, "effective mean stress p' in the ground before", unit="Pa", above=0
    )
    isotropic_overconsolidation_ratio: float = parameter(
        1.0, "R, p_c over p' in the ground before", minimum=1
    )
    effective_poissons_ratio: float = parameter(
        0.25, "Poisson's ratio nu' of the effective stress", minimum=0, below=0.5
    )
    effective_shear_modulus: float | None = parameter(
        None, "constant shear modulus G, in place of the one by nu' and p'", unit="Pa", above=0
    )
    critical_state_shape: str = parameter(
        CIRCLE,
        "M by direction: the same in all, or by the Lode angle as one friction angle has it",
        choices=(CIRCLE, MATSUOKA_NAKAI),
    )
    poissons_ratio: float = checked(Range(minimum=0, below=0.5))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.compression_slope <= self.swelling_slope:
            raise SceneError(
                f"ModifiedCamClay: compression_slope = {self.compression_slope:g} must be > "
                f"swelling_slope = {self.swelling_slope:g}"
            )
        if self.water_modulus <= 0.0:
            raise SceneError(
                f"ModifiedCamClay: poissons_ratio = {self.poissons_ratio:g} of the undrained clay "
                "is too small: its skeleton alone has more; give 0.49"
            )

    # Its numbers.

    @property
    def state(self) -> tuple[str, ...]:
        """(p, p_c, u) [Pa]."""
        return (EFFECTIVE_STRESS, "yield_stress", PORE_PRESSURE)

    def state_at(self, stress: Floats, place: Floats) -> Floats:
        """Undisturbed: what the stress has over that of the ground is shear."""
        start = self.mean_effective_stress * np.array([1.0, self.size_ratio, 0.0])
        return np.tile(start, (*place.shape[:-1], 1))

    def check_stress_at_rest(self, stress: Floats) -> None:
        """See `Material`; its deviator, that of a K0 start, must be within the yield surface."""
        normal = stress[[0, 1, 3]] - stress[[0, 1, 3]].mean()
        q = math.sqrt(1.5 * float(normal @ normal) + 3.0 * float(stress[2]) ** 2)
        M = self._least_slope if stress[1] > stress[0] else self.critical_state_ratio
        least = 1.0 + (q / self.mean_effective_stress / M) ** 2
        if self.size_ratio < least * (1.0 - 1e-9):
            raise SceneError(
                f"ModifiedCamClay: isotropic_overconsolidation_ratio = {self.size_ratio:g} must be "
                f">= {least:.4g}: the stress of the ground is outside the yield surface"
            )

    @property
    def properties(self) -> tuple[float, ...]:
        """(M, a, b, r, G where it is constant, K_w / n, least p, A, B)."""
        return (
            self.critical_state_ratio,
            self._a,
            self.specific_volume / (self.compression_slope - self.swelling_slope),
            *self._stiffness,
            self.water_modulus,
            FLOOR * self.mean_effective_stress,
            *self._shape,
        )

    @property
    def ground_shear_modulus(self) -> float:
        """G at the start [Pa]."""
        return self._moduli_at(self.mean_effective_stress)[0]

    @property
    def water_modulus(self) -> float:
        """K_w / n [Pa]: what the undrained Poisson's ratio leaves of K where G is greatest."""
        shear, bulk = self._moduli_at(self._stiffest_stress)
        nu = self.poissons_ratio
        return 2.0 * shear * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)) - bulk

    @property
    def pressure_wave_speed(self) -> float:
        """With the skeleton stiffer than anywhere on an undrained path [m/s]."""
        shear, bulk = self._moduli_at(STIFFER * self._stiffest_stress)
        return math.sqrt((self.water_modulus + bulk + 4.0 / 3.0 * shear) / self.density)

    @property
    def strength(self) -> float:
        """Undrained shear strength in triaxial compression, M p0' / 2 (R / 2)^Lam [Pa]."""
        return self.undrained_strength("triaxial_compression")

    def undrained_strength(self, test: str) -> float:
        """M p' / 2 in triaxial tests, else M p' / sqrt(3), p' at the critical state [Pa]."""
        if test == "triaxial_compression":
            return 0.5 * self.critical_state_ratio * self._last_stress
        if test == "triaxial_extension":
            return 0.5 * self._least_slope * self._last_stress
        return self._slope_at(0.0) * self._last_stress / math.sqrt(3.0)

    def mean_stress_change(
        self, volume_strain: Floats, properties: Floats, state: tuple[Floats, Floats] | None
    ) -> Floats:
        """By the skeleton, as its state says, and by the water, as the volume says."""
        assert state is not None
        before, after = state
        change: Floats = before[:, 0] - after[:, 0] + properties[:, WATER] * volume_strain
        return change

    @property
    def size_ratio(self) -> float:
        """R, the size of the yield surface over p' in the ground before."""
        return self.isotropic_overconsolidation_ratio

    @property
    def _a(self) -> float:
        return self.specific_volume / self.swelling_slope

    @property
    def _stiffness(self) -> tuple[float, float]:
        """(r, G): what G is over K', and what it is where it is given [Pa]; one is 0."""
        if self.effective_shear_modulus is not None:
            return 0.0, self.effective_shear_modulus
        nu = self.effective_poissons_ratio
        return 1.5 * (1.0 - 2.0 * nu) / (1.0 + nu), 0.0

    @property
    def _last_stress(self) -> float:
        """Effective mean stress at the critical state, p0' (R / 2)^Lam [Pa]."""
        share = 1.0 - self.swelling_slope / self.compression_slope
        return float(self.mean_effective_stress * (0.5 * self.size_ratio) ** share)

    @property
    def _stiffest_stress(self) -> float:
        return max(self.mean_effective_stress, self._last_stress)

    def _moduli_at(self, stress: float) -> tuple[float, float]:
        """(G, K') of the skeleton at an effective mean stress [Pa]."""
        bulk, (ratio, constant) = self._a * stress, self._stiffness
        return ratio * bulk + constant, bulk

    @property
    def _shape(self) -> tuple[float, float]:
        """(A, B) of Matsuoka & Nakai for the friction angle that M has in compression."""
        sine = 3.0 * self.critical_state_ratio / (6.0 + self.critical_state_ratio)
        k = 9.0 + 8.0 * sine**2 / (1.0 - sine**2)
        P, Q = (k / 3.0 - 1.0) / (k - 9.0), 2.0 * k / (27.0 * (k - 9.0))
        return 2.0 * math.sqrt(P / 3.0), 0.5 * Q * (3.0 / P) ** 1.5

    def _slope_at(self, cosine: float) -> float:
        """M where cos 3 t is `cosine`: 1 in compression, -1 in extension."""
        if self.critical_state_shape == CIRCLE:
            return self.critical_state_ratio
        A, B = self._shape
        return 1.0 / (A * math.cos(math.acos(-B * cosine) / 3.0))

    @property
    def _least_slope(self) -> float:
        return self._slope_at(-1.0)

    # The law on the device.

    def update(self) -> Any:
        """Elastic, or back to the surface, in as many parts as the step needs."""
        return _make_update(self._by_angle)

    def moduli(self) -> Any:
        """G and K with the water, at the effective stress."""
        return moduli

    def yield_function(self) -> Any:
        """(Distance of (q / M, p) from the middle of the ellipse, p_c / 2)."""
        return _make_yield_function(self._by_angle)

    def strength_function(self) -> Any:
        """M p / sqrt(3) at the critical state: what shear leaves as it is."""
        return strength_at_critical_state

    def law(self) -> Law:
        """See `Material`; the key has the shape too."""
        law = super().law()
        return replace(law, key=f"{law.key}.{self.critical_state_shape}")

    @property
    def _by_angle(self) -> bool:
        return self.critical_state_shape == MATSUOKA_NAKAI


@functools.cache
def _make_slope(by_angle: bool) -> Any:
    """The function (deviator, its J2, properties) -> M in its direction."""

    @wp.func
    def slope(s: vec4, J2: real, properties: vec9) -> real:
        M = properties[0]
        if wp.static(by_angle):
            if zero < J2:
                J3 = s[3] * (s[0] * s[1] - s[2] * s[2])
                cosine = wp.clamp(of_angle * J3 / (J2 * wp.sqrt(J2)), -one, one)
                M = one / (properties[7] * wp.cos(wp.acos(-properties[8] * cosine) / three))
        return M

    return slope


@wp.func
def deviator(tensor: vec4) -> vec4:
    """The tensor less its mean."""
    mean = third * (tensor[0] + tensor[1] + tensor[3])
    return vec4(tensor[0] - mean, tensor[1] - mean, tensor[2], tensor[3] - mean)


@wp.func
def growth(x: real) -> real:
    """exp(x), faster where x is small: by its series, to rounding."""
    if wp.abs(x) < small:
        return one + x * (one + half * x * (one + third * x * (one + quarter * x)))
    return wp.exp(x)


@wp.func
def shear_modulus(p: real, properties: vec9) -> real:
    """G at an effective mean stress."""
    return properties[3] * properties[1] * p + properties[4]


@wp.func
def moduli(stress: vec4, properties: vec9, state: vec3) -> vec2:
    """(G, K) of skeleton and water."""
    p = state[0]
    return vec2(shear_modulus(p, properties), properties[1] * p + properties[wp.static(WATER)])


@functools.cache
def _make_yield_function(by_angle: bool) -> Any:
    slope = _make_slope(by_angle)

    @wp.func
    def measure_and_size(stress: vec4, properties: vec9, state: vec3) -> vec2:
        J2, middle = j2(stress), half * state[1]
        M, away = slope(deviator(stress), J2, properties), state[0] - middle
        return vec2(wp.sqrt(three * J2 / (M * M) + away * away), middle)

    return measure_and_size


@wp.func
def strength_at_critical_state(stress: vec4, properties: vec9, state: vec3) -> real:
    """M p / sqrt(3) where shear has led to the critical state."""
    share = properties[1] / (properties[1] + properties[2])  # Lam = a / (a + b)
    last = state[0] * wp.pow(half * state[1] / state[0], share)
    return properties[0] * last / wp.sqrt(three)


@wp.func
def is_outside(p: real, pc: real, J2: real, M: real) -> bool:
    """Whether f > 0, beyond rounding."""
    return three * J2 + M * M * p * (p - pc) > rounding * M * M * p * pc


@wp.func
def to_surface(trial: real, size: real, J2: real, G: real, M: real, properties: vec9) -> vec3:
    """(p, p_c, share of the deviator) at f = 0, by (p, p_c, J2 of the trial, G, M, properties)."""
    a, b = properties[1], properties[2]
    MM, square = M * M, three * J2
    last = wp.log(two * trial / size)  # (a + b) x at the critical state
    if wp.abs(last) < near:
        return vec3(trial, two * trial, wp.min(one, M * trial / wp.sqrt(square)))
    last /= a + b
    # f > 0 at x = low, f < 0 at x = high; Newton's method from low, halving where it fails.
    low, high, x = real(0.0), last, real(0.0)
    p, pc, share = one * trial, one * size, real(1.0)
    for _k in range(wp.static(ITERATIONS)):
        p, pc = trial * growth(-a * x), size * growth(b * x)
        rate = two * p - pc
        N = MM * rate
        D = N + six * G * x
        share = N / D
        f = square * share * share + MM * p * (p - pc)
        if wp.abs(f) <= tolerance * MM * p * pc:
            break
        if f > zero:
            low = x
        else:
            high = x
        dN = -MM * (two * a * p + b * pc)
        dshare = (dN - share * (dN + six * G)) / D
        df = two * square * share * dshare - MM * p * (a * rate + b * pc)
        x -= f / df
        if (x - low) * (x - high) >= zero:
            x = half * (low + high)
    # What is left goes to the size of the surface.
    return vec3(p, wp.max(pc, p + square * share * share / (MM * p)), share)


@functools.cache
def _make_update(by_angle: bool) -> Any:
    slope = _make_slope(by_angle)

    @wp.func
    def consolidate_and_shear(
        stress: vec4, strain: vec4, time_step: real, properties: vec9, state: vec3
    ):
        e, e_v = deviator(strain), -(strain[0] + strain[1] + strain[3])
        a_e_v, water, floor = properties[1] * e_v, properties[wp.static(WATER)] * e_v, properties[6]
        before, p, pc = deviator(stress), one * state[0], one * state[1]
        G = shear_modulus(p, properties)
        s = before + (two * G) * e
        p = wp.max(p * growth(a_e_v), floor)
        J2 = j2(s)
        M = slope(s, J2, properties)
        if is_outside(p, pc, J2, M):
            # Once more, in parts.
            s, p = one * before, one * state[0]
            length = two * G * wp.sqrt(three * j2(e)) / (M * pc)
            parts = wp.min(1 + int(length / longest), wp.static(MOST_PARTS))
            part = one / real(parts)
            for _k in range(parts):
                G = shear_modulus(p, properties)
                s += (two * G * part) * e
                p = wp.max(p * growth(part * a_e_v), floor)
                J2 = j2(s)
                M = slope(s, J2, properties)
                if is_outside(p, pc, J2, M):
                    returned = to_surface(p, pc, J2, G, M, properties)
                    p, pc = wp.max(returned[0], floor), returned[1]
                    s *= returned[2]
        mean = third * (stress[0] + stress[1] + stress[3]) - (p - state[0]) - water
        total = s + mean * vec4(one, one, zero, one)
        return total, vec3(p, pc, state[2] + water)

    return consolidate_and_shear
