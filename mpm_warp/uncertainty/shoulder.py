"""The law of u2, the pore pressure beside the shoulder of a cone, by the stress on its shaft.

All is over su, lengths over the radius R of the cone. u2 is the pressure of the soil within 0.06 R
of the shaft, 1 mm beside a cone of 10 cm2: pore pressure evens out over such a distance while a
cone passes by. Beside the filter every mesh smears what happens at the shoulder. So u2 is stated by
F, the radial stress on the shaft from 1.4 to 3.2 R above it, which meshes of 5 to 56 rows beside
the face have alike within some percent, and by C, what the pressure beside the filter has more,
from 14 to 112 rows. h is the width of the cells at the cone:

    u2 = F - S h + C + T,    C = B + G + 0.16 |Delta| - K (nu - 0.45) + D
                             D = w D_l + (1 - w) D_b
    half width  0.045 h F, 0.2 S, B_l, G_l, 0.08 |Delta|, 0.8 (nu - 0.45), 0.3 (1 - r), 0.05,
                0.05 (D_b - D_l), E i, 0.035, W

The parts of the half width add up as squares. S is the error of the mesh, B what the radial stress
rises from there down to the filter, known to B_l, and D the deviator of the radial stress within
the 0.06 R, tension positive. Soil that has gone round the shoulder forms a layer beside the shaft;
D_l is the deviator in it, close to what yield allows, D_b that of the soil beside it, and w is the
share of the 0.06 R that the layer takes; no more of it is left open than there is. A mesh makes it
by some half a row thicker, so w is drawn on from meshes of up to 112 rows. The strength of the soil
at the shaft is r su; D is in proportion. On fewer than five rows 0.42 (h - 0.385) F is one more
part of the half width, which also grows beyond the rigidity indices where this was measured.

No law takes off what the inertia i = rho V^2 / su does to F: E i is the most that it was found to
do. C was measured at i = 0.1 to 0.36; G is what it gains in a slow test, known to G_l. A taller
window adds T = 0.025 (1 - 2 Delta), nothing from Delta 0.5 on; below Ir 50 both it and its half
width are in proportion to Ir. A window that is smaller than by default leaves open as much as of
the cone factor, W. Nor is anything known where cells grow by more than 0.5. How all of it was
measured is in `uncertainty/README.md`.
"""

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.laws import DOMAIN_FELT, Row, Value, window_uncertainty

Table = tuple[Row, ...]

