"""A smooth inner wall that moves outward, and the grid that follows it.

Symbols: s radius of the wall, R outer radius, g column coordinate, a and w inner radius and width
of a cell, h its height, N shape functions. For a cell with vertical sides, per radian,

    integral of dN/dr r = -+ (a + w/2) h / 2       at the inner and outer nodes
    integral of dN/dz r = -+ w (a/2 + w/6)         below and above, inner;  w (a/2 + w/3)  outer
    integral of N       = w h / 4

For a sector of a ring they are products of integrals over distance rho and angle t. With f and g
the linear shape functions along rho and t, P = integral of f' rho^2, Q = integral of f rho:

    integral of dN/dr r = P (g sin^2) + Q (g' sin cos)
    integral of dN/dz r = P (g sin cos) - Q (g' sin^2)
    integral of N       = Q (g)
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.grid.fitted import cell_lengths
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.kernel_types import half, kernel, one, quarter, real, third, vec2, vec3, vec4, vec5
from mpm_warp.parts.window import MovingGrid, RampedMotion
from mpm_warp.plan.plan import Plan, TimeStepControl
from mpm_warp.scene import Scene, refuse_together

sixth = wp.constant(real(1.0 / 6.0))


@dataclass(frozen=True, kw_only=True)
class MovingWall(RampedMotion):
    """A smooth cylindrical or spherical wall, the first column of nodes, that moves outward.

    The columns up to the outer radius move closer in proportion; soil passes from cell to cell.

    Example:
        >>> MovingWall(speed=0.1, ramp_travel=0.01)
        MovingWall(speed=0.1, ramp_travel=0.01)
    """

    not_beside = ((MovingGrid, ""),)

    def check(self, scene: Scene) -> None:
        """Check that wall and columns are upright, and that the soil is uniform."""
        grid = scene.grid
        for is_there, what in (
            (grid.planar or np.ptp(grid.surface_radius) > 0.0, "a grid that leans or is plane"),
            (grid.columns[-1] > 1.0, "columns beyond the fitted radius"),
            (scene.material.variation is not None, "a material that varies"),
        ):
            refuse_together("MovingWall", is_there, what)

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Make the time step follow the cells, which become narrower."""
        speed = scene.material.pressure_wave_speed

        def shortest_crossing_time(array: Callable[[str], NDArray[Any]]) -> float:
            lengths = cell_lengths(array("cell.integrals"), array("cell.volume"))
            return float(lengths.min()) / speed

        plan.control = TimeStepControl(
            first=plan.time_step, fraction=scene.time_step_fraction, critical=shortest_crossing_time
        )

    def add_contact(self, plan: Plan, scene: Scene) -> None:
        """Add the launch by which the wall pushes the soil, over rows of nodes.

        The array "wall.motion" holds (time [s], speed [m/s], radius [m]) of the wall for each row,
        "wall.impulse" the impulse of the soil on each node since it was last cleared.
        """
        grid = scene.grid
        motion = np.zeros((grid.row_count + 1, 3))
        motion[:, 2] = grid.surface_radius
        plan.add_array("wall.motion", "vec3", motion)
        plan.add_array("wall.outward", "vec2", grid.surface_normals)
        plan.add_zeros("wall.impulse", "real", grid.row_count + 1)
        plan.add_launch(push, grid.row_count + 1)

    def add_after_motion(self, plan: Plan, scene: Scene) -> None:
        """Add the launches that move the wall and update the cells, at the end of a step."""
        grid = scene.grid
        plan.add_launch(move_wall, grid.row_count + 1, speed=self.speed, ramp_time=self.ramp_time)
        if isinstance(grid, PolarGrid):
            angular, caps = grid.angular_integrals
            plan.add_array("wall.angular", "vec5", angular)
            plan.add_array("wall.caps", "real", caps)
            plan.add_launch(refit_sectors, grid.cell_count)
        else:
            plan.add_launch(refit_cells, grid.cell_count)


