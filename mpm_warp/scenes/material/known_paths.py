"""Exact stress of clay that is sheared in one direction, and strain paths on which it is known.

Symbols: gamma shear strain, its elastic part tau / G; xi its plastic part; k strength.

    tau = min(G gamma, k(xi)),   xi = gamma - tau / G
"""

import functools
import math
from dataclasses import dataclass

import numpy as np
import scipy  # loads its integrators where they are first used: no other scene waits for them

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.materials.tresca import Tresca

PATH_COUNT = 12
SHEAR_STRAIN = 10.0
"""Of the path of simple shear."""
ELASTIC, YIELDING = 0.5, 5.0
"""Strains of paths over su/G."""
NEWTON_STEPS = 8
"""More than it takes: the strength falls by less than half as steeply as the stress rises."""
RELATIVE_ERROR, ABSOLUTE_ERROR = 1e-11, 1e-13
"""Of integrations."""


@dataclass(frozen=True, kw_only=True)
class StrainPath:
    """A constant velocity gradient over a unit of time, and what the stress is at its end."""

    name: str  # what the point goes through
    gradient: tuple[float, ...]  # velocity gradient (rr, rz, zr, zz, tt) [1/s]
    start: tuple[float, ...]  # stress (rr, zz, rz, tt) at the start, over the strength
    exact: tuple[float, ...]  # stress at the end, over the strength


@functools.cache
def known_paths(clay: UndrainedClay) -> tuple[StrainPath, ...]:
    """Paths of a second each: proportional, turned back, turned, and in simple shear."""
    yield_strain = clay.strength / clay.shear_modulus
    small, large = ELASTIC * yield_strain, YIELDING * yield_strain
    proportional = {
        "uniaxial strain, elastic": (0, 0, 0, small, 0),
        "uniaxial strain, yielding at a corner": (0, 0, 0, -large, 0),
        "shear, elastic": (0, small, small, 0, 0),
        "pure shear, on an edge": (large, 0, 0, -large, 0),
        "hoop stress greatest": (-large, 0, 0, 0, large),
        "hoop stress least": (0, 0, 0, large, -large),
        "axial extension, at a corner": (-large, 0, 0, 2 * large, -large),
        "hoop compression, at a corner": (large, 0, 0, large, -2 * large),
    }
    back = (large, 0, 0, -large, 0)
    half, full = 0.25 * math.pi, 2 * math.pi
    rest, held = (0.0, 0.0, 0.0, 0.0), (0.9, 0.1, 0.3, 0.4)
    # After a turn by 45 degrees from r towards z, rr' = mean - rz, zz' = mean + rz.
    at_half = (0.5 - 0.3, 0.5 + 0.3, 0.5 * (0.9 - 0.1), 0.4)
    along, across = (
        stress / clay.strength for stress in simple_shear(clay, SHEAR_STRAIN, SHEAR_STRAIN)
    )
    parts = (
        *((name, value, rest, _proportional(clay, value)) for name, value in proportional.items()),
        # The strain that takes the stress back to nothing leaves the clay intact.
        ("pure shear, turned back", back, (-1, 1, 0, 0), _proportional(clay, back, yield_strain)),
        ("turn by 45 degrees", (0, -half, half, 0, 0), held, at_half),
        ("turn by 360 degrees", (0, -full, full, 0, 0), held, held),
        ("simple shear to strain 10", (0, SHEAR_STRAIN, 0, 0, 0), rest, (along, -along, across, 0)),
    )
    return tuple(
        StrainPath(name=name, gradient=gradient, start=start, exact=exact)
        for name, gradient, start, exact in parts
    )


def _proportional(
    clay: UndrainedClay, gradient: tuple[float, ...], turned_back: float = 0.0
) -> tuple[float, ...]:
    """Stress over strength at the end of a second of strain without spin.

    The deviator of the stress is along that of the strain: at a corner of the hexagon, in the
    middle of a side, or anywhere on the cylinder of von Mises. `turned_back` is the shear strain
    that takes the stress at the start back to nothing.
    """
    rr, rz, zr, zz, tt = gradient
    volume = rr + zz + tt
    strain = np.array([rr, zz, 0.5 * (rz + zr), tt])
    deviator = strain - volume / 3.0 * np.array([1.0, 1.0, 0.0, 1.0])
    measure = _measure(clay, deviator)
    shear_strain = np.array([2.0 * measure])
    (shear,) = shear_stress(clay, shear_strain - turned_back, shear_strain)
    mean = clay.bulk_modulus * volume * np.array([1.0, 1.0, 0.0, 1.0])
    return tuple(((mean + shear * deviator / measure) / clay.strength).tolist())


def _measure(clay: UndrainedClay, deviator: Floats) -> float:
    """What the yield criterion measures of a deviator (rr, zz, rz, tt)."""
    rr, zz, rz, tt = deviator
    criterion = clay.criterion if isinstance(clay, EinavRandolph) else type(clay)
    if criterion is Tresca:
        radius = math.hypot(0.5 * (rr - zz), rz)
        principal = (0.5 * (rr + zz) + radius, 0.5 * (rr + zz) - radius, tt)
        return 0.5 * float(max(principal) - min(principal))
    return math.sqrt(0.5 * (rr * rr + zz * zz + tt * tt) + rz * rz)


def strength(clay: UndrainedClay, plastic_strain: Floats, rate: Floats) -> tuple[Floats, Floats]:
    """Shear strength k [Pa] and its slope dk/dxi [Pa], at plastic shear strains and rates [1/s]."""
    shape = np.zeros(np.broadcast(plastic_strain, rate).shape)
    if not isinstance(clay, EinavRandolph):
        return clay.strength + shape, shape
    cycles = np.log10(np.maximum(rate / clay.reference_strain_rate, 1.0))
    intact = clay.strength * (1.0 + clay.rate_factor * cycles)
    fall, remoulded = 3.0 / clay.ductility, clay.remoulded_strength_ratio * intact
    lost = (intact - remoulded) * np.exp(-fall * plastic_strain)
    return remoulded + lost + shape, -fall * lost + shape


def shear_stress(clay: UndrainedClay, strain: Floats, rate: Floats) -> Floats:
    """Shear stress at the end of proportional shear [Pa], by strain gamma, and rate there [1/s]."""
    stiffness = clay.shear_modulus
    plastic = np.maximum(strain - strength(clay, 0.0 * strain, rate)[0] / stiffness, 0.0)
    for _ in range(NEWTON_STEPS):
        k, slope = strength(clay, plastic, rate)
        missing = stiffness * (strain - plastic) - k
        plastic = np.maximum(plastic + missing / (stiffness + slope), 0.0)
    return np.minimum(stiffness * strain, strength(clay, plastic, rate)[0])


def simple_shear(clay: UndrainedClay, strain: float, rate: float) -> tuple[float, float]:
    """Stress at the end of simple shear, which the spin turns as the strain makes it (Jaumann).

    With tau the half diameter of the circle of stress and phi its turn,

        dtau/dgamma = G cos(phi) - G dxi/dgamma,   dphi/dgamma = 1 - G sin(phi) / tau

    so that tau = 2 G sin(gamma / 2), phi = gamma / 2 until it yields, and tau = k(xi) from then on.
    With perfect plasticity phi comes to rest at asin(k / G). The strain is far beyond that of
    yield, its rate in 1/s.

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
