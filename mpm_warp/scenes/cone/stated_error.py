"""The cone factor with its uncertainty as a run states them, whichever way its error is known."""

from __future__ import annotations

import math
from collections.abc import Mapping

import xarray as xr

from mpm_warp.results import labelled
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.scenes.cone.penetration import STEADY_SAMPLES
from mpm_warp.scenes.cone.window import ALL_PASSED
from mpm_warp.scenes.stated_value import stated_value

STILL_TO_GO = 1.5
"""Half width of what is to come, over the last change of the mean."""
POINTS, NOISE = 0.001, 0.015
"""Half widths: of what more points change, over Nc; of the noise of a run."""
APPROACH = 0.001
"""Half width of what the approach leaves, over Nc."""


def stated_error(
    test: ConeTest,
    recorded: xr.Dataset,
    *,
    correction: float,
    parts: Mapping[str, float],
    not_known: str,
) -> xr.Dataset:
    """The cone factor less what is known of its error, and its uncertainty.

    Args:
        test: the cone penetration test.
        recorded: `cone_factor_simulated`, `cone_factor_shear` and `penetration_reached`.
        correction: what is to be added to the cone factor as simulated.
        parts: half widths of 95 % by what they are of; their squares add up.
        not_known: why nothing is known of the error, as a phrase; "" where it is known.

    Returns:
        `cone_factor`, its normal part and its correction; `cone_factor_uncertainty` and its parts.
        Where nothing is known of the error there is no correction, the uncertainty is not a number,
        and its attribute `not_known` says why.
    """
    stated = stated_value(
        "cone_factor",
        float(recorded.cone_factor_simulated),
        correction=correction,
        parts=parts,
        not_known=not_known,
        description="Nc = (qc - sigma_v0) / su, as simulated and corrected for mesh, speed and "
        "window",
    )
    settled = labelled(
        role="settled",
        cone_factor_settled=(
            float(_all_is_passed(test, recorded)),
            "1",
            "whether the cone factor has settled",
            "1 where the cone has passed all soil beside the shaft, else 0",
        ),
    )
    normal = labelled(
        cone_factor_normal=(
            float(stated["cone_factor"].values) - float(recorded.cone_factor_shear),
            "1",
            "cone factor, normal part",
            "what the normal traction on the face adds to Nc",
        ),
    )
    return xr.Dataset(stated | settled | normal)


def parts_of_a_run(test: ConeTest, recorded: xr.Dataset) -> dict[str, float]:
    """Half widths of what a run leaves open whatever its mesh, speed and window.

    Args:
        test: the cone penetration test.
        recorded: the curve `penetration_resistance`, and `cone_factor_simulated`.
    """
    resistance = recorded.penetration_resistance.values / test.undrained_shear_strength
    before, last = (
        resistance[begin:end].mean() if resistance.size >= 2 * STEADY_SAMPLES else math.nan
        for begin, end in ((-2 * STEADY_SAMPLES, -STEADY_SAMPLES), (-STEADY_SAMPLES, None))
    )
    return {
        "steadiness": STILL_TO_GO * abs(float(last - before)),
        "points": POINTS * float(recorded.cone_factor_simulated),
        "noise": NOISE,
    }


def why_not_settled(test: ConeTest, recorded: xr.Dataset) -> dict[str, bool]:
    """A phrase on what keeps the error of a run from being known, and whether it does.

    Args:
        test: the cone penetration test.
        recorded: `penetration_reached`.
    """
    return {
        "soil that the cone has not passed is still beside it": not _all_is_passed(test, recorded)
    }


def inertia(test: ConeTest) -> float:
    """Rho V^2 / su, dimensionless: what the speed adds to the cone factor is in proportion to it.

    That is Ir (V / c_s)^2, with c_s the speed of shear waves.
    """
    return test.rigidity_index * test.speed_ratio * test.speed_ratio


def _all_is_passed(test: ConeTest, recorded: xr.Dataset) -> bool:
    """Whether the cone has passed all soil beside the shaft."""
    return float(recorded.penetration_reached) >= test.domain_above + ALL_PASSED
