"""Exact pressures around a cavity that expands in incompressible clay of any strength law.

No change of volume fixes the shear strain gamma = m ln(r/r0) of each point, r0 the place where it
was, a and a0 the radii of the cavity. With tau(gamma) half the difference of the stresses along and
across the radius, equilibrium gives

    p - p0 = k int_0^(m ln(a/a0)) tau(gamma) dgamma / (e^gamma - 1)

with m = 2, k = 1 for the cylinder and m = 3, k = 4/3 for the sphere. The strain rate at a point is
m (da/dt)/a (1 - e^-gamma) / (1 - (a0/a)^m). In perfectly plastic clay of strength su, with
e = 1 - (a0/a)^m, x = 1 - exp(-1/Ir) and Li2 the dilogarithm,

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
"""Of the cavity at the start [m]."""
SMALLEST, LARGEST = 1e-9, 60.0
"""Strains between which the integral is worked out: tau rises linearly below, e^-60 is left."""
PANELS, POINTS = 4000, 3
"""Panels, even in the logarithm of the strain, and Gauss points in each: 3e-6 of tau where its
slope jumps, rounding elsewhere."""


def cavity_pressure(
    shear_stress: Callable[[Floats], Floats], *, strain: float, factor: float
) -> float:
    """Excess pressure p - p0 of a cavity, in the unit of the shear stress tau at strains, [n].

    The strain at the wall is m ln(a/a0), > 1e-9, infinite for the limit; the factor is k.
    """
    ends = np.linspace(math.log(SMALLEST), math.log(min(strain, LARGEST)), PANELS + 1)
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    width = np.diff(ends)[:, None]
    gamma = np.exp(ends[:-1, None] + 0.5 * width * (1.0 + points)).ravel()
    weight = (0.5 * width * weights).ravel()
    linear = float(shear_stress(np.array([SMALLEST]))[0])
    return factor * (linear + float(weight @ (shear_stress(gamma) * gamma / np.expm1(gamma))))


def strain_rate(strain: Floats, *, exponent: int, growth_rate: float, expansion: float) -> Floats:
    """Shear strain rate around a cavity [1/s], at points of the shear strain m ln(r/r0), [n].

    The growth rate is (da/dt)/a [1/s], the expansion a/a0, > 1, infinite far from the start.
    """
    rate: Floats = exponent * growth_rate * np.expm1(-strain) / (expansion ** -float(exponent) - 1)
    return rate


@dataclass(frozen=True, kw_only=True)
class ExactCavity:
    """The exact pressures of a cavity."""

    clay: UndrainedClay  # the clay
    rigidity_index: float  # G/su of the clay
    wall: MovingWall  # how the wall moves, in the time of the run
    exponent: int  # m, 2 for the cylinder and 3 for the sphere
    # half the difference of the stresses along and across the wall at yield, over the strength: 1
    # but for von Mises around a sphere
    strength_share: float

    def pressure(self, expansion: Floats) -> Floats:
        """Excess pressure in the cavity over su at radii over the initial one, both [n]."""
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
        """Excess pore pressure at distances over the radius a of the cavity [Pa], shape [n].

        Soil at a distance r that was at r0 bears the radial stress of a cavity that has expanded
        from r0 to r; r^m - r0^m is the same everywhere. The mean stress is less than that by k
        times the shear stress. So in the plastic zone around a cavity that has expanded far in
        perfectly plastic clay, (p - p0)/su = k (ln Ir - m ln(r/a)). The expansion is a/a0, > 1.
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
        """Excess pressure over su that none exceeds; at the end where the strength changes."""
        if self._changes:
            return float(self.pressure(np.array([expansion]))[0])
        return self.factor * self.strength_share * (1.0 + math.log(self._index))

    @property
    def _changes(self) -> bool:
        """Whether strain or its rate changes the strength of the clay."""
        return isinstance(self.clay, EinavRandolph)

    @property
    def factor(self) -> float:
        """The factor k of the pressure: 1 for the cylinder, 4/3 for the sphere."""
        return 2.0 * (self.exponent - 1) / self.exponent

    @property
    def _index(self) -> float:
        """G over half the difference of the stresses at yield."""
        return self.rigidity_index / self.strength_share

    def _radial_stress(self, strain: Floats, expansion: Floats) -> Floats:
        """Excess of the radial stress at shear strains, each of an expansion [Pa], shape [n]."""
        pairs = zip(strain.tolist(), expansion.tolist(), strict=True)
        laws = ((own, partial(self._shear_stress, expansion=at)) for own, at in pairs)
        return np.array([cavity_pressure(law, strain=own, factor=self.factor) for own, law in laws])

    def _shear_stress(self, strain: Floats, expansion: float) -> Floats:
        """Half the difference of the stresses along and across the radius [Pa], shape [n]."""
        # The speed of the wall rises with the root of its travel (MovingWall).
        travel = (expansion - 1.0) * RADIUS
        speed = self.wall.speed * min(1.0, math.sqrt(travel / self.wall.ramp_travel))
        growth_rate = speed / (expansion * RADIUS)
        rate = strain_rate(
            strain, exponent=self.exponent, growth_rate=growth_rate, expansion=expansion
        )
        share = self.strength_share
        return share * shear_stress(self.clay, strain / share, rate / share)
