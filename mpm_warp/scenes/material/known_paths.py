"""Strain paths on which the stress of a clay is known exactly, whatever its strength law."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.materials.tresca import Tresca
from mpm_warp.scenes.monotonic_shear import shear_stress, simple_shear

PATH_COUNT = 12
SHEAR_STRAIN = 10.0
"""Of the path of simple shear."""
ELASTIC, YIELDING = 0.5, 5.0
"""Strains of paths over su/G."""


@dataclass(frozen=True, kw_only=True)
class StrainPath:
    """A constant velocity gradient over a unit of time, and what the stress is at its end.

    Attributes:
        name: what the point goes through.
        gradient: velocity gradient (rr, rz, zr, zz, tt) [1/s].
        start: stress (rr, zz, rz, tt) at the start, over the strength.
        exact: stress at the end, over the strength.
    """

    name: str
    gradient: tuple[float, ...]
    start: tuple[float, ...]
    exact: tuple[float, ...]


@functools.cache
def known_paths(clay: UndrainedClay) -> tuple[StrainPath, ...]:
    """Paths of a second each: proportional, turned back, turned, and in simple shear.

    Args:
        clay: of the point.
    """
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
    along, across = (it / clay.strength for it in simple_shear(clay, SHEAR_STRAIN, SHEAR_STRAIN))
    parts = (
        *((name, it, rest, _proportional(clay, it)) for name, it in proportional.items()),
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
    middle of a side, or anywhere on the cylinder of von Mises.

    Args:
        clay: of the point.
        gradient: velocity gradient (rr, rz, zr, zz, tt) [1/s].
        turned_back: shear strain that takes the stress at the start back to nothing.
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
