"""What a cone test is likely to fail by: soil is thrown off, or waves grow from row to row."""

import math

from mpm_warp.materials.material import Material

SANE_INERTIA, GREATEST_INERTIA, REFUSED_INERTIA = 5.0, 10.0, 50.0
"""Limits of rho V^2 / su. Up to the first nearly all random cases complete. Beyond the second few
do on coarse cells: soil is thrown off, and the transfers dissipate much of the work. Beyond the
third none of 98 did."""
CELLS_AT_SPEED = 1.8
"""Cells per radius below which cells are coarse in this sense: with fewer 23 of 85 cases complete,
with more 46 of 63."""
MANY_ROWS, SPEED_OF_MANY_ROWS, STEP_OF_MANY_ROWS = 550, 0.08, 0.125
"""Number of rows above which waves grow from row to row (`mpm_warp.step.momentum`), and what
prevents it: a speed over that of shear waves, or a path of shear waves in one step over the height
of a row. Two of 5 cases in 663 rows lost over a fifth of their work, as did all of 6 in more rows;
none did in 465."""


def thrown_off(rigidity_index: float, inertia: float, limit: float, scale: float = 1.0) -> str:
    """Message that the cone is above a limit of rho V^2 / su, with a speed to try.

    A scene whose speed is over that of other waves has another `scale` than 1.
    """
    speed_ratio = scale * math.sqrt(SANE_INERTIA / rigidity_index)
    return (
        f"rho V^2 is {inertia:.3g} su, and above {limit:g} su soil is thrown off; "
        f"try speed_ratio = {speed_ratio:.2g} or less"
    )


def growing_waves(
    rows: int,
    soil: Material,
    *,
    speed_ratio: float,
    approach_speed_ratio: float,
    time_step_fraction: float,
    scale: float,
) -> str:
    """Message that waves grow in so many rows of cells, with what to change; "" where they do not.

    The speeds are over that of shear waves, that of the approach 0 without one. For `scale` see
    `thrown_off`.
    """
    fastest = max(speed_ratio, approach_speed_ratio)
    small_step = STEP_OF_MANY_ROWS * soil.pressure_wave_speed / soil.shear_wave_speed
    if rows <= MANY_ROWS or fastest <= SPEED_OF_MANY_ROWS or time_step_fraction <= small_step:
        return ""
    speeds = "speed_ratio and approach_speed_ratio" if approach_speed_ratio > 0.0 else "speed_ratio"
    return (
        f"soil crosses {rows} rows of cells at {fastest:.2g} of the speed of shear waves, and "
        f"waves grow from row to row; try {speeds} = {scale * SPEED_OF_MANY_ROWS:.2g} or less, "
        f"or time_step_fraction = {math.floor(10.0 * small_step) / 10.0:g}"
    )