@kernel
def move_wall(
    time_step: real,
    speed: real,
    ramp_time: real,
    wall_motion: wp.array[vec3],
    grid_rows: wp.array[vec5],
):
    """Move the wall by a step; its speed rises linearly in time. Launched over rows of nodes."""
    j = wp.tid()
    before = wall_motion[j]
    time = before[0] + time_step
    radius = before[2] + time_step * before[1]
    wall_motion[j] = vec3(time, speed * wp.min(time / ramp_time, one), radius)
    row = grid_rows[j]
    grid_rows[j] = vec5(row[0], row[1], row[2], radius, row[4])


@kernel
def refit_cells(
    offset: int,
    grid_columns: wp.array[vec3],
    grid_rows: wp.array[vec5],
    fitted_radius: real,
    column_count: int,
    cell_integrals: wp.array2d[vec3],
    cell_volume: wp.array[real],
):
    """Integrals and volumes of the cells after the wall has moved; launched over cells."""
    c = offset + wp.tid()
    column = grid_columns[c % column_count]
    row = grid_rows[c / column_count]
    a = row[3] + (fitted_radius - row[3]) * column[0]
    w = (fitted_radius - row[3]) * column[1]
    h = row[1]
    across = half * (a + half * w) * h
    inner, outer = w * (half * a + sixth * w), w * (half * a + third * w)
    hoop = quarter * w * h
    cell_integrals[c, 0] = vec3(-across, -inner, hoop)
    cell_integrals[c, 1] = vec3(across, -outer, hoop)
    cell_integrals[c, 2] = vec3(-across, inner, hoop)
    cell_integrals[c, 3] = vec3(across, outer, hoop)
    cell_volume[c] = (a + half * w) * w * h


@wp.func
def part(P: real, Q: real, t: vec5) -> vec3:
    """Integrals of a node from those over distance and angle."""
    return vec3(P * t[0] + Q * t[1], P * t[2] - Q * t[3], Q * t[4])


@kernel
def refit_sectors(
    offset: int,
    grid_columns: wp.array[vec3],
    grid_rows: wp.array[vec5],
    fitted_radius: real,
    column_count: int,
    wall_angular: wp.array2d[vec5],
    wall_caps: wp.array[real],
    cell_integrals: wp.array2d[vec3],
    cell_volume: wp.array[real],
):
    """The same for the cells of a polar grid, by its `angular_integrals`; launched over cells."""
    c = offset + wp.tid()
    j = c / column_count
    column = grid_columns[c % column_count]
    row = grid_rows[j]
    a = row[3] + (fitted_radius - row[3]) * column[0]
    w = (fitted_radius - row[3]) * column[1]
    P = a * a + a * w + third * w * w
    inner, outer = w * (half * a + sixth * w), w * (half * a + third * w)
    cell_integrals[c, 0] = part(-P, inner, wall_angular[j, 0])
    cell_integrals[c, 1] = part(P, outer, wall_angular[j, 0])
    cell_integrals[c, 2] = part(-P, inner, wall_angular[j, 1])
    cell_integrals[c, 3] = part(P, outer, wall_angular[j, 1])
    cell_volume[c] = P * w * wall_caps[j]


@kernel
def push(
    column_count: int,
    wall_motion: wp.array[vec3],
    wall_outward: wp.array[vec2],
    node_mass: wp.array[real],
    node_velocities: wp.array[vec4],
    wall_impulse: wp.array[real],
):
    """Give nodes the normal velocity of the wall and add up its impulses; over rows of nodes."""
    j = wp.tid()
    node = j * (column_count + 1)
    v = node_velocities[node]
    n = wall_outward[j]
    change = wall_motion[j][1] - (v[0] * n[0] + v[1] * n[1])
    wall_impulse[j] += node_mass[node] * change
    node_velocities[node] = vec4(v[0] + change * n[0], v[1] + change * n[1], v[2], v[3])