RADIAL_STRESS, RADIAL_FACTOR = "excess_radial_stress_shaft", "radial_stress_factor_shaft"
"""The curve of the radial stress on the shaft, and its mean at the end over su, F."""
INDICES = (20.0, 50.0, 100.0, 200.0, 300.0, 450.0, 1000.0)
ADHESION = (0.0, 0.5, 1.0)
ERROR = (
    (-0.3, -0.4, 0.0),
    (-0.1, -0.1, 0.2),
    (-0.1, -0.1, 0.2),
    (0.5, 0.0, -0.4),
    (0.5, 0.5, -0.6),
    (0.9, 0.6, 0.2),
    (0.9, 0.7, 1.9),
)
"""S at these rigidity indices (rows) and adhesion factors, fitted at once to all clays that were
measured on five rows beside the face and more."""
RISE_ADHESION = (0.0, 0.25, 0.5, 1.0)
RISE = (
    (0.92, 0.88, 0.88, 1.01),
    (1.14, 1.09, 1.06, 1.17),
    (1.28, 1.16, 1.12, 1.11),
    (1.54, 1.46, 1.28, 1.22),
    (1.85, 1.66, 1.58, 1.26),
    (2.22, 2.04, 1.86, 1.55),
    (2.6, 2.5, 2.4, 2.4),
)
"""B at the rigidity indices of S and these adhesion factors, where Delta is 0."""
RISE_LEFT = (20.0, 50.0, 100.0, 200.0, 450.0, 1000.0), (0.04, 0.06, 0.04, 0.06, 0.1, 0.2)
"""Half width of B over the rigidity index."""
RISE_BY_ANISOTROPY, RISE_BY_ANISOTROPY_LEFT = 0.16, 0.08
"""What B gains, over |Delta|, and its half width."""
SLOW_INDICES = (20.0, 50.0, 100.0, 300.0)
GAIN_IN_SLOW_TEST = (
    (0.02, 0.02, 0.02, 0.0),
    (0.07, 0.01, 0.02, 0.0),
    (0.12, 0.0, 0.0, -0.01),
    (0.08, 0.08, 0.08, -0.07),
)
"""G at these rigidity indices (rows) and the adhesion factors of B: what C gains at i = 0.05 over
that of the speeds at which B and D were measured, 0.1 at Ir 20 and 0.36 from Ir 100 on; on 28 rows
and narrow columns of 56, 14 rows at Ir 300."""
GAIN_IN_SLOW_TEST_LEFT = (20.0, 100.0, 300.0), (0.035, 0.08, 0.1)
"""Half width of G over the rigidity index."""
RISE_MEASURED_AT, RISE_BY_POISSON_LEFT = 0.45, 0.8
RISE_BY_POISSON = (20.0, 50.0), (-0.8, 1.2)
"""Poisson's ratio that B was measured at, half width of what it loses over what nu is greater, and
K over the rigidity index."""
LAYER_INDICES, LAYER_ADHESION = (30.0, 100.0, 300.0, 600.0), (0.0, 0.25, 0.5, 1.0)
LAYER_SHARE = (
    (0.78, 0.86, 0.9, 1.0),
    (0.52, 0.72, 0.82, 1.0),
    (0.0, 0.1, 0.46, 0.85),
    (0.0, 0.0, 0.0, 0.9),
)
"""w at these rigidity indices and adhesion factors."""
IN_LAYER = ((0.0, 0.25, 0.5, 0.75, 1.0), (-1.22, -1.21, -1.14, -0.98, -0.56))
"""D_l over the adhesion factor, at any rigidity index."""
BESIDE_LAYER = ((30.0, 100.0, 300.0, 600.0), (-0.6, 0.0, 0.45, 0.62))
"""D_b over the rigidity index, at any adhesion factor."""
READ_IN_CELLS, SLOPE_LEFT, NEAR_SHAFT, LAYER_LEFT, SOFTENED = 0.045, 0.2, 0.05, 0.05, 0.3
"""Half widths of u2: over h F; over S, for the power of h; of D; of w; and over 1 - r."""
READ_IN_WIDE_CELLS, WIDE = 0.42, 0.385
"""Half width of u2 over F and over what h is above that of wide cells."""
INERTIA_ADHESION = (0.5, 1.0)
INERTIA = (
    (0.1, 0.6),
    (0.2, 0.2),
    (0.35, 0.45),
    (0.2, 0.8),
    (0.1, 0.5),
    (0.1, 0.45),
    (0.3, 0.45),
)
"""E, what i = 0.02 to 0.36 changes of F over i, at the rigidity indices of S and these adhesion
factors."""
LARGEST_GROWTH = 0.5
"""Growth of the cells up to which u1 and u2 are known: they were measured with 0.4."""
WINDOW, WINDOW_LEFT = 0.025, 0.035
"""T of u2 at Delta 0 and its half width: a window twice as tall adds -0.01 to 0.05 from Ir 50 to
400, most where Delta is least."""
RANGE = 0.8
"""Half width per ln(Ir) beyond the rigidity indices of S."""


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
    """u2 and its half width of 95 %, over su, shape [...].

    Args:
        radial: F over su as simulated, shape [...].
        cell_size: width of the cells at the cone over its radius.
        adhesion_factor: of face and shaft, shape [...].
        rigidity_index: shape [...].
        inertia: rho V^2 / su, shape [...].
        poissons_ratio: nu as simulated.
        stress_anisotropy: Delta, shape [...].
        strength_ratio: r, strength of the soil at the shaft over su, shape [...].
        extent_ratio: greatest ratio of an extent of the window that is by default to what it is.
    """
    soil = {"rigidity_index": rigidity_index, "adhesion_factor": adhesion_factor}
    slope = of_table(ERROR, INDICES, ADHESION, **soil)
    share, in_layer, beside = _layer(**soil)
    excess = excess_at_filter(
        **soil, stress_anisotropy=stress_anisotropy, strength_ratio=strength_ratio
    )
    by_inertia = of_table(INERTIA, INDICES, INERTIA_ADHESION, **soil)
    stiffer = poissons_ratio - RISE_MEASURED_AT
    felt = np.minimum(1.0, rigidity_index / DOMAIN_FELT)
    of_window = WINDOW * np.maximum(0.0, 1.0 - 2.0 * stress_anisotropy) * felt
    half_width = added(
        (READ_IN_CELLS * cell_size + READ_IN_WIDE_CELLS * max(0.0, cell_size - WIDE)) * radial,
        SLOPE_LEFT * slope,
        by_index(RISE_LEFT, rigidity_index),
        by_index(GAIN_IN_SLOW_TEST_LEFT, rigidity_index),
        RISE_BY_ANISOTROPY_LEFT * np.abs(stress_anisotropy),
        RISE_BY_POISSON_LEFT * stiffer,
        SOFTENED * (1.0 - strength_ratio),
        strength_ratio * np.minimum(share, LAYER_LEFT) * (beside - in_layer),
        NEAR_SHAFT,
        RANGE * beyond_measured(INDICES, rigidity_index),
        by_inertia * inertia,
        window_uncertainty(extent_ratio),
        WINDOW_LEFT * felt,
    )
    pressure = radial - slope * cell_size + excess + of_window
    return pressure - by_index(RISE_BY_POISSON, rigidity_index) * stiffer, half_width


