"""Exact pressures of a cavity in clay whose strength changes with strain and its rate."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.scenes.cavity.strength_law import cavity_pressure, strain_rate
from mpm_warp.scenes.monotonic_shear import shear_stress


@dataclass(frozen=True, kw_only=True)
class ChangingStrengthCavity:
    """A cavity in incompressible clay that softens or has a rate effect.

    Attributes:
        clay: the clay.
        wall: how the wall moves, in the time of the run.
        radius: of the cavity at the start [m].
        exponent: m, 2 for the cylinder and 3 for the sphere.
        factor: k, 1 for the cylinder and 4/3 for the sphere.
        strength_share: half the difference of the stresses along and across the wall at yield, over
            the strength: 1 but for von Mises around a sphere.
    """

    clay: EinavRandolph
    wall: MovingWall
    radius: float
    exponent: int
    factor: float
    strength_share: float

    def pressure(self, expansion: Floats) -> Floats:
        """Excess pressure in the cavity at radii over the initial one [Pa], both of shape [n]."""
        strains = self.exponent * np.log(expansion)
        parts = zip(strains.tolist(), expansion.tolist(), strict=True)
        return np.array([self._radial_stress(strain, at) for strain, at in parts])

    def pore_pressure(self, distance: Floats, *, expansion: float) -> Floats:
        """Excess pore pressure at distances from the middle [Pa], shape [n].

        The radial stress there is the integral up to the strain of the soil there; the mean stress
        is less by k times the shear stress.

        Args:
            distance: over the radius a of the cavity, >= 1, shape [n].
            expansion: a/a0, > 1.
        """
        m = self.exponent
        rest = distance**m - 1.0 + expansion ** -float(m)
        strains = np.log(distance**m / rest)
        radial = np.array([self._radial_stress(it, expansion) for it in strains.tolist()])
        mean: Floats = radial - self.factor * self._shear_stress(strains, expansion)
        return mean

    def _radial_stress(self, strain: float, expansion: float) -> float:
        """Excess of the stress along the radius where the shear strain is `strain` [Pa]."""
        return cavity_pressure(
            lambda strains: self._shear_stress(strains, expansion),
            strain=strain,
            factor=self.factor,
        )

    def _shear_stress(self, strain: Floats, expansion: float) -> Floats:
        """Half the difference of the stresses along and across the radius [Pa], shape [n]."""
        rate = strain_rate(
            strain,
            exponent=self.exponent,
            growth_rate=self._growth_rate(expansion),
            expansion=expansion,
        )
        share = self.strength_share
        return share * shear_stress(self.clay, strain / share, rate / share)

    def _growth_rate(self, expansion: float) -> float:
        """(da/dt)/a of the cavity [1/s]: the speed rises with the root of the way (MovingWall)."""
        travel = (expansion - 1.0) * self.radius
        speed = self.wall.speed * min(1.0, math.sqrt(travel / self.wall.ramp_travel))
        return speed / (expansion * self.radius)
