"""The law of u2, the excess pore pressure behind the shoulder of a cone.

All pressures and stresses are over su, all lengths over the radius R of the cone. u2 is the mean
pressure of the soil within 0.06 R of the shaft, 1 mm beside a cone of 10 cm2: pore pressure evens
out over such a distance while a cone passes by. Beside the filter every mesh smears the jump at the
shoulder. So u2 is not read there. It is the sum of F, the radial stress on the shaft from 1.4 to
3.2 R above the shoulder, and C, the excess of u2 over F. F differs by some percent between meshes
of 5 to 56 rows beside the face. C was measured on 14 to 112 rows. h is the width of the cells at
the cone:

    u2 = F - (S + E f) h + C + T,    C = B + G + 0.16 |Delta| - K (nu - 0.45) + D
                                     D = w D_l + (1 - w) D_b
    half width  0.045 h F, 0.22 S, B_l, G_l, 0.08 |Delta|, 0.8 (nu - 0.45), 0.3 (1 - r), 0.05,
                0.05 (D_b - D_l), E_l i, 0.035, W

The parts of the half width are added as squares.

- S h is the error of the mesh in a slow test.
- B is the rise of the radial stress from the place of F down to the filter, B_l its half width.
- D is the radial deviator, radial stress less mean stress, averaged over the 0.06 R; tension is
  positive. Soil that has gone round the shoulder forms a layer beside the shaft. D_l is the
  deviator in this layer, near the yield limit, D_b that outside it. w is the share of the 0.06 R
  that the layer takes; its half width is 0.05, or w where w is less. A mesh makes the layer thicker
  by about half a row, so w is extrapolated from meshes of up to 112 rows. D is in proportion to r,
  the strength of the soil at the shaft over su.
- E f h, f = i / (i + 0.1), is the effect of the inertia i = rho V^2 / su on F; E_l i is its half
  width. Beside a rough shaft it is larger on coarser meshes; beside others it is small, of either
  sign, and E is 0.
- G, with half width G_l, is the gain of C in a slow test: B and D were measured at i = 0.1 to 0.36.
- T = 0.025 (1 - 2 Delta), at least 0, is the effect of a taller window. Below Ir 50, T and its half
  width are in proportion to Ir.
- W is the half width for a window smaller than the default, the same as that of the cone factor.

On fewer than five rows 0.42 (h - 0.385) F is one more part of the half width. Beyond the rigidity
indices measured the half width grows. Where cells grow by more than 0.5 nothing is known.
`uncertainty/README.md` says how all of it was measured.
"""

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.laws import (
    FULL_DOMAIN_INDEX,
    Row,
    Value,
    interpolated,
    window_uncertainty,
)

Table = tuple[Row, ...]

