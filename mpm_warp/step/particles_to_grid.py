"""Stage 1: particles give mass and momentum to nodes, and stress to cells.

Symbols: m mass, v velocity, sigma stress, N_i shape function of node i at the particle.

    m_i       = sum m N_i
    (m v)_i   = sum m N_i v
    sigma_c   = sum m sigma / sum m            the mean over the cell; divided in stage 2
"""

import functools
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.grid.fitted import Grid
from mpm_warp.grid.location import make_location
from mpm_warp.kernel_types import kernel, one, real, vec2, vec3, vec4, vec5, zero
from mpm_warp.plan.launch import ShareRow
from mpm_warp.plan.plan import Plan


def add_particles_to_grid(plan: Plan, grid: Grid, *, has_empty_slots: bool) -> None:
    """Add the stage, and the sums and the places of rows and columns that it needs."""
    width = np.append(np.diff(grid.columns), 1.0)
    height = np.append(np.diff(grid.rows), 1.0)
    lean = np.append(np.diff(grid.surface_radius), 0.0)
    columns = np.stack([grid.columns, width, 1.0 / width], axis=-1)
    rows = np.stack([grid.rows, height, 1.0 / height, grid.surface_radius, lean], axis=-1)
    plan.add_array("grid.columns", "vec3", columns)
    plan.add_array("grid.rows", "vec5", rows)
    plan.add_zeros("cell.stress_sum", "vec4", (plan.share_count, grid.cell_count))
    plan.add_zeros("cell.mass", "real", (plan.share_count, grid.cell_count))
    plan.add_zeros("node.momentum", "vec4", (plan.share_count, grid.node_count))
    plan.add_launch(
        _make_particles_to_grid(grid.polar, has_empty_slots),
        plan.arrays["particle.mass"].shape,
        fitted_radius=grid.fitted_radius,
        column_count=grid.column_count,
        node_momentum=ShareRow("node.momentum"),
        cell_stress_sum=ShareRow("cell.stress_sum"),
        cell_mass=ShareRow("cell.mass"),
    )


@functools.cache
def _make_particles_to_grid(polar: bool, has_empty_slots: bool) -> Any:
    """The kernel, launched over slots of particles."""
    natural = make_location(polar).natural

    @wp.func
    def share(m: real, v: vec2) -> vec4:
        # (mass, momentum, 0): four numbers are added in one instruction.
        return vec4(m, m * v[0], m * v[1], zero)

    @kernel
    def particles_to_grid(
        offset: int,
        particle_position: wp.array(dtype=vec2),
        particle_velocity: wp.array(dtype=vec2),
        particle_stress: wp.array(dtype=vec4),
        particle_mass: wp.array(dtype=real),
        particle_cell: wp.array(dtype=wp.vec2i),
        grid_columns: wp.array(dtype=vec3),
        grid_rows: wp.array(dtype=vec5),
        fitted_radius: real,
        column_count: int,
        node_momentum: wp.array(dtype=vec4),
        cell_stress_sum: wp.array(dtype=vec4),
        cell_mass: wp.array(dtype=real),
    ):
        p = offset + wp.tid()
        cell = particle_cell[p]
        i, j = cell[0], cell[1]
        if wp.static(has_empty_slots):
            if i < 0:
                return
        where = natural(particle_position[p], grid_columns[i], grid_rows[j], fitted_radius)
        xi, eta = where[0], where[1]
        m = particle_mass[p]

        c = j * column_count + i
        wp.atomic_add(cell_stress_sum, c, m * particle_stress[p])
        wp.atomic_add(cell_mass, c, m)

        v = particle_velocity[p]
        node = j * (column_count + 1) + i
        upper = node + column_count + 1
        wp.atomic_add(node_momentum, node, share((one - xi) * (one - eta) * m, v))
        wp.atomic_add(node_momentum, node + 1, share(xi * (one - eta) * m, v))
        wp.atomic_add(node_momentum, upper, share((one - xi) * eta * m, v))
        wp.atomic_add(node_momentum, upper + 1, share(xi * eta * m, v))

    return particles_to_grid
