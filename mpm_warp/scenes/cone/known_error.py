"""What is known of the error of a cone factor: a correction, and a half width of 95 %.

Of the mesh, h the width of the cells at the cone over its radius, g their growth:

    E_mesh = B h + C g^1.5 h^1.3          B by rigidity index and adhesion factor, a table

and of the speed, by the inertia i = rho V^2 / su = Ir (V / c_s)^2, c_s the speed of shear waves:

    E_speed = S i

Both are taken from the cone factor. What they leave, and what only repetition tells, makes up the
half width: its parts are added as squares. How all of it was measured is in the README.md of this
folder; `studies/mesh_error.toml` measures B, `studies/held_out.toml` tests the half width.
"""

from __future__ import annotations

import math
from statistics import fmean

import numpy as np
import xarray as xr

from mpm_warp.results import labelled, variable
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.scenes.cone.penetration import STEADY_SAMPLES

RIGIDITY_INDICES = (20.0, 50.0, 100.0, 300.0, 1000.0)
"""Where the error of the mesh was measured."""
FACE_ERRORS = ((-0.5, -0.45, -0.42, 0.0, 0.3), (-0.35, -0.3, -0.17, 0.0, 0.2))
"""B at these rigidity indices, of a smooth cone and of one with adhesion factor 1."""
GROWTH_ERROR = 1.2
"""C."""
SPEED_ERROR = 0.07
"""S."""
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
    """The refined cone factor and its uncertainty; not a number where they are not known.

    Args:
        test: the cone penetration test.
        cell_size: width of the cells at the cone over its radius, dimensionless.
        recorded: the curve `penetration_resistance` and the scalars `cone_factor` and
            `penetration_reached`.

    Returns:
        `cone_factor_refined`; `cone_factor_uncertainty` and its parts, each a half width of 95 %.
        Where they are not known, the attribute `not_known` of the two tells why.
    """
    factor = float(recorded.cone_factor)
    correction = mesh_error(
        rigidity_index=test.rigidity_index,
        adhesion_factor=test.adhesion_factor,
        cell_size=cell_size,
        cell_growth=test.cell_growth,
    ) + SPEED_ERROR * _inertia(test)
    parts = _parts(test, cell_size, recorded)
    reason = _not_known(test, cell_size, recorded)
    if reason:
        correction, parts = math.nan, dict.fromkeys(parts, math.nan)
    result = {
        "cone_factor_refined": variable(
            factor - correction,
            unit="1",
            meaning="cone factor, refined",
            description="cone factor less what is known of the error of mesh and speed",
        ),
        "cone_factor_uncertainty": variable(
            math.hypot(*parts.values()),
            unit="1",
            meaning="uncertainty of the cone factor",
            description="half width, 95 %, about cone_factor_refined",
        ),
    }
    if reason:
        for it in result.values():
            it.attrs["not_known"] = reason
    quantities = {
        f"cone_factor_uncertainty_{name}": (value, "1", f"uncertainty of the cone factor, {name}")
        for name, value in parts.items()
    }
    return xr.Dataset(result | labelled(**quantities))


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
    return cell_growth**1.5 * cell_size**1.3


def _inertia(test: ConeTest) -> float:
    return test.rigidity_index * test.speed_ratio**2


def _parts(test: ConeTest, cell_size: float, recorded: xr.Dataset) -> dict[str, float]:
    """The half widths by what they are of, each 95 %."""
    factor = float(recorded.cone_factor)
    resistance = recorded.penetration_resistance.values[-2 * STEADY_SAMPLES :]
    means = resistance / test.undrained_shear_strength
    before, last = fmean(means[:STEADY_SAMPLES]), fmean(means[STEADY_SAMPLES:])
    return {
        "face": 0.15 * cell_size,
        "growth": 0.25 * _growth_measure(cell_size, test.cell_growth) + 0.03,
        "domain": 0.004 * factor * _smallness(test) ** 2,
        "steadiness": 1.5 * abs(last - before),
        "speed": 0.05 * _inertia(test) + 0.001 * factor,
        "points": 0.001 * factor,
        "noise": 0.015,
    }


def _smallness(test: ConeTest) -> float:
    """Greatest ratio of an extent of the window that is by default to what it is."""
    return max(extent / getattr(test, name) for name, extent in test.default_extents.items())


def _not_known(test: ConeTest, cell_size: float, recorded: xr.Dataset) -> str:
    """Why nothing is known of the error, as a phrase; "" where it is known."""
    lowest, highest = RIGIDITY_INDICES[0], RIGIDITY_INDICES[-1]
    reached, above = float(recorded.penetration_reached), test.domain_above
    assert above is not None
    phrases = {
        f"material = {test.material} is not tresca": test.material != "tresca",
        f"apex_angle = {test.apex_angle:g} is not 60": test.apex_angle != 60.0,
        "friction_coefficient is not 0": test.friction_coefficient != 0.0,
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
        "the speed is too high": _inertia(test) > LARGEST_INERTIA,
        "soil that the cone has not passed is still beside it": reached < above + ALL_PASSED,
    }
    return "; ".join(phrase for phrase, holds in phrases.items() if holds)
