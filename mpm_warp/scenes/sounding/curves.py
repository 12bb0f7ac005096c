"""The curves of a sounding over the depth of the tip."""

from __future__ import annotations

import numpy as np
import xarray as xr

from mpm_warp.results import curves, labelled
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING, STEADY_SAMPLES
from mpm_warp.scenes.sounding.parameters import SoundingTest
from mpm_warp.scenes.sounding.sample_error import AROUND, sample_error


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
    simulated = given.penetration_resistance.values
    correction, half_width = sample_error(sounding, depth, simulated)
    net = simulated + correction * around
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
            _half_width_is(sounding),
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
    return own.merge(costs)


def _half_width_is(sounding: SoundingTest) -> str:
    """What the half width is, and where there is none."""
    described = "half width, 95 %, of a sample; not a number where the error is not known"
    if not sounding.starts_at_surface:
        return described
    passed = sounding.start_depth + sounding.surface_passed
    return f"{described}: the surface of the ground is in the window to a depth of {passed:.4g} m"


def last_factor(recorded: xr.Dataset) -> dict[str, xr.Variable]:
    """The cone factor at the end: a mean over two radii, in which the noise of samples is small.

    Args:
        recorded: what `sounding_curves` gives, of one depth or more.
    """
    count = min(STEADY_SAMPLES, recorded.sizes["depth"])
    last = recorded.isel(depth=slice(-count, None))
    half_width = last.net_resistance_uncertainty / last.strength
    greatest = float(half_width.max(skipna=False))  # one that is not known is the greatest
    described = f"mean over the last {count * SAMPLE_SPACING:g} radii"
    return labelled(
        role="headline",
        last_cone_factor=(
            float(last.cone_factor_at_tip.mean()),
            "1",
            "cone factor over strength at the tip, at the end",
            described,
        ),
    ) | labelled(
        role="uncertainty",
        last_cone_factor_uncertainty=(
            greatest,
            "1",
            "uncertainty of the cone factor at the end",
            "half width, 95 %: the greatest of its samples",
        ),
    )
