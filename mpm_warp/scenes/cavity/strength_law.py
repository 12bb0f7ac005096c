"""Pressure of an expanding cavity in incompressible clay of any strength law: one integral.

No change of volume fixes the shear strain gamma = m ln(r/r0) of each point, r0 the place where it
was, a and a0 the radii of the cavity. With tau(gamma) half the difference of the stresses along and
across the radius, equilibrium gives

    p - p0 = k int_0^(m ln(a/a0)) tau(gamma) dgamma / (e^gamma - 1)

with m = 2, k = 1 for the cylinder and m = 3, k = 4/3 for the sphere. The strain rate at a point is
m (da/dt)/a (1 - e^-gamma) / (1 - (a0/a)^m).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from mpm_warp.grid.fitted import Floats

SMALLEST, LARGEST = 1e-9, 60.0
"""Strains between which the integral is worked out: tau rises linearly below, e^-60 is left."""
PANELS, POINTS = 4000, 3
"""Panels, even in the logarithm of the strain, and Gauss points in each: 3e-6 of tau where its
slope jumps, rounding elsewhere."""


def cavity_pressure(
    shear_stress: Callable[[Floats], Floats], *, strain: float, factor: float
) -> float:
    """Excess pressure p - p0 of a cavity, in the unit of the shear stress.

    Args:
        shear_stress: tau at shear strains, both of shape [n]; linear in the smallest ones.
        strain: gamma = m ln(a/a0) at the wall, > 1e-9; infinite for the limit.
        factor: k, 1 for the cylinder and 4/3 for the sphere.
    """
    ends = np.linspace(math.log(SMALLEST), math.log(min(strain, LARGEST)), PANELS + 1)
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    width = np.diff(ends)[:, None]
    gamma = np.exp(ends[:-1, None] + 0.5 * width * (1.0 + points)).ravel()
    weight = (0.5 * width * weights).ravel()
    linear = float(shear_stress(np.array([SMALLEST]))[0])
    return factor * (linear + float(weight @ (shear_stress(gamma) * gamma / np.expm1(gamma))))


def strain_rate(strain: Floats, *, exponent: int, growth_rate: float, expansion: float) -> Floats:
    """Shear strain rate around a cavity [1/s], at points of some shear strain, shape [n].

    Args:
        strain: m ln(r/r0) of the points, shape [n].
        exponent: m, 2 for the cylinder and 3 for the sphere.
        growth_rate: (da/dt)/a of the cavity [1/s].
        expansion: a/a0, > 1; infinite far from the start.
    """
    rate: Floats = exponent * growth_rate * np.expm1(-strain) / (expansion ** -float(exponent) - 1)
    return rate
