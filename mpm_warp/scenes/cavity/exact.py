"""Exact pressures around a cavity that expands in incompressible clay of any strength law.

The volume is constant, so a point at radius r that started at r0 has the shear strain
gamma = m ln(r/r0). The cavity has the radius a and started at a0. tau(gamma) is half the difference
of radial and hoop stress. Equilibrium gives the pressure p over the initial stress p0:

    p - p0 = k int_0^(m ln(a/a0)) tau(gamma) dgamma / (e^gamma - 1)

m = 2 and k = 1 for the cylinder, m = 3 and k = 4/3 for the sphere. The strain rate at a point is
m (da/dt)/a (1 - e^-gamma) / (1 - (a0/a)^m). In perfectly plastic clay of strength su, with
e = 1 - (a0/a)^m, x = 1 - exp(-1/Ir) and the dilogarithm Li2,

    (p - p0)/su = k Ir Li2(e) while e <= x, then k (Ir Li2(x) + ln(e/x))
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy  # loads special functions where they are first used: no other scene waits for them

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.scenes.material.strain_paths import shear_stress

RADIUS = 1.0
"""Initial radius of the cavity [m]."""
SMALLEST_STRAIN, LARGEST_STRAIN = 1e-9, 60.0
"""Range of the numerical integral. Below it tau is linear; beyond it e^-60 is missing."""
PANELS, POINTS = 4000, 3
"""Panels, of equal width in ln(gamma), and Gauss points in each. The error is 3e-6 of tau where its
slope jumps, rounding elsewhere."""


def cavity_pressure(
    shear_stress: Callable[[Floats], Floats], *, strain: float, factor: float
) -> float:
    """Excess pressure p - p0 in the unit of the shear stress tau, which depends on strains [n].

    The strain is m ln(a/a0) at the wall, > 1e-9, infinite for the limit; the factor is k.
    """
    last = min(strain, LARGEST_STRAIN)
    ends = np.linspace(math.log(SMALLEST_STRAIN), math.log(last), PANELS + 1)
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    width = np.diff(ends)[:, None]
    gamma = np.exp(ends[:-1, None] + 0.5 * width * (1.0 + points)).ravel()
    weight = (0.5 * width * weights).ravel()
    linear = float(shear_stress(np.array([SMALLEST_STRAIN]))[0])
    return factor * (linear + float(weight @ (shear_stress(gamma) * gamma / np.expm1(gamma))))


def strain_rate(strain: Floats, *, exponent: int, growth_rate: float, expansion: float) -> Floats:
    """Shear strain rate [1/s] of points that have the shear strain gamma, shape [n].

    The growth rate is (da/dt)/a [1/s]; the expansion is a/a0, > 1, infinite for the limit.
    """
    rate: Floats = exponent * growth_rate * np.expm1(-strain) / (expansion ** -float(exponent) - 1)
    return rate


@dataclass(frozen=True, kw_only=True)
class ExactCavity:
    """The exact pressures of a cavity."""

    clay: UndrainedClay
    rigidity_index: float  # G/su of the clay
    wall: MovingWall  # motion of the wall in the time of the run
    exponent: int  # m, 2 for the cylinder and 3 for the sphere
    strength_share: float  # tau at yield over the strength: 1, less for von Mises around a sphere

    def pressure(self, expansion: Floats) -> Floats:
        """Excess pressure in the cavity over su at expansions a/a0, both of shape [n]."""
        if self._changes:
            strains = self.exponent * np.log(expansion)
            return self._radial_stress(strains, expansion) / self.clay.strength
        index = self._index
        strain = 1.0 - expansion ** -float(self.exponent)
        yielding = -math.expm1(-1.0 / index)
        elastic = index * scipy.special.spence(1.0 - np.minimum(strain, yielding))
        pressure: Floats = elastic + np.log(np.maximum(strain / yielding, 1.0))
        return self.factor * self.strength_share * pressure

    def pore_pressure(self, distance: Floats, *, expansion: float) -> Floats:
        """Excess pore pressure [Pa] at distances r/a from the centre, at the expansion a/a0 > 1.

        The radial stress at r is the pressure of a cavity that has expanded from r0 to r, where
        r^m - r0^m is the same at all points. The mean stress is lower by k tau. So in the plastic
        zone around a far expanded cavity in perfectly plastic clay,
        (p - p0)/su = k (ln Ir - m ln(r/a)).
        """
        m = self.exponent
        if self._changes:
            rest = distance**m - 1.0 + expansion ** -float(m)
            strains = np.log(distance**m / rest)
            radial = self._radial_stress(strains, np.full_like(strains, expansion))
            return radial - self.factor * self._shear_stress(strains, expansion)
        local = distance / (distance**m - 1.0 + expansion**-m) ** (1.0 / m)
        shear = np.minimum(self._index * m * np.log(local), 1.0)
        pressure: Floats = self.pressure(local) - self.factor * self.strength_share * shear
        return self.clay.strength * pressure

    def limit(self, expansion: float) -> float:
        """Excess limit pressure over su; where the strength changes, that at the expansion."""
        if self._changes:
            return float(self.pressure(np.array([expansion]))[0])
        return self.factor * self.strength_share * (1.0 + math.log(self._index))

    @property
    def _changes(self) -> bool:
        """Whether strain or its rate changes the strength of the clay."""
        return isinstance(self.clay, EinavRandolph)

    @property
    def factor(self) -> float:
        """k: 1 for the cylinder, 4/3 for the sphere."""
        return 2.0 * (self.exponent - 1) / self.exponent

    @property
    def _index(self) -> float:
        """G over tau at yield."""
        return self.rigidity_index / self.strength_share

    def _radial_stress(self, strain: Floats, expansion: Floats) -> Floats:
        """Excess radial stress at pairs of strain and expansion [Pa], shape [n]."""
        pairs = zip(strain.tolist(), expansion.tolist(), strict=True)
        laws = ((own, partial(self._shear_stress, expansion=at)) for own, at in pairs)
        return np.array([cavity_pressure(law, strain=own, factor=self.factor) for own, law in laws])

    def _shear_stress(self, strain: Floats, expansion: float) -> Floats:
        """Shear stress tau [Pa] at shear strains [n] around a cavity of the expansion a/a0."""
        # The speed of the wall rises with the square root of its travel (MovingWall).
        travel = (expansion - 1.0) * RADIUS
        speed = self.wall.speed * min(1.0, math.sqrt(travel / self.wall.ramp_travel))
        growth_rate = speed / (expansion * RADIUS)
        rate = strain_rate(
            strain, exponent=self.exponent, growth_rate=growth_rate, expansion=expansion
        )
        share = self.strength_share
        return share * shear_stress(self.clay, strain / share, rate / share)
