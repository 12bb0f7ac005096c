"""What only a scene with a moving wall has: its push on the soil, and a grid that follows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grid.fitted import cell_lengths
from mpm_warp.parts.moving_wall_kernels import (
    make_move_wall,
    make_push,
    make_refit_cells,
    make_refit_sectors,
)
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.plan.plan import OFFSET, Plan
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.scene import Scene


def crossing_time(scene: Scene, array: Callable[[str], NDArray[Any]]) -> float:
    """Time in which a wave crosses the shortest cell [s], as the wall has left them.

    Args:
        scene: what is run.
        array: gives an array of the plan as it is now, by its name.
    """
    lengths = cell_lengths(array("cell.integrals"), array("cell.volume"))
    return float(lengths.min()) / scene.material.pressure_wave_speed


def add_wall_push(plan: Plan) -> None:
    """The wall pushes the soil beside it."""
    grid = plan.scene.grid
    motion = np.zeros((grid.row_count + 1, 3))
    motion[:, 2] = grid.surface_radius
    plan.add_array("wall.motion", "vec3", motion)
    plan.add_array("wall.outward", "vec2", grid.surface_normals)
    plan.add_zeros("wall.impulse", "real", grid.row_count + 1)
    plan.add_launch(
        make_push(plan.precision),
        grid.row_count + 1,
        *(
            grid.column_count,
            "wall.motion",
            "wall.outward",
            "node.mass",
            "node.motion",
            "wall.impulse",
        ),
    )


def add_wall_motion(plan: Plan, wall: MovingWall) -> None:
    """The wall moves at the end of the step, and the cells draw together."""
    grid = plan.scene.grid
    plan.add_launch(
        make_move_wall(plan.precision),
        grid.row_count + 1,
        *(plan.time_step, wall.speed, wall.ramp_time, "wall.motion", "grid.rows"),
    )
    geometry = ("grid.columns", "grid.rows", grid.outer_radius, grid.column_count)
    if isinstance(grid, PolarGrid):
        angular, caps = grid.angular_integrals
        plan.add_launch(
            make_refit_sectors(plan.precision),
            grid.cell_count,
            OFFSET,
            *geometry,
            plan.add_array("wall.angular", "vec5", angular),
            plan.add_array("wall.caps", "real", caps),
            *("cell.integrals", "cell.volume"),
        )
    else:
        kernel = make_refit_cells(plan.precision)
        plan.add_launch(kernel, grid.cell_count, OFFSET, *geometry, "cell.integrals", "cell.volume")
