"""What the method of a cone test is by default, each a function of the clay.

Laws that take the error of a method off allow a method of less cost. They are known of Tresca clay.
"""

import math

from mpm_warp.uncertainty.laws import LARGEST_INERTIA
from mpm_warp.uncertainty.steadiness import steady_penetration

CELLS_PER_RADIUS = {
    "quick": (2.31, 1.75, 1.75),
    "standard": (3.46, 3.0, 2.31),
    "fine": (6.0, 6.0, 4.62),
}
"""Cells per cone radius by accuracy in soft, ordinary and very stiff clay: 3 to 10 rows beside the
face. Clay for which no law of the error holds counts as ordinary. In soft clay the cone factor is
small and tests are short; in very stiff clay the factor is large and tests are long."""
WINDOW = {"quick": 0.75, "standard": 1.0, "fine": 1.3}
SPEED_RATIO = {"quick": 0.045, "standard": 0.03, "fine": 0.03}
"""Extents of the window over those of `extents`, and speed over that of shear waves in
stiff clay, by accuracy."""
INERTIA_BY_ACCURACY = {"quick": LARGEST_INERTIA, "fine": 0.2}
"""Largest rho V^2 / su at that speed, by accuracy. quick: the largest whose effect is known. fine:
one whose effect has a half width of 0.01."""
ROUNDING = 1e-9
"""Relative margin below these limits, so that rounding never exceeds them."""
BULK_MODULUS = {"quick": 250.0, "standard": 5e3, "fine": 1e4}
"""Largest bulk modulus over su that is simulated by default, by accuracy. A lower one allows longer
time steps."""
COMPRESSIBLE, INCOMPRESSIBLE = 0.45, 0.4999
"""Smallest and largest default of the bound of Poisson's ratio."""
SOFT_BOUND = 0.475
"""Largest default of this bound in soft clay, accuracy standard."""
STIFF, VERY_STIFF = 100.0, 300.0
"""Rigidity indices below which clay is soft, and above which it is very stiff."""
SOFT_SPEED_RATIO = 0.05
"""Largest default speed in soft clay, over the speed of shear waves."""
SPARE = 4.5
"""Penetration kept in reserve for a resistance that becomes steady late, in cone radii."""
INERTIA_OF_APPROACH, SPEED_RATIO_OF_APPROACH = 7.0, 0.25
"""Largest rho V^2 / su and largest V over the speed of shear waves of the default approach."""
RAMP, SLOWING = 1.0, 2.0
"""Penetration over which the speed rises from rest, and over which it falls to the final speed
after the approach, in cone radii."""
BLUNTEST_WITH_FEW_ROWS = 75.0
"""Apex angle [degree] up to which a cone has three rows beside its face, 2.31 cells per radius."""
BLUNT, INERTIA_OF_BLUNT_APPROACH = 90.0, 1.4
"""Apex angle [degree] above which the default approach is slower, and its largest rho V^2 / su
then. At 6, soil is thrown off the tip of a rough cone of 120 degrees on four rows of cells beside
its face."""


def extents(rigidity_index: float) -> dict[str, float]:
    """Extents of the window over cone radius: the resistance hardly depends on them."""
    root = math.sqrt(rigidity_index)
    return {
        "domain_radius": max(40.0, 4.0 * root),
        "domain_above": max(13.0, 1.3 * root),
        "domain_below": max(14.0, root),
    }


def cells_per_radius(rigidity_index: float, accuracy: str, *, is_corrected: bool) -> float:
    """Cells per cone radius, by `CELLS_PER_RADIUS`."""
    soft, ordinary, very_stiff = CELLS_PER_RADIUS[accuracy]
    if not is_corrected:
        return ordinary
    if rigidity_index < STIFF:
        return soft
    return very_stiff if rigidity_index > VERY_STIFF else ordinary


def speed_ratio(rigidity_index: float, accuracy: str, *, is_tresca: bool) -> float:
    """Speed over that of shear waves.

    In soft clay the standard speed is higher, so that the inertia rho V^2 / su is the same as
    in stiff clay. This holds only where a law corrects the effect of inertia, in Tresca clay.
    quick tests would gain little by it; fine tests have a small uncertainty to keep. In
    stiff clay both are slower where `INERTIA_BY_ACCURACY` demands it.
    """
    ratio = SPEED_RATIO[accuracy]
    if not is_tresca:
        return ratio
    if accuracy != "standard":
        greatest = (1.0 - ROUNDING) * INERTIA_BY_ACCURACY[accuracy]
        return min(ratio, math.sqrt(greatest / rigidity_index))
    of_same_inertia = ratio * math.sqrt(STIFF / rigidity_index)
    return max(ratio, min(of_same_inertia, SOFT_SPEED_RATIO))


def poissons_ratio_bound(rigidity_index: float, accuracy: str, *, is_corrected: bool) -> float:
    """Bound of Poisson's ratio, from `BULK_MODULUS`.

    There is a bound only where laws correct its effect. It is lower in soft clay, which is
    simulated with smaller cells.
    """
    if not is_corrected:
        return INCOMPRESSIBLE
    over_shear = BULK_MODULUS[accuracy] / rigidity_index
    of_bulk_modulus = (3.0 * over_shear - 2.0) / (6.0 * over_shear + 2.0)
    has_more_cells = rigidity_index < STIFF and accuracy == "standard"
    greatest = SOFT_BOUND if has_more_cells else INCOMPRESSIBLE
    return min(greatest, max(COMPRESSIBLE, of_bulk_modulus))


def approach_speed_ratio(rigidity_index: float, apex_angle: float) -> float:
    """Speed of the approach over that of shear waves; less before a blunt cone."""
    inertia = INERTIA_OF_BLUNT_APPROACH if apex_angle > BLUNT else INERTIA_OF_APPROACH
    return min(SPEED_RATIO_OF_APPROACH, math.sqrt(inertia / rigidity_index))


def penetration(rigidity_index: float, approach: float) -> float:
    """Penetration over cone radius by which the resistance is steady after an approach."""
    return approach + steady_penetration(rigidity_index) + SPARE
