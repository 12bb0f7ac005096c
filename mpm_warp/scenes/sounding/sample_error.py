"""What is known of the error of a sample of the resistance: a correction, and a half width of 95 %.

The resistance is corrected by the laws of a cone factor (`mpm_warp.scenes.cone.error_laws`), with
rigidity index and mean strength of the soil around the tip. These laws were measured in uniform,
perfectly plastic clay; where strain or its rate changes the strength nothing is known, nor while
the surface of the ground is in the window. Near a border they are taken as they are. The place of
the border is known to a cell: half of what a shift by one cell changes is a part of the half width.
"""

from __future__ import annotations

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.cone.error_laws import LARGEST_CELL, ErrorLaws
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING
from mpm_warp.scenes.cone.stated_error import POINTS
from mpm_warp.scenes.cone.window import smallness
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
    around = _strength_around(sounding, depth)
    laws = _laws(sounding, depth, around)
    factor = resistance / around
    cell = sounding.cell_size
    shift = _strength_around(sounding, depth + cell) - _strength_around(sounding, depth - cell)
    parts = laws.half_widths(factor) | {
        "points": POINTS * factor,
        "noise": SAMPLE_NOISE,
        "borders": 0.25 * factor * np.abs(shift) / around,
    }
    reasons = laws.why_none_holds(largest_cell=LARGEST_CELL)
    reasons["strain or its rate changes the strength"] = sounding.strength_changes
    if sounding.starts_at_surface:
        parts["surface"] = LEFT_BY_SURFACE * factor
        passed = sounding.surface_passed / sounding.cone_radius
        reasons["the surface is in the window"] = laws.way < passed
    not_known = np.zeros(depth.shape, dtype=bool)
    for holds in reasons.values():
        not_known |= holds
    half_width = around * np.sqrt(sum(np.square(it) for it in parts.values()))
    return np.where(not_known, 0.0, laws.correction), np.where(not_known, np.nan, half_width)


def _strength_around(sounding: SoundingTest, depth: Floats) -> Floats:
    """Mean strength of the soil around the tip at depths [m], [Pa], shape [n]."""
    return sounding.ground.mean_strength_around(depth, AROUND * sounding.cone_radius)


def _laws(sounding: SoundingTest, depth: Floats, strength: Floats) -> ErrorLaws:
    """The laws at the samples.

    Args:
        sounding: what was run.
        depth: of the tip [m], shape [n].
        strength: mean around the tip [Pa], shape [n].
    """
    ground, radius = sounding.ground, sounding.cone_radius
    return ErrorLaws(
        rigidity_index=ground.shear_modulus_at(depth) / ground.strength_at(depth),
        adhesion_factor=ground.adhesion_factor_at(depth, elsewhere=sounding.adhesion_factor),
        stress_anisotropy=ground.stress_anisotropy_at(depth, elsewhere=sounding.stress_anisotropy),
        poissons_ratio=sounding.poissons_ratio,
        inertia=sounding.dynamic_pressure / strength,
        cell_size=sounding.cell_size / radius,
        cell_growth=sounding.cell_growth,
        above=sounding.domain_above,
        below=sounding.domain_below,
        smallness=smallness(sounding, sounding.default_extents),
        way=SAMPLE_SPACING * (sounding.lead_count + np.arange(depth.size)),
    )
