"""What is known of the error of a sample of the resistance: a correction, and a half width of 95 %.

The resistance is corrected as a cone factor is (`mpm_warp.scenes.cone.known_error`), with rigidity
index and mean strength of the soil around the tip. These laws were measured in uniform, perfectly
plastic clay; where strain or its rate changes the strength nothing is known, nor while the surface
of the ground is in the window. Near a border they are taken as they are. The place of the border is
known to a cell: half of what a shift by one cell changes is a part of the half width.
"""

from __future__ import annotations

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.cone import known_error as known
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING
from mpm_warp.scenes.cone.stated_error import (
    LARGEST_CELL,
    LARGEST_INERTIA,
    POINTS,
)
from mpm_warp.scenes.sounding.parameters import SoundingTest

AROUND = 2.0
"""Way above and below the tip over which strength is averaged, in cone radii."""
SAMPLE_NOISE = 0.07
"""Half width of the noise of one sample of a tenth of a radius, over strength: twice the standard
deviation that samples have in uniform clay, 0.032 at 3 cells per radius."""
LEFT_BY_SURFACE = 0.026
"""Half width of what the surface leaves when it is out of the window, over the resistance: twice
what a window of twice the extents changes, 0.6 % smooth and 1.3 % rough, at 20 to 28 radii."""


def sample_error(
    sounding: SoundingTest, depth: Floats, resistance: Floats
) -> tuple[Floats, Floats]:
    """What is known of the error of the samples of a resistance.

    Args:
        sounding: what was run.
        depth: of the tip [m], shape [n].
        resistance: net, as simulated [Pa], shape [n].

    Returns:
        What is to be added to the resistance, over the mean strength around the tip, dimensionless,
        0 where nothing is known; and the half width of 95 % [Pa], NaN there. Each of shape [n].
    """
    ground, radius, cell = sounding.ground, sounding.cone_radius, sounding.cell_size
    strength = ground.strength_at(depth)
    around = ground.mean_strength_around(depth, AROUND * radius)
    index = ground.shear_modulus_at(depth) / strength
    h, g, below = cell / radius, sounding.cell_growth, sounding.domain_below
    above = sounding.domain_above
    assert above is not None
    assert below is not None
    adhesion = ground.adhesion_factor_at(depth, elsewhere=sounding.adhesion_factor)
    soils, of_soil = np.unique(np.stack([index, adhesion]), axis=1, return_inverse=True)
    mesh = np.array(
        [
            known.mesh_error(rigidity_index=Ir, adhesion_factor=a, cell_size=h, cell_growth=g)
            for Ir, a in soils.T
        ]
    )[of_soil.ravel()]
    anisotropy = ground.stress_anisotropy_at(depth, elsewhere=sounding.stress_anisotropy)
    inertia = sounding.dynamic_pressure / around
    bottom = known.BOTTOM_ERROR * index / below**2
    way = SAMPLE_SPACING * (sounding.lead_count + np.arange(depth.size))
    top = known.top_error(rigidity_index=index, above=above, below=below, way=way)
    correction = bottom - known.SPEED_ERROR * inertia - mesh - top
    factor = resistance / around
    shift = ground.mean_strength_around(depth + cell, AROUND * radius)
    shift = shift - ground.mean_strength_around(depth - cell, AROUND * radius)
    parts = [
        known.FACE * h * np.ones_like(depth),
        known.growth_uncertainty(h, g) * np.ones_like(depth),
        known.DOMAIN * factor,
        known.BOTTOM * bottom,
        known.INERTIA * inertia,
        POINTS * factor,
        known.TOP * top,
        SAMPLE_NOISE * np.ones_like(depth),
        0.25 * factor * np.abs(shift) / around,
    ]
    if sounding.starts_at_surface:
        parts.append(LEFT_BY_SURFACE * factor)
    half_width = around * np.sqrt(np.sum(np.square(parts), axis=0))
    is_known = (
        (index >= known.RIGIDITY_INDICES[0])
        & (index <= known.RIGIDITY_INDICES[-1])
        & (inertia <= LARGEST_INERTIA)
        & (np.abs(anisotropy) <= known.LARGEST_ANISOTROPY)
        & (h <= LARGEST_CELL)
        & (sounding.poissons_ratio >= known.SMALLEST_POISSONS_RATIO)
        & (not sounding.strength_changes)
    )
    if sounding.starts_at_surface:
        is_known &= way >= sounding.surface_passed / radius
    return np.where(is_known, correction, 0.0), np.where(is_known, half_width, np.nan)
