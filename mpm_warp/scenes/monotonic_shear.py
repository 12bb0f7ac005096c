"""Exact stress of clay that is sheared in one direction, whatever its strength law.

Symbols: gamma shear strain, its elastic part tau / G; xi its plastic part; k strength.

    tau = min(G gamma, k(xi)),   xi = gamma - tau / G
"""

from __future__ import annotations

import math

import numpy as np
import scipy  # loads its integrators where they are first used: no other scene waits for them

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.perfectly_plastic import UndrainedClay

NEWTON_STEPS = 8
"""More than it takes: the strength falls by less than half as steeply as the stress rises."""
RELATIVE_ERROR, ABSOLUTE_ERROR = 1e-11, 1e-13
"""Of integrations."""


def strength(clay: UndrainedClay, plastic_strain: Floats, rate: Floats) -> tuple[Floats, Floats]:
    """Shear strength k [Pa], and its slope dk/dxi [Pa].

    Args:
        clay: the clay.
        plastic_strain: plastic shear strain xi, of any shape.
        rate: shear strain rate [1/s], of the same shape.
    """
    shape = np.zeros(np.broadcast(plastic_strain, rate).shape)
    if not isinstance(clay, EinavRandolph):
        return clay.strength + shape, shape
    cycles = np.log10(np.maximum(rate / clay.reference_strain_rate, 1.0))
    intact = clay.strength * (1.0 + clay.rate_factor * cycles)
    fall, remoulded = 3.0 / clay.ductility, clay.remoulded_strength_ratio * intact
    lost = (intact - remoulded) * np.exp(-fall * plastic_strain)
    return remoulded + lost + shape, -fall * lost + shape


def shear_stress(clay: UndrainedClay, strain: Floats, rate: Floats) -> Floats:
    """Shear stress at the end of proportional shear [Pa].

    Args:
        clay: the clay.
        strain: shear strain gamma, >= 0, of any shape.
        rate: its rate at the end [1/s], of the same shape.
    """
    stiffness = clay.shear_modulus
    plastic = np.maximum(strain - strength(clay, 0.0 * strain, rate)[0] / stiffness, 0.0)
    for _ in range(NEWTON_STEPS):
        k, slope = strength(clay, plastic, rate)
        missing = stiffness * (strain - plastic) - k
        plastic = np.maximum(plastic + missing / (stiffness + slope), 0.0)
    stress: Floats = np.minimum(stiffness * strain, strength(clay, plastic, rate)[0])
    return stress


def simple_shear(clay: UndrainedClay, strain: float, rate: float) -> tuple[float, float]:
    """Stress at the end of simple shear, which the spin turns as the strain makes it (Jaumann).

    With tau the half diameter of the circle of stress and phi its turn,

        dtau/dgamma = G cos(phi) - G dxi/dgamma,   dphi/dgamma = 1 - G sin(phi) / tau

    so that tau = 2 G sin(gamma / 2), phi = gamma / 2 until it yields, and tau = k(xi) from then on.
    With perfect plasticity phi comes to rest at asin(k / G).

    Args:
        clay: the clay.
        strain: shear strain, far beyond that of yield.
        rate: its rate [1/s].

    Returns:
        Half difference of the normal stresses, and shear stress [Pa].
    """
    stiffness = clay.shear_modulus
    if not isinstance(clay, EinavRandolph):
        phi = math.asin(clay.strength / stiffness)
        return clay.strength * math.sin(phi), clay.strength * math.cos(phi)

    def law(plastic: float) -> tuple[float, float]:
        k, slope = strength(clay, np.array(plastic), np.array(rate))
        return float(k), float(slope)

    def change(_gamma: float, state: Floats) -> list[float]:
        (k, slope), phi = law(state[0]), state[1]
        return [
            stiffness * math.cos(phi) / (stiffness + slope),
            1.0 - stiffness * math.sin(phi) / k,
        ]

    yielding = 2.0 * math.asin(min(1.0, 0.5 * law(0.0)[0] / stiffness))
    path = scipy.integrate.solve_ivp(
        change,
        (yielding, strain),
        [0.0, 0.5 * yielding],
        method="Radau",
        rtol=RELATIVE_ERROR,
        atol=ABSOLUTE_ERROR,
    )
    plastic, phi = path.y[:, -1]
    tau = law(plastic)[0]
    return tau * math.sin(phi), tau * math.cos(phi)
