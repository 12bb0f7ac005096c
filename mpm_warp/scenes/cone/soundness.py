"""When a cone factor counts as a result: energy kept, resistance level, size within bounds."""

from __future__ import annotations

import math

import xarray as xr

from mpm_warp.errors import InaccurateRun, UnfinishedRun
from mpm_warp.results import variable

LARGEST_ENERGY_ERROR = 0.05
"""Share of the penetrometer's work that the method itself may create or dissipate."""
LARGEST_VARIATION = 0.05
"""Range of the resistance over its last two radii, over its mean, of a run that is not steady.

Runs that end steady have 0.5 to 2 %, one of 6 radii 4.5 %, one of 2 radii 30 % or more.
"""
LARGEST_OVER_CAVITY = 2.0
"""What a cone factor may be over the estimate from cavity expansion; sound ones reach 1.6."""


def energy_error(share: float) -> xr.Variable:
    """The energy error of a run as a variable of its results.

    Args:
        share: kinetic energy that the transfers created, over the work of the penetrometer.
    """
    return variable(
        share,
        unit="1",
        meaning="energy error",
        description="kinetic energy that the transfers between material points and grid "
        "created, dissipated if < 0, over the work of the penetrometer",
        limit=LARGEST_ENERGY_ERROR,
    )


def check_energy(results: xr.Dataset) -> None:
    """Refuse results of a run whose transfers took too much of the penetrometer's work.

    Raises:
        InaccurateRun: they took more than `LARGEST_ENERGY_ERROR`.
    """
    share = float(results.energy_error)
    if not abs(share) <= LARGEST_ENERGY_ERROR:
        raise InaccurateRun(
            f"the transfers between material points and grid took {-share:.1%} of the "
            f"penetrometer's work, more than {LARGEST_ENERGY_ERROR:.0%}: try a lower "
            "speed_ratio, more cells_per_radius or a longer penetration",
            results,
        )


def check_levelled(results: xr.Dataset) -> None:
    """Refuse results of a run that was to become steady, did not, and still changes.

    Raises:
        UnfinishedRun: the resistance changes by more than `LARGEST_VARIATION` at the end.
    """
    variation = float(results.cone_factor_variation)
    if not variation <= LARGEST_VARIATION:
        raise UnfinishedRun(
            f"the resistance still changes by {variation:.0%} at the greatest penetration, "
            f"{float(results.penetration_reached):g} radii; try more penetration, or "
            "steady_tolerance = 0 where no steady resistance is wanted",
            results,
        )


def cone_factor_estimate(
    *, rigidity_index: float, strength_ratio: float, face_shear: float, apex_angle: float
) -> float:
    """Limit pressure of a spherical cavity and shear on the face, over su, as a cone factor.

    4/3 k (1 + ln(Ir / k)) + a cot(apex angle / 2), with k the strength in compression along one
    axis over 2 su, and a the shear stress on the face over su.

    Args:
        rigidity_index: G/su.
        strength_ratio: k; 1 for soil of Tresca.
        face_shear: a; with friction 1, for soil bears no more shear than su.
        apex_angle: full angle of the cone [rad].
    """
    cavity = 4.0 / 3.0 * strength_ratio * (1.0 + math.log(rigidity_index / strength_ratio))
    return cavity + face_shear / math.tan(0.5 * apex_angle)


def check_bound(
    results: xr.Dataset,
    *,
    rigidity_index: float,
    strength_ratio: float,
    face_shear: float,
    apex_angle: float,
) -> None:
    """Refuse a cone factor that is far above all that soil can give; see `cone_factor_estimate`.

    Raises:
        InaccurateRun: it is more than `LARGEST_OVER_CAVITY` times the estimate.
    """
    estimate = cone_factor_estimate(
        rigidity_index=rigidity_index,
        strength_ratio=strength_ratio,
        face_shear=face_shear,
        apex_angle=apex_angle,
    )
    factor, bound = float(results.cone_factor), LARGEST_OVER_CAVITY * estimate
    if factor > bound:
        raise InaccurateRun(
            f"the cone factor {factor:.3g} is above {bound:.3g}, twice what cavity expansion and "
            "the face can give: try a lower speed_ratio, or more cells_per_radius",
            results,
        )
