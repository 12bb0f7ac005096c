"""The law of u2, the excess pore pressure behind the shoulder of a cone.

All pressures and stresses are over su, all lengths over the radius R of the cone. u2 is the mean
pressure of the soil within 0.06 R of the shaft, 1 mm beside a cone of 10 cm2: pore pressure evens
out over such a distance while a cone passes by. Beside the filter every mesh smears the jump at the
shoulder. So u2 is not read there. It is the sum of F, the radial stress on the shaft from 1.4 to
3.2 R above the shoulder, and C, the excess of u2 over F. F differs by some percent between meshes
of 5 to 56 rows beside the face. C was measured on 14 to 112 rows:

    u2 = F - S h + C + 0.16 |Delta| - (1 - r) D

h is the width of the cells at the cone. r is the strength of the soil at the shaft over su. D is
the radial deviator, radial stress less mean stress, averaged over the 0.06 R; tension is positive.
A table over rigidity index and adhesion factor has S, C, D and the half width of S h + C; another
has the other half widths (`measured`). S and C are those at an inertia rho V^2 / su of 0.1 and a
Poisson's ratio of 0.47, between which and other values they differ by less than their half widths.
Where cells grow by more than 0.5 nothing is known. `README.md` says how all of it was measured.
"""

import numpy as np

from mpm_warp.uncertainty.laws import window_uncertainty
from mpm_warp.uncertainty.tables import Table, Value, effects, root_sum_square

RADIAL_STRESS, RADIAL_FACTOR = "excess_radial_stress_shaft", "radial_stress_factor_shaft"
"""Names in a dataset: the curve of the radial stress on the shaft, and F, its mean at the end over
su."""
TABLE = Table.of("u2")
EFFECTS = effects("pressure_effects")
MEASURED_POISSONS_RATIO, WIDE_CELL = 0.47, 0.385
"""Poisson's ratio for which C holds; width of cells from which on the half width grows faster."""
LARGEST_GROWTH = 0.5
"""Growth of the cells up to which the laws of u1 and u2 hold. They were measured at 0.4."""


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
    slope = TABLE.at("slope", rigidity_index, adhesion_factor)
    excess = excess_at_filter(
        rigidity_index=rigidity_index,
        adhesion_factor=adhesion_factor,
        stress_anisotropy=stress_anisotropy,
        strength_ratio=strength_ratio,
    )
    left = {name.removeprefix("u2_"): effect.half_width for name, effect in EFFECTS.items()}
    half_width = root_sum_square(
        TABLE.at("half_width", rigidity_index, adhesion_factor),
        left["mesh"] * cell_size * radial,
        left["wide_cells"] * max(0.0, cell_size - WIDE_CELL) * radial,
        left["anisotropy"] * np.abs(stress_anisotropy),
        left["softening"] * (1.0 - strength_ratio),
        left["poisson"] * (poissons_ratio - MEASURED_POISSONS_RATIO),
        left["inertia"] * inertia,
        left["range"] * TABLE.beyond(rigidity_index),
        window_uncertainty(extent_ratio),
    )
    return radial - slope * cell_size + excess, half_width


def excess_at_filter(
    *,
    rigidity_index: Value,
    adhesion_factor: Value,
    stress_anisotropy: Value = 0.0,
    strength_ratio: Value = 1.0,
) -> Value:
    """u2 less F on the finest meshes, over su, shape [...]; arguments as in `shoulder_pressure`."""
    clay = rigidity_index, adhesion_factor
    by_anisotropy = EFFECTS["u2_anisotropy"].size * np.abs(stress_anisotropy)
    of_softening = (strength_ratio - 1.0) * TABLE.at("deviator", *clay)
    return TABLE.at("excess", *clay) + by_anisotropy + of_softening