def excess_at_filter(
    *,
    rigidity_index: Value,
    adhesion_factor: Value,
    stress_anisotropy: Value = 0.0,
    strength_ratio: Value = 1.0,
) -> Value:
    """C over su where nu is 0.45, shape [...]; arguments as in `shoulder_pressure`."""
    rise = of_table(RISE, INDICES, RISE_ADHESION, rigidity_index, adhesion_factor)
    by_anisotropy = RISE_BY_ANISOTROPY * np.abs(stress_anisotropy)
    deviator = deviator_near_shaft(rigidity_index, adhesion_factor, strength_ratio)
    gain = of_table(GAIN_IN_SLOW_TEST, SLOW_INDICES, RISE_ADHESION, rigidity_index, adhesion_factor)
    return rise + gain + by_anisotropy + deviator


def deviator_near_shaft(
    rigidity_index: Value, adhesion_factor: Value, strength_ratio: Value = 1.0
) -> Value:
    """D over su, shape [...]; arguments as in `shoulder_pressure`."""
    share, in_layer, beside = _layer(rigidity_index, adhesion_factor)
    return strength_ratio * (share * in_layer + (1.0 - share) * beside)


def _layer(rigidity_index: Value, adhesion_factor: Value) -> tuple[Value, Value, Value]:
    """w, D_l and D_b in clay whose strength stays."""
    share = of_table(LAYER_SHARE, LAYER_INDICES, LAYER_ADHESION, rigidity_index, adhesion_factor)
    in_layer = np.interp(adhesion_factor, *IN_LAYER)
    beside = by_index(BESIDE_LAYER, rigidity_index)
    return share, in_layer, beside


def of_table(
    table: Table, indices: Row, adhesions: Row, rigidity_index: Value, adhesion_factor: Value
) -> Value:
    """Linear between the values of a table, over the logarithm of the rigidity index."""
    places = np.arange(len(indices), dtype=float)
    place = np.interp(np.log(rigidity_index), np.log(indices), places)
    error: Floats = sum(
        np.maximum(0.0, 1.0 - np.abs(place - row)) * np.interp(adhesion_factor, adhesions, at)
        for row, at in enumerate(table)
    )
    return error


def by_index(table: tuple[Row, Row], rigidity_index: Value) -> Value:
    """A table at a rigidity index, straight over its logarithm, shape [...]."""
    return np.interp(np.log(rigidity_index), np.log(table[0]), table[1])


def beyond_measured(indices: Row, rigidity_index: Value) -> Value:
    """How far a rigidity index is beyond those measured, by its logarithm."""
    nearest = np.clip(rigidity_index, indices[0], indices[-1])
    return np.abs(np.log(rigidity_index / nearest))


def added(*parts: Value) -> Value:
    """Half widths added up as squares, shape [...]."""
    return np.sqrt(sum(np.square(part) for part in parts))
