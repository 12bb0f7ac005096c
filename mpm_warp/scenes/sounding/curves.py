"""The curves of a sounding over the depth of the tip, and what is known of their error.

The resistance is corrected as a cone factor is (`mpm_warp.scenes.cone.known_error`), with rigidity
index and mean strength of the soil around the tip. Where these change, within two radii of a border
say, the laws of the error are taken from where the soil is uniform, and the place of the border is
known to a cell: half the difference that a shift by one cell makes is a part of the uncertainty.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import curves, labelled
from mpm_warp.scenes.cone import known_error as known
from mpm_warp.scenes.cone import stated_error as stated
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING, STEADY_SAMPLES
from mpm_warp.scenes.sounding.parameters import SoundingTest

AROUND = 2.0
"""Way above and below the tip over which strength is averaged, in cone radii."""
SAMPLE_NOISE = 0.07
"""Half width of the noise of one sample of a tenth of a radius, over strength: twice the standard
deviation that samples have in uniform clay, 0.032 at 3 cells per radius."""


def sounding_curves(
    sounding: SoundingTest, recorded: xr.Dataset, *, first: int, samples: range
) -> xr.Dataset:
    """Curves over depth, with the ground beside them.

    Args:
        sounding: what was run.
        recorded: over `penetration`, from the start of the run; it may have ended early.
        first: number of the first sample that is given.
        samples: numbers that the samples given have in the whole sounding.
    """
    given = recorded.isel(penetration=slice(first, None))
    count = given.sizes["penetration"]
    spacing = SAMPLE_SPACING * sounding.cone_radius
    depth = sounding.from_depth + (np.array(samples[:count]) + 0.5) * spacing
    ground = sounding.ground
    strength = ground.strength_at(depth)
    around = ground.mean_strength_around(depth, AROUND * sounding.cone_radius)
    vertical = ground.vertical_stress_at(depth)
    correction, half_width = error_over_strength(sounding, depth)
    net = given.penetration_resistance.values + correction * around
    own = curves(
        "depth",
        (depth, "m", "depth of the tip"),
        net_resistance=(
            net,
            "Pa",
            "net cone resistance",
            "qt - sigma_v0, as simulated and corrected for mesh, speed and window",
        ),
        net_resistance_uncertainty=(
            half_width,
            "Pa",
            "uncertainty of the net cone resistance",
            "half width, 95 %, of a sample; not a number where the error is not known",
        ),
        total_resistance=(
            net + vertical,
            "Pa",
            "cone resistance",
            "net, and sigma_v0",
        ),
        sleeve_friction=(
            given.sleeve_friction.values,
            "Pa",
            "sleeve friction",
            "mean shear stress on the sleeve of 150 cm2 when the tip is at the depth",
        ),
        excess_pore_pressure=(
            given.excess_pore_pressure_shoulder.values,
            "Pa",
            "excess pore pressure u2",
            "behind the shoulder when the tip is at the depth; its error is not known",
        ),
        cone_factor_at_tip=(net / strength, "1", "net resistance over strength at the tip"),
        cone_factor_around_tip=(
            net / around,
            "1",
            "net resistance over mean strength around the tip",
            f"from {AROUND:g} radii above the tip to {AROUND:g} below it",
        ),
        strength=(strength, "Pa", "undrained shear strength"),
        vertical_stress=(vertical, "Pa", "in-situ vertical total stress"),
        contact_share=(given.contact_share.values, "1", "share of cone and shaft in contact"),
    )
    costs = recorded.drop_dims("penetration")
    return own.merge(costs).assign(_last_factor(own))


def _last_factor(own: xr.Dataset) -> dict[str, xr.Variable]:
    """The cone factor at the end: a mean over two radii, in which the noise of samples is small."""
    count = min(STEADY_SAMPLES, own.sizes["depth"])
    last = own.isel(depth=slice(-count, None)) if count else own
    half_width = last.net_resistance_uncertainty / last.strength
    described = f"mean over the last {count * SAMPLE_SPACING:g} radii"
    return labelled(
        role="headline",
        last_cone_factor=(
            float(last.cone_factor_at_tip.mean()) if count else math.nan,
            "1",
            "cone factor over strength at the tip, at the end",
            described,
        ),
    ) | labelled(
        role="uncertainty",
        last_cone_factor_uncertainty=(
            float(half_width.max()) if count else math.nan,
            "1",
            "uncertainty of the cone factor at the end",
            "half width, 95 %: the greatest of its samples",
        ),
    )


def error_over_strength(sounding: SoundingTest, depth: Floats) -> tuple[Floats, Floats]:
    """Correction of the resistance over the mean strength around the tip, and half width [Pa].

    Args:
        sounding: what was run.
        depth: of the tip [m], shape [n].
    """
    ground, radius, cell = sounding.ground, sounding.cone_radius, sounding.cell_size
    strength = ground.strength_at(depth)
    around = ground.mean_strength_around(depth, AROUND * radius)
    index = ground.shear_modulus_at(depth) / strength
    h, g, below = cell / radius, sounding.cell_growth, sounding.domain_below
    assert below is not None
    mesh = np.array(
        [
            known.mesh_error(
                rigidity_index=one,
                adhesion_factor=sounding.adhesion_factor,
                cell_size=h,
                cell_growth=g,
            )
            for one in np.unique(index)
        ]
    )[np.unique(index, return_inverse=True)[1]]
    inertia = sounding.dynamic_pressure / around
    bottom = known.BOTTOM_ERROR * index / below**2
    correction = bottom - known.SPEED_ERROR * inertia - mesh
    factor = 4.0 / 3.0 * (1.0 + np.log(index)) + sounding.adhesion_factor / math.tan(
        math.radians(30.0)
    )
    shift = ground.mean_strength_around(depth + cell, AROUND * radius)
    shift = shift - ground.mean_strength_around(depth - cell, AROUND * radius)
    parts = [
        known.FACE * h * np.ones_like(depth),
        known.GROWTH * g**1.5 * h**1.3 + known.FORM_OF_GROWTH * np.ones_like(depth),
        known.DOMAIN * factor,
        known.BOTTOM * bottom,
        known.INERTIA * inertia,
        stated.POINTS * factor,
        SAMPLE_NOISE * np.ones_like(depth),
        0.25 * factor * np.abs(shift) / around,
    ]
    half_width = around * np.sqrt(np.sum(np.square(parts), axis=0))
    is_known = (
        (index >= known.RIGIDITY_INDICES[0])
        & (index <= known.RIGIDITY_INDICES[-1])
        & (inertia <= stated.LARGEST_INERTIA)
        & (h <= stated.LARGEST_CELL)
        & (sounding.poissons_ratio >= known.SMALLEST_POISSONS_RATIO)
    )
    return np.where(is_known, correction, 0.0), np.where(is_known, half_width, np.nan)
