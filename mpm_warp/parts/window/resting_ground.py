"""The ground outside a cyclic window: it rests, and is in the grid again when this comes back.

The soil of the whole stroke is there from the start: that of the grid, and that below it. A point
that the grid has left keeps its place in the ground, its stress and its memory, and has no speed.
Seen from the grid, which moves down by V, it passes by:

    x <- x + dt V e_z,      v = 0           outside: cell (-1, -1)

It comes back in the column that it left: what rests does not go sideways.
"""

import functools
import math
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.grid.fitted import Grid
from mpm_warp.grid.seeding import seed_rows
from mpm_warp.parts.part import Setting
from mpm_warp.parts.window.window import height_of_leaving
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision

RESTING_COLUMN = "particle.resting_column"
"""Column of cells in which a particle left the grid, -1 while it is in it; shape [slot_count]."""


def rows_below(grid: Grid, stroke: float) -> int:
    """Rows of soil below a grid, as high as the lowest of its own, that fill a stroke [m]."""
    return math.ceil(stroke / float(grid.rows[1] - grid.rows[0]))


def add_ground_below(plan: Plan, setting: Setting) -> None:
    """Put the soil below the grid into the empty slots of a plan, which are as many as it needs."""
    grid = setting.grid
    position, mass, cell = (
        plan.arrays[f"particle.{name}"].initial for name in ("position", "mass", "cell")
    )
    assert position is not None
    assert mass is not None
    assert cell is not None
    row = seed_rows(grid, 0, 1, setting.particles_per_side)
    empty = np.flatnonzero(cell[:, 0] < 0)
    depth, in_row = np.divmod(np.arange(len(empty)), row.particle_count)
    position[empty] = row.position[in_row]
    position[empty, 1] -= (1 + depth) * (grid.rows[1] - grid.rows[0])
    mass[empty] = setting.material.density * row.volume[in_row]
    column = np.full(len(cell), -1)
    column[empty] = row.cell[in_row, 0]
    plan.add_array(RESTING_COLUMN, "int", column, (grid.column_count,), may_be_none=True)


def add_resting_ground(plan: Plan, setting: Setting) -> None:
    """Add the launch by which particles leave the grid and come back, after they have moved."""
    grid = setting.grid
    plan.add_launch(
        _make_leave_and_return(plan.precision),
        plan.arrays["particle.mass"].shape,
        bottom=float(grid.rows[0]),
        top=height_of_leaving(setting),
        highest_row=grid.row_count - 1,
    )


@functools.cache
def _make_leave_and_return(precision: Precision) -> Any:
    """The kernel, launched over slots of particles."""
    real, vec2 = precision.real, precision.vec2

    @wp.kernel(module=f"mpm_warp.leave_and_return.{precision.numpy_name}", enable_backward=False)
    def leave_and_return(
        offset: int,
        time_step: real,
        bottom: real,
        top: real,
        highest_row: int,
        window_motion: wp.array(dtype=wp.float64),
        particle_position: wp.array(dtype=vec2),
        particle_velocity: wp.array(dtype=vec2),
        particle_cell: wp.array(dtype=wp.vec2i),
        particle_resting_column: wp.array(dtype=int),
    ):
        p = offset + wp.tid()
        x = particle_position[p]
        column = particle_resting_column[p]
        if column >= 0:
            x += vec2(real(0.0), time_step * real(window_motion[1]))
            particle_position[p] = x
            if x[1] >= bottom and x[1] < top:
                row = 0
                if x[1] > real(0.5) * (bottom + top):
                    row = highest_row
                particle_cell[p] = wp.vec2i(column, row)
                particle_resting_column[p] = -1
        elif x[1] < bottom or x[1] >= top:
            particle_velocity[p] = vec2(real(0.0))
            particle_resting_column[p] = particle_cell[p][0]
            particle_cell[p] = wp.vec2i(-1, -1)

    return leave_and_return