RADIAL_STRESS, RADIAL_FACTOR = "excess_radial_stress_shaft", "radial_stress_factor_shaft"
"""Names in a dataset: the curve of the radial stress on the shaft, and F, its mean at the end over
su."""
RIGIDITY_INDICES = (20.0, 50.0, 100.0, 200.0, 300.0, 450.0, 1000.0)
ADHESION_FACTORS = (0.0, 0.5, 1.0)
MESH_SLOPE = (
    (-0.3, -0.4, -0.2),
    (-0.1, -0.1, -0.2),
    (-0.1, -0.1, -0.3),
    (0.5, 0.0, -0.4),
    (0.5, 0.5, 0.2),
    (0.9, 0.6, 1.1),
    (0.9, 0.7, 1.9),
)
"""S by rigidity index (rows) and adhesion factor (columns). One fit to all clays measured on five
or more rows beside the face."""
RISE_ADHESION_FACTORS = (0.0, 0.25, 0.5, 1.0)
RISE = (
    (0.92, 0.88, 0.88, 1.01),
    (1.14, 1.09, 1.06, 1.17),
    (1.28, 1.16, 1.12, 1.11),
    (1.54, 1.46, 1.28, 1.22),
    (1.85, 1.66, 1.58, 1.26),
    (2.22, 2.04, 1.86, 1.55),
    (2.6, 2.5, 2.4, 2.4),
)
"""B at Delta 0, by `RIGIDITY_INDICES` (rows) and these adhesion factors (columns)."""
RISE_HALF_WIDTH = (20.0, 50.0, 100.0, 200.0, 450.0, 1000.0), (0.04, 0.06, 0.04, 0.06, 0.1, 0.2)
"""B_l, half width of B: rigidity indices, and its values there."""
RISE_BY_ANISOTROPY, RISE_BY_ANISOTROPY_HALF_WIDTH = 0.16, 0.08
"""Increase of B per |Delta|, and its half width."""
SLOW_GAIN_INDICES = (20.0, 50.0, 100.0, 300.0)
SLOW_GAIN = (
    (0.02, 0.02, 0.02, 0.0),
    (0.07, 0.01, 0.02, 0.0),
    (0.12, 0.0, 0.0, -0.01),
    (0.08, 0.08, 0.08, -0.07),
)
"""G by rigidity index (rows) and the adhesion factors of B (columns): C at i = 0.05, less C at the
i at which B and D were measured, 0.1 at Ir 20 and 0.36 from Ir 100 on. Measured on 28 rows and on
narrow columns of 56 rows, at Ir 300 on 14 rows."""
SLOW_GAIN_HALF_WIDTH = (20.0, 100.0, 300.0), (0.035, 0.08, 0.1)
"""G_l, half width of G: rigidity indices, and its values there."""
MEASURED_POISSONS_RATIO, POISSON_HALF_WIDTH = 0.45, 0.8
POISSON_SLOPE = (20.0, 50.0), (-0.8, 1.2)
"""Poisson's ratio at which B was measured; half width of K; K: rigidity indices, and its values
there."""
LAYER_INDICES, LAYER_ADHESION_FACTORS = (30.0, 100.0, 300.0, 600.0), (0.0, 0.25, 0.5, 1.0)
LAYER_SHARE = (
    (0.78, 0.86, 0.9, 1.0),
    (0.52, 0.72, 0.82, 1.0),
    (0.0, 0.1, 0.46, 0.85),
    (0.0, 0.0, 0.0, 0.9),
)
"""w by rigidity index (rows) and adhesion factor (columns)."""
DEVIATOR_IN_LAYER = ((0.0, 0.25, 0.5, 0.75, 1.0), (-1.22, -1.21, -1.14, -0.98, -0.56))
"""D_l at all rigidity indices: adhesion factors, and its values there."""
DEVIATOR_OUTSIDE_LAYER = ((30.0, 100.0, 300.0, 600.0), (-0.6, 0.0, 0.45, 0.62))
"""D_b at all adhesion factors: rigidity indices, and its values there."""
MESH_HALF_WIDTH, MESH_POWER_HALF_WIDTH = 0.045, 0.22
"""Half widths of u2: for the scatter between meshes, over h F; for the power of h, over S."""
DEVIATOR_HALF_WIDTH, LAYER_SHARE_HALF_WIDTH, SOFTENING_HALF_WIDTH = 0.05, 0.05, 0.3
"""Half widths: of D; of w; of u2 for softened soil at the shaft, over 1 - r."""
WIDE_CELL_HALF_WIDTH, WIDE_CELL = 0.42, 0.385
"""Further half width of u2 where h is above `WIDE_CELL`, over F (h - WIDE_CELL)."""
INERTIA_ADHESION_FACTORS = (0.5, 0.75, 1.0)
INERTIA_EFFECT = (
    (0.0, 0.1, 0.2),
    (0.0, 0.25, 0.5),
    (0.0, 0.3, 0.6),
    (0.0, -0.2, 0.8),
    (0.0, -0.6, -0.9),
    (0.0, -0.4, -0.7),
    (0.0, 0.0, 0.0),
)
"""E by `RIGIDITY_INDICES` (rows) and these adhesion factors (columns), found at i = 0.02 to 0.36 on
4 to 10 rows; at adhesion factor 0.75 at Ir 200 to 600 alone."""
INERTIA_OF_HALF_EFFECT = 0.1
"""Inertia at which f is a half."""
INERTIA_HALF_WIDTH = (
    (0.1, 0.35, 0.6),
    (0.2, 0.2, 0.2),
    (0.35, 0.3, 0.2),
    (0.2, 0.25, 0.25),
    (0.1, 0.3, 0.25),
    (0.1, 0.2, 0.25),
    (0.2, 0.2, 0.2),
)
"""E_l, likewise."""
LARGEST_GROWTH = 0.5
"""Growth of the cells up to which the laws of u1 and u2 hold. They were measured at 0.4."""
TALLER_WINDOW, TALLER_WINDOW_HALF_WIDTH = 0.025, 0.035
"""T at Delta 0, and its half width. A window twice as tall adds -0.01 to 0.05 to u2 at Ir 50 to
400, most at the smallest Delta."""
RANGE_HALF_WIDTH = 0.8
"""Half width of u2 per ln(Ir) beyond `RIGIDITY_INDICES`."""


