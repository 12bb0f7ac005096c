"""What is known of the error of a cone factor: a correction, and a half width of 95 %.

Of the mesh, h the width of the cells at the cone over its radius, g their growth:

    E_mesh = B h + C g^1.5 h^1.3          B by rigidity index and adhesion factor, a table

and of the speed, by the inertia i = rho V^2 / su = Ir (V / c_s)^2, c_s the speed of shear waves:

    E_speed = S i

and of the bottom of the window, H its distance from the tip over the cone's radius:

    E_bottom = -D Ir / H^2

All are taken from the cone factor. What they leave, and what only repetition tells, makes up the
half width: its parts are added as squares. How all of it was measured is in the README.md of this
folder; `studies/mesh_error.toml` measures B, `studies/held_out.toml` tests the half width.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from mpm_warp.results import labelled, variable
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.scenes.cone.penetration import STEADY_SAMPLES

RIGIDITY_INDICES = (20.0, 50.0, 100.0, 300.0, 1000.0)
"""Where the error of the mesh was measured."""
FACE_ERRORS = ((-0.66, -0.38, -0.43, -0.08, 0.18), (-0.36, -0.32, -0.28, -0.03, 0.15))
"""B at these rigidity indices, of a smooth cone and of one with adhesion factor 1."""
GROWTH_ERROR = 1.2
"""C."""
SPEED_ERROR = 0.07
"""S."""
BOTTOM_ERROR = 0.09
"""D."""
FACE, GROWTH, FORM_OF_GROWTH, DOMAIN = 0.12, 0.3, 0.02, 0.004
"""Half widths: of B; of C; of the form of its law; of what a default window changes, over Nc."""
BOTTOM = 0.3
"""Half width of the effect of the bottom, over it."""
NEAREST_BOTTOM = 0.9
"""Distance of the bottom over sqrt(Ir) from which on its effect is known."""
STILL_TO_GO = 1.5
"""Half width of what is to come, over the last change of the mean."""
INERTIA, APPROACH, POINTS, NOISE = 0.05, 0.001, 0.001, 0.015
"""Half widths: of S; of what the approach leaves and what more points change, over Nc; of noise."""
FEWEST_ROWS = 4
"""Rows of cells beside the face from which on the law of the error of the mesh holds."""
LARGEST_INERTIA = 3.0
"""rho V^2 / su up to which the law of the error of the speed holds."""
SMALLEST_POISSONS_RATIO = 0.45
LARGEST_ANISOTROPY = 0.5
"""Ranges of the cases by which the laws were tested."""
ALL_PASSED = 1.5
"""Penetration beyond the extent of the window above the shoulder at which all soil beside the shaft
has been passed by the cone, in cone radii."""


def known_error(test: ConeTest, *, cell_size: float, recorded: xr.Dataset) -> xr.Dataset:
    """The cone factor less what is known of its error, and its uncertainty.

    Args:
        test: the cone penetration test.
        cell_size: width of the cells at the cone over its radius, dimensionless.
        recorded: the curve `penetration_resistance`, and the scalars `cone_factor_simulated`,
            `cone_factor_shear` and `penetration_reached`.

    Returns:
        `cone_factor`, its normal part and its correction; `cone_factor_uncertainty` and its parts,
        each a half width of 95 %. Where nothing is known of the error there is no correction, the
        uncertainty is not a number, and its attribute `not_known` tells why.
    """
    simulated, shear = float(recorded.cone_factor_simulated), float(recorded.cone_factor_shear)
    error_of_mesh = mesh_error(
        rigidity_index=test.rigidity_index,
        adhesion_factor=test.adhesion_factor,
        cell_size=cell_size,
        cell_growth=test.cell_growth,
    )
    correction = BOTTOM_ERROR * _nearness(test) - SPEED_ERROR * _inertia(test) - error_of_mesh
    parts = _parts(test, cell_size, recorded)
    reason = _not_known(test, cell_size, recorded)
    if reason:
        correction, parts = 0.0, dict.fromkeys(parts, math.nan)
    settled = labelled(
        role="settled",
        cone_factor_settled=(
            float(_all_is_passed(test, recorded)),
            "1",
            "whether the cone factor has settled",
            "1 where the cone has passed all soil beside the shaft, else 0",
        ),
    )
    factor = simulated + correction
    uncertainty = labelled(
        role="uncertainty",
        cone_factor_uncertainty=(
            math.hypot(*parts.values()),
            "1",
            "uncertainty of the cone factor",
            "half width, 95 %",
        ),
    )
    if reason:
        uncertainty["cone_factor_uncertainty"].attrs["not_known"] = reason
    headline = labelled(
        role="headline",
        cone_factor=(
            factor,
            "1",
            "cone factor",
            "Nc = (qc - sigma_v0) / su, as simulated and corrected for mesh, speed and window",
        ),
    )
    others = labelled(
        cone_factor_normal=(
            factor - shear,
            "1",
            "cone factor, normal part",
            "what the normal traction on the face adds to Nc",
        ),
        cone_factor_correction=(
            correction,
            "1",
            "correction of the cone factor",
            "what is known of the error of mesh, speed and window, taken off; 0 where nothing is",
        ),
    )
    of_parts = {
        f"cone_factor_uncertainty_{name}": variable(
            value, unit="1", meaning=f"uncertainty of the cone factor, {name}"
        )
        for name, value in parts.items()
    }
    return xr.Dataset(headline | uncertainty | settled | others | of_parts)


def mesh_error(
    *, rigidity_index: float, adhesion_factor: float, cell_size: float, cell_growth: float
) -> float:
    """What the mesh adds to the cone factor.

    Args:
        rigidity_index: G/su; beyond those measured, the error is that of the nearest.
        adhesion_factor: of the face.
        cell_size: width of the cells at the cone over its radius.
        cell_growth: growth of their width per distance from the penetrometer.
    """
    smooth, rough = (
        float(np.interp(math.log(rigidity_index), np.log(RIGIDITY_INDICES), errors))
        for errors in FACE_ERRORS
    )
    slope = smooth + adhesion_factor * (rough - smooth)
    return slope * cell_size + GROWTH_ERROR * _growth_measure(cell_size, cell_growth)


def _growth_measure(cell_size: float, cell_growth: float) -> float:
    return math.pow(cell_growth, 1.5) * math.pow(cell_size, 1.3)


def _inertia(test: ConeTest) -> float:
    return test.rigidity_index * test.speed_ratio * test.speed_ratio


def _parts(test: ConeTest, cell_size: float, recorded: xr.Dataset) -> dict[str, float]:
    """The half widths by what they are of, each 95 %."""
    factor = float(recorded.cone_factor_simulated)
    resistance = recorded.penetration_resistance.values / test.undrained_shear_strength
    before, last = (
        resistance[begin:end].mean() if resistance.size >= 2 * STEADY_SAMPLES else math.nan
        for begin, end in ((-2 * STEADY_SAMPLES, -STEADY_SAMPLES), (-STEADY_SAMPLES, None))
    )
    return {
        "face": FACE * cell_size,
        "growth": GROWTH * _growth_measure(cell_size, test.cell_growth) + FORM_OF_GROWTH,
        "domain": DOMAIN * factor * _smallness(test) ** 2,
        "bottom": BOTTOM * BOTTOM_ERROR * _nearness(test),
        "steadiness": STILL_TO_GO * abs(float(last - before)),
        "speed": INERTIA * _inertia(test) + APPROACH * factor,
        "points": POINTS * factor,
        "noise": NOISE,
    }


def _nearness(test: ConeTest) -> float:
    """Ir / H^2 of the bottom of the window."""
    assert test.domain_below is not None
    return test.rigidity_index / (test.domain_below * test.domain_below)


def _smallness(test: ConeTest) -> float:
    """Greatest ratio of an extent of the window that is by default to what it is."""
    given: dict[str, float] = {name: getattr(test, name) for name in test.default_extents}
    return max(extent / given[name] for name, extent in test.default_extents.items())


def _all_is_passed(test: ConeTest, recorded: xr.Dataset) -> bool:
    """Whether the cone has passed all soil beside the shaft."""
    assert test.domain_above is not None
    return float(recorded.penetration_reached) >= test.domain_above + ALL_PASSED


def _not_known(test: ConeTest, cell_size: float, recorded: xr.Dataset) -> str:
    """Why nothing is known of the error, as a phrase; "" where it is known."""
    lowest, highest = RIGIDITY_INDICES[0], RIGIDITY_INDICES[-1]
    phrases = {
        f"material = {test.material} is not tresca": test.material != "tresca",
        f"apex_angle = {test.apex_angle:g} is not 60": test.apex_angle != 60.0,
        "friction_coefficient is not 0": test.friction_coefficient != 0.0,
        "the clay softens": test.remoulded_strength_ratio != 1.0,
        "the clay has a rate effect": test.rate_factor != 0.0,
        f"rigidity_index is not {lowest:g} to {highest:g}": not (
            lowest <= test.rigidity_index <= highest
        ),
        f"stress_anisotropy is beyond {LARGEST_ANISOTROPY:g}": (
            abs(test.stress_anisotropy) > LARGEST_ANISOTROPY
        ),
        f"poissons_ratio is below {SMALLEST_POISSONS_RATIO:g}": (
            min(test.poissons_ratio, test.poissons_ratio_bound) < SMALLEST_POISSONS_RATIO
        ),
        "the cells are too wide": cell_size * FEWEST_ROWS > 1.01 * math.sqrt(3.0),
        "the bottom is too near": _nearness(test) * NEAREST_BOTTOM**2 > 1.0,
        "the speed is too high": _inertia(test) > LARGEST_INERTIA,
        "soil that the cone has not passed is still beside it": not _all_is_passed(test, recorded),
    }
    return "; ".join(phrase for phrase, holds in phrases.items() if holds)
