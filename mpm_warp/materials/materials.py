"""Constitutive models: linear elasticity, and perfect plasticity with an undrained strength.

The parameters are here; the stress updates that they name are in `mpm_warp.materials.yielding`.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class LinearElastic:
    """Isotropic linear elasticity in rate form.

    Attributes:
        shear_modulus: G [Pa], > 0.
        poissons_ratio: nu, dimensionless, 0 <= nu < 0.5.
        density: rho [kg/m3], > 0.
    """

    shear_modulus: float
    poissons_ratio: float
    density: float

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
class PerfectlyPlastic(LinearElastic):
    """Elastic up to an undrained shear strength, then perfectly plastic and isochoric.

    Attributes:
        strength: undrained shear strength in pure shear su [Pa], > 0.
    """

    strength: float


@dataclass(frozen=True, kw_only=True)
class Tresca(PerfectlyPlastic):
    """Yields where sigma_1 - sigma_3 = 2 su."""


@dataclass(frozen=True, kw_only=True)
class VonMises(PerfectlyPlastic):
    """Yields where sqrt(J2) = su: matched to Tresca in pure shear, not in triaxial compression."""


CRITERIA = {"tresca": Tresca, "von_mises": VonMises}
"""Perfectly plastic materials by the names that parameters give them."""