def shoulder_pressure(
    radial: Value,
    *,
    cell_size: float,
    adhesion_factor: Value,
    rigidity_index: Value,
    inertia: Value,
    poissons_ratio: float,
    stress_anisotropy: Value = 0.0,
    strength_ratio: Value = 1.0,
    extent_ratio: float = 1.0,
) -> tuple[Value, Value]:
    """u2 and its half width of 95 %, both over su, shape [...].

    Args:
        radial: F over su as simulated, shape [...].
        cell_size: width of the cells at the cone over its radius.
        adhesion_factor: of face and shaft, shape [...].
        rigidity_index: shape [...].
        inertia: rho V^2 / su, shape [...].
        poissons_ratio: nu as simulated.
        stress_anisotropy: Delta, shape [...].
        strength_ratio: r, strength of the soil at the shaft over su, shape [...].
        extent_ratio: default extent of the window over its actual extent, the greatest of all
            directions; above 1 the window is smaller than the default.
    """
    soil = {"rigidity_index": rigidity_index, "adhesion_factor": adhesion_factor}
    slope = interpolated_table(MESH_SLOPE, RIGIDITY_INDICES, ADHESION_FACTORS, **soil)
    effect = inertia_effect(**soil, inertia=inertia)
    share, in_layer, beside = _layer(**soil)
    excess = excess_at_filter(
        **soil, stress_anisotropy=stress_anisotropy, strength_ratio=strength_ratio
    )
    of_inertia = interpolated_table(
        INERTIA_HALF_WIDTH, RIGIDITY_INDICES, INERTIA_ADHESION_FACTORS, **soil
    )
    ratio_excess = poissons_ratio - MEASURED_POISSONS_RATIO
    felt = np.minimum(1.0, rigidity_index / FULL_DOMAIN_INDEX)
    of_window = TALLER_WINDOW * np.maximum(0.0, 1.0 - 2.0 * stress_anisotropy) * felt
    half_width = root_sum_square(
        MESH_HALF_WIDTH * cell_size * radial,
        WIDE_CELL_HALF_WIDTH * max(0.0, cell_size - WIDE_CELL) * radial,
        MESH_POWER_HALF_WIDTH * slope,
        interpolated(RISE_HALF_WIDTH, rigidity_index),
        interpolated(SLOW_GAIN_HALF_WIDTH, rigidity_index),
        RISE_BY_ANISOTROPY_HALF_WIDTH * np.abs(stress_anisotropy),
        POISSON_HALF_WIDTH * ratio_excess,
        SOFTENING_HALF_WIDTH * (1.0 - strength_ratio),
        strength_ratio * np.minimum(share, LAYER_SHARE_HALF_WIDTH) * (beside - in_layer),
        DEVIATOR_HALF_WIDTH,
        RANGE_HALF_WIDTH * beyond_range(RIGIDITY_INDICES, rigidity_index),
        of_inertia * inertia,
        window_uncertainty(extent_ratio),
        TALLER_WINDOW_HALF_WIDTH * felt,
    )
    pressure = radial - (slope + effect) * cell_size + excess + of_window
    return pressure - interpolated(POISSON_SLOPE, rigidity_index) * ratio_excess, half_width


