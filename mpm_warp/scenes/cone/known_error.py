"""What is known of the error of a cone factor: a correction, and a half width of 95 %.

Of the mesh, h the width of the cells at the cone over its radius, g their growth:

    E_mesh = B h + C g^1.5 h^1.3 + W max(0, h - 0.44)

B by rigidity index and adhesion factor, a table, the last term of cells that are wider than those
which B was measured with; of the speed, by the inertia i = rho V^2 / su = Ir (V / c_s)^2, c_s the
speed of shear waves:

    E_speed = S i

and of the bottom of the window, H its distance from the tip over the cone's radius:

    E_bottom = -D Ir / H^2

and of the top, A its distance from the shoulder and w the way that the cone has gone beyond that
of a test by default, both over the cone's radius:

    E_top = T (Ir / A^2)^1.5 (1 - exp(-w / (1.7 (A + H))))

All are taken from the cone factor. What they leave, and what only repetition tells, makes up the
half width: its parts are added as squares. How all of it was measured is in the README.md of this
folder; `studies/mesh_error.toml` measures B, `studies/held_out.toml` tests the half width.
"""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.scenes.cone.stated_error import (
    ALL_PASSED,
    LARGEST_CELL,
    growth_measure,
    inertia,
    parts_of_a_run,
    stated_error,
    why_no_law_holds,
)
from mpm_warp.scenes.cone.window import steady_penetration

RIGIDITY_INDICES = (20.0, 50.0, 100.0, 300.0, 1000.0)
"""Where the error of the mesh was measured."""
FACE_ERRORS = ((-0.66, -0.38, -0.43, -0.08, 0.18), (-0.36, -0.32, -0.28, -0.03, 0.15))
"""B at these rigidity indices, of a smooth cone and of one with adhesion factor 1."""
GROWTH_ERROR = 1.2
"""C."""
WIDE_ERROR = 0.55
"""W."""
WIDEST_CELL = 0.58
"""Width of the cells at the cone over its radius up to which their error is known: 3 rows of cells
beside a face of 60 degrees."""
SPEED_ERROR = 0.07
"""S."""
BOTTOM_ERROR = 0.09
"""D."""
TOP_ERROR, TOP_POWER, TOP_WAY = 0.19, 1.5, 1.7
"""T; the power of Ir / A^2; and the way in which E_top gets near its limit, over A + H."""
FACE, WIDE, GROWTH, DOMAIN = 0.12, 0.42, 0.3, 0.004
"""Half widths: of B; of W; of C; of what a default window changes, over Nc."""
FORM_OF_GROWTH, SHARE_OF_GROWTH = 0.02, 1.0 / 3.0
"""Half width of the form of the law of growth, where cells are not small; and what it is at most,
over the effect of growth."""
BOTTOM, TOP = 0.3, 0.5
"""Half widths of the effects of bottom and top, over them."""
NEAREST_BOTTOM = 0.74
"""Distance of the bottom over sqrt(Ir) from which on its effect is known."""
INERTIA, APPROACH = 0.05, 0.001
"""Half widths: of S; of what the approach leaves, over Nc."""
BOUND = 0.4
"""Half width of what a bound of Poisson's ratio changes, over Nc and over what it takes off."""
SMALLEST_POISSONS_RATIO = 0.45
LARGEST_ANISOTROPY = 0.5
"""Ranges of the cases by which the laws were tested."""


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
    error_of_mesh = mesh_error(
        rigidity_index=test.rigidity_index,
        adhesion_factor=test.adhesion_factor,
        cell_size=cell_size,
        cell_growth=test.cell_growth,
    )
    return stated_error(
        test,
        recorded,
        correction=BOTTOM_ERROR * _nearness(test)
        - SPEED_ERROR * inertia(test)
        - error_of_mesh
        - _top_error(test, recorded),
        parts=_parts(test, cell_size, recorded),
        not_known=_not_known(test, cell_size, recorded),
    )


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
    linear = slope * cell_size + GROWTH_ERROR * growth_measure(cell_size, cell_growth)
    return linear + WIDE_ERROR * _excess_width(cell_size)


def growth_uncertainty(cell_size: float, cell_growth: float) -> float:
    """Half width of what the growth of the cells adds to the cone factor; see `mesh_error`."""
    measure = growth_measure(cell_size, cell_growth)
    form = min(FORM_OF_GROWTH, SHARE_OF_GROWTH * GROWTH_ERROR * measure)
    return GROWTH * measure + form


def top_error(
    *, rigidity_index: Floats | float, above: float, below: float, way: Floats | float
) -> Floats:
    """What the top of the window adds to the cone factor, shape [...].

    Args:
        rigidity_index: G/su, shape [...].
        above: extent of the window above the shoulder, over the cone's radius.
        below: extent of the window below the tip, likewise.
        way: of the cone since its start, likewise, shape [...].
    """
    index = np.asarray(rigidity_index, dtype=float)
    of_a_test = above + ALL_PASSED + np.vectorize(steady_penetration)(index)
    beyond = np.maximum(0.0, way - of_a_test)
    grown = -np.expm1(-beyond / (TOP_WAY * (above + below)))
    error: Floats = TOP_ERROR * (index / above**2) ** TOP_POWER * grown
    return error


def _top_error(test: ConeTest, recorded: xr.Dataset) -> float:
    """What the top has added at the end of a test."""
    assert test.domain_above is not None
    assert test.domain_below is not None
    return float(
        top_error(
            rigidity_index=test.rigidity_index,
            above=test.domain_above,
            below=test.domain_below,
            way=float(recorded.penetration_reached),
        )
    )


def _parts(test: ConeTest, cell_size: float, recorded: xr.Dataset) -> dict[str, float]:
    """The half widths by what they are of, each 95 %."""
    factor = float(recorded.cone_factor_simulated)
    return {
        "face": FACE * cell_size + WIDE * _excess_width(cell_size),
        "growth": growth_uncertainty(cell_size, test.cell_growth),
        "domain": DOMAIN * factor * _smallness(test) ** 2,
        "bottom": BOTTOM * BOTTOM_ERROR * _nearness(test),
        "top": TOP * _top_error(test, recorded),
        "speed": INERTIA * inertia(test) + APPROACH * factor,
        "bound": BOUND * factor * max(0.0, test.poissons_ratio - test.poissons_ratio_bound),
    } | parts_of_a_run(test, recorded)


def _excess_width(cell_size: float) -> float:
    """Width of the cells beyond those that B was measured with, over the cone's radius."""
    return max(0.0, cell_size - LARGEST_CELL)


def _nearness(test: ConeTest) -> float:
    """Ir / H^2 of the bottom of the window."""
    assert test.domain_below is not None
    return test.rigidity_index / (test.domain_below * test.domain_below)


def _smallness(test: ConeTest) -> float:
    """Greatest ratio of an extent of the window that is by default to what it is."""
    given: dict[str, float] = {name: getattr(test, name) for name in test.default_extents}
    return max(extent / given[name] for name, extent in test.default_extents.items())


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
        "the bottom is too near": _nearness(test) * NEAREST_BOTTOM**2 > 1.0,
    } | why_no_law_holds(test, cell_size, recorded, largest_cell=WIDEST_CELL)
    return "; ".join(phrase for phrase, holds in phrases.items() if holds)
