"""Modified Cam clay, undrained: clay with effective stress, whose pore pressure is a result.

After Roscoe & Burland (1968). Symbols, compression positive: p effective mean stress p', q = sqrt(3
J2) of the deviator s, M slope of the critical state line, p_c size of the yield surface, v specific
volume, lambda and kappa slopes of compression and swelling, e_v volume strain, K_w / n stiffness of
the water in the pores, u excess pore pressure, R = p_c / p0', Lam = 1 - kappa / lambda.

    f = q^2 / M^2 + p (p - p_c)                         yield surface, flow along its normal
    dp / p = v / kappa (de_v - de_v^p),   dp_c / p_c = v / (lambda - kappa) de_v^p
    K' = v p / kappa,   G = r K' or constant
    du = K_w / n de_v,   total mean stress = p + u

At constant volume, from yield y to the critical state, where p = p0' (R / 2)^Lam:

    p / p_y = ((M^2 + eta_y^2) / (M^2 + eta^2))^Lam,    eta = q / p

The vertical overconsolidation ratio OCR gives R. The index k marks the state under the greatest
vertical stress. Since then K0 has grown by the factor OCR^sin(phi) (Mayne & Kulhawy 1982), from
1 - sin(phi) (Jaky 1944) where K0 is not given:

    R = OCR (1 + 2 K0_k) / (1 + 2 K0) (1 + eta_k^2 / M^2),    sin(phi) = 3 M / (6 + M)
    K0_k = K0 / OCR^sin(phi),   eta_k = 3 (1 - K0_k) / (1 + 2 K0_k)

M is the same at all Lode angles, or follows the criterion of Matsuoka & Nakai (1974):
6 sin(phi) / (3 - sin(phi)) in compression, 6 sin(phi) / (3 + sin(phi)) in extension.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from mpm_warp.errors import SceneError
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.cam_clay_return import (
    WATER,
    make_functions,
    moduli,
    strength_at_critical_state,
)
from mpm_warp.materials.material import EFFECTIVE_STRESS, PORE_PRESSURE, Material

FLOOR = 1e-6
"""Least effective mean stress, over the initial one."""
STRESS_ALLOWANCE = 2.0
"""Effective mean stress that the time step allows for, over the greatest of an undrained path. The
skeleton has about a hundredth of the stiffness of the water."""
CIRCLE, MATSUOKA_NAKAI = "circle", "matsuoka_nakai"


@dataclass(frozen=True, kw_only=True)
class ModifiedCamClay(Material):
    """Clay with effective stress; the stress of the points is total, in excess of in-situ stress.

    Raises:
        SceneError: a value is not allowed, or two contradict each other.

    Example:
        >>> clay = ModifiedCamClay(
        ...     critical_state_ratio=1.0,
        ...     compression_slope=0.2,
        ...     swelling_slope=0.04,
        ...     specific_volume=2.2,
        ...     mean_effective_stress=100e3,
        ...     isotropic_overconsolidation_ratio=1.5,
        ...     density=1700.0,
        ... )
        >>> round(clay.undrained_strength("triaxial_compression"))  # [Pa]
        39721
    """

    critical_state_ratio: float = parameter(
        1.0,
        "slope M of the critical state line in compression, q over p'; 6 sin(phi) / (3 - sin(phi))",
        above=0,
        below=3,
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
    vertical_overconsolidation_ratio: float | None = parameter(
        None,
        "OCR, greatest effective vertical stress so far over that in the ground, in place of R",
        minimum=1,
    )
    earth_pressure_at_rest: float | None = parameter(
        None,
        "K0, effective horizontal over vertical stress in the ground before, by which "
        "stress_anisotropy follows where it is not given (default: none; with a vertical "
        "overconsolidation ratio (1 - sin phi) OCR^sin phi)",
        above=0,
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
    poissons_ratio: float = parameter(
        None,
        "that of the undrained clay where it is stiffest, by the stiffness of the water",
        minimum=0,
        below=0.5,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.compression_slope <= self.swelling_slope:
            raise SceneError(
                f"ModifiedCamClay: compression_slope = {self.compression_slope:g} must be > "
                f"swelling_slope = {self.swelling_slope:g}"
            )
        if self.vertical_overconsolidation_ratio and self.isotropic_overconsolidation_ratio != 1.0:
            raise SceneError(
                "ModifiedCamClay: vertical_overconsolidation_ratio = "
                f"{self.vertical_overconsolidation_ratio:g} and isotropic_overconsolidation_ratio "
                f"= {self.isotropic_overconsolidation_ratio:g}: keep one of them"
            )
        if self.deviator_at_rest is not None:
            self.check_stress_at_rest(np.array([0.0, -self.deviator_at_rest, 0.0, 0.0]))
        if self.poissons_ratio is not None and self.water_modulus <= 0.0:
            raise SceneError(
                f"ModifiedCamClay: poissons_ratio = {self.poissons_ratio:g} of the undrained clay "
                "is too small: its skeleton alone has more; give 0.49"
            )

    @property
    def state(self) -> tuple[str, ...]:
        """(p, p_c, u) [Pa]."""
        return (EFFECTIVE_STRESS, "yield_stress", PORE_PRESSURE)

    def state_at(self, stress: Floats, place: Floats) -> Floats:
        """See `Material`; p0', R p0' and no pore pressure, whatever the stress."""
        return self.by_depth(
            place, lambda it: it.mean_effective_stress * np.array([1.0, it.size_ratio, 0.0])
        )

    def check_stress_at_rest(self, stress: Floats) -> None:
        """See `Material`; with this deviator the state must be within the yield surface."""
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
        """(M, a, b, r, G if constant, K_w / n, least p)."""
        return (
            self.critical_state_ratio,
            self._a,
            self.specific_volume / (self.compression_slope - self.swelling_slope),
            *self._stiffness,
            self.water_modulus,
            FLOOR * self.mean_effective_stress,
        )

    @property
    def ground_shear_modulus(self) -> float:
        """Initial G [Pa]."""
        return self._moduli_at(self.mean_effective_stress)[0]

    @property
    def water_modulus(self) -> float:
        """K_w / n [Pa]: K by the undrained Poisson's ratio less K', where G is greatest."""
        shear, bulk = self._moduli_at(self._stiffest_stress)
        nu = self.poissons_ratio
        return 2.0 * shear * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)) - bulk

    @property
    def pressure_wave_speed(self) -> float:
        """See `Material`; the skeleton is taken stiffer than on any undrained path."""
        shear, bulk = self._moduli_at(STRESS_ALLOWANCE * self._stiffest_stress)
        own = math.sqrt((self.water_modulus + bulk + 4.0 / 3.0 * shear) / self.density)
        rows = () if self.variation is None else self.variation.rows or ()
        return max([own, *(row.pressure_wave_speed for row in rows)])

    @property
    def strength(self) -> float:
        """Undrained shear strength in triaxial compression, M p0' / 2 (R / 2)^Lam [Pa]."""
        return self.undrained_strength("triaxial_compression")

    def undrained_strength(self, test: str) -> float:
        """See `Material`; M p / 2 in triaxial tests, else M p / sqrt(3), at the critical state."""
        if test == "triaxial_compression":
            return 0.5 * self.critical_state_ratio * self._last_stress
        if test == "triaxial_extension":
            return 0.5 * self._least_slope * self._last_stress
        M = self.critical_state_ratio
        in_shear = math.sqrt(9.0 * M**2 / (9.0 + 3.0 * M + M**2)) if self._by_angle else M
        return in_shear * self._last_stress / math.sqrt(3.0)

    def mean_stress_change(
        self, volume_strain: Floats, properties: Floats, state: tuple[Floats, Floats] | None
    ) -> Floats:
        """See `Material`; change of p by the state, and of the water by the volume."""
        assert state is not None
        before, after = state
        return before[:, 0] - after[:, 0] + properties[:, WATER] * volume_strain

    @property
    def size_ratio(self) -> float:
        """R = p_c / p0'."""
        ratio, at_rest = self.vertical_overconsolidation_ratio, self._pressure_ratio
        if ratio is None or at_rest is None:
            return self.isotropic_overconsolidation_ratio
        then = at_rest / ratio**self._sine_of_friction
        mean = ratio * (1.0 + 2.0 * then) / (1.0 + 2.0 * at_rest)
        over_slope = 3.0 * (1.0 - then) / (1.0 + 2.0 * then) / self.critical_state_ratio
        return mean * (1.0 + over_slope**2)

    @property
    def deviator_at_rest(self) -> float | None:
        """See `Material`; by p0' and K0 [Pa], if K0 is known."""
        at_rest = self._pressure_ratio
        if at_rest is None:
            return None
        return 3.0 * self.mean_effective_stress * (1.0 - at_rest) / (1.0 + 2.0 * at_rest)

    @property
    def _pressure_ratio(self) -> float | None:
        """K0."""
        ratio, sine = self.vertical_overconsolidation_ratio, self._sine_of_friction
        if self.earth_pressure_at_rest is not None or ratio is None:
            return self.earth_pressure_at_rest
        return (1.0 - sine) * ratio**sine

    @property
    def _sine_of_friction(self) -> float:
        return 3.0 * self.critical_state_ratio / (6.0 + self.critical_state_ratio)

    @property
    def _a(self) -> float:
        return self.specific_volume / self.swelling_slope

    @property
    def _stiffness(self) -> tuple[float, float]:
        """(r, G) of G = r K' or constant G [Pa]; the other one is 0."""
        if self.effective_shear_modulus is not None:
            return 0.0, self.effective_shear_modulus
        nu = self.effective_poissons_ratio
        return 1.5 * (1.0 - 2.0 * nu) / (1.0 + nu), 0.0

    @property
    def _last_stress(self) -> float:
        """Effective mean stress at the critical state [Pa]."""
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
    def _least_slope(self) -> float:
        M = self.critical_state_ratio
        return 3.0 * M / (3.0 + M) if self._by_angle else M

    def update(self) -> Any:
        """See `cam_clay_return`."""
        return make_functions(self._by_angle)[0]

    def moduli(self) -> Any:
        """G and K of skeleton and water."""
        return moduli

    def yield_function(self) -> Any:
        """Distance of (q / M, p) from the middle of the ellipse, and p_c / 2."""
        return make_functions(self._by_angle)[1]

    def strength_function(self) -> Any:
        """M p / sqrt(3) at the critical state, which undrained shear does not change."""
        return strength_at_critical_state

    @property
    def _by_angle(self) -> bool:
        return self.critical_state_shape == MATSUOKA_NAKAI