def excess_at_filter(
    *,
    rigidity_index: Value,
    adhesion_factor: Value,
    stress_anisotropy: Value = 0.0,
    strength_ratio: Value = 1.0,
) -> Value:
    """C over su at nu = 0.45, shape [...]; arguments as in `shoulder_pressure`."""
    rise = interpolated_table(
        RISE, RIGIDITY_INDICES, RISE_ADHESION_FACTORS, rigidity_index, adhesion_factor
    )
    by_anisotropy = RISE_BY_ANISOTROPY * np.abs(stress_anisotropy)
    deviator = deviator_near_shaft(rigidity_index, adhesion_factor, strength_ratio)
    gain = interpolated_table(
        SLOW_GAIN, SLOW_GAIN_INDICES, RISE_ADHESION_FACTORS, rigidity_index, adhesion_factor
    )
    return rise + gain + by_anisotropy + deviator


def inertia_effect(rigidity_index: Value, adhesion_factor: Value, inertia: Value) -> Value:
    """E f, shape [...]; arguments as in `shoulder_pressure`."""
    effect = interpolated_table(
        INERTIA_EFFECT,
        RIGIDITY_INDICES,
        INERTIA_ADHESION_FACTORS,
        rigidity_index,
        adhesion_factor,
    )
    return effect * inertia / (inertia + INERTIA_OF_HALF_EFFECT)


def deviator_near_shaft(
    rigidity_index: Value, adhesion_factor: Value, strength_ratio: Value = 1.0
) -> Value:
    """D over su, shape [...]; arguments as in `shoulder_pressure`."""
    share, in_layer, beside = _layer(rigidity_index, adhesion_factor)
    return strength_ratio * (share * in_layer + (1.0 - share) * beside)


def _layer(rigidity_index: Value, adhesion_factor: Value) -> tuple[Value, Value, Value]:
    """w, D_l and D_b in clay that does not soften."""
    share = interpolated_table(
        LAYER_SHARE, LAYER_INDICES, LAYER_ADHESION_FACTORS, rigidity_index, adhesion_factor
    )
    in_layer = np.interp(adhesion_factor, *DEVIATOR_IN_LAYER)
    beside = interpolated(DEVIATOR_OUTSIDE_LAYER, rigidity_index)
    return share, in_layer, beside


def interpolated_table(
    table: Table, indices: Row, adhesions: Row, rigidity_index: Value, adhesion_factor: Value
) -> Value:
    """Bilinear interpolation in a table, shape [...].

    The table has a row for each of `indices`, interpolated over ln(Ir), and a column for each of
    `adhesions`. Beyond its edge it keeps the value at the edge.
    """
    places = np.arange(len(indices), dtype=float)
    place = np.interp(np.log(rigidity_index), np.log(indices), places)
    value: Floats = sum(
        np.maximum(0.0, 1.0 - np.abs(place - row)) * np.interp(adhesion_factor, adhesions, at)
        for row, at in enumerate(table)
    )
    return value


def beyond_range(indices: Row, rigidity_index: Value) -> Value:
    """Distance in ln(Ir) from the range of `indices`, 0 inside it, shape [...]."""
    nearest = np.clip(rigidity_index, indices[0], indices[-1])
    return np.abs(np.log(rigidity_index / nearest))


def root_sum_square(*parts: Value) -> Value:
    """Root of the sum of squares of half widths, shape [...]."""
    return np.sqrt(sum(np.square(part) for part in parts))
