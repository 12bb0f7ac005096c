"""Stage 1: particles give mass and momentum to nodes, and stress to cells.

Symbols: m mass, v velocity, sigma stress, N_i shape function of node i at the particle.

    m_i       = sum m N_i
    (m v)_i   = sum m N_i v
    sigma_c   = sum m sigma / sum m            the mean over the cell; divided in stage 2
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.grid.location import make_location
from mpm_warp.precision import Precision


@functools.cache
def make_particles_to_grid(polar: bool, window: bool, precision: Precision) -> Any:
    """The kernel, launched over particles.

    Args:
        polar: whether the grid is one of rings and rays.
        window: whether there are places without a particle, to be passed over.
        precision: floating point types.
    """
    real, vec2, vec3, vec4 = precision.real, precision.vec2, precision.vec3, precision.vec4
    vec5 = precision.vec5
    natural = make_location(polar, precision).natural
    zero, one = wp.constant(real(0.0)), wp.constant(real(1.0))

    @wp.func
    def share(m: real, v: vec2) -> vec4:
        # (mass, momentum, 0): four numbers are added in one instruction.
        return vec4(m, m * v[0], m * v[1], zero)

    key = f"{'polar' if polar else 'rows'}.{'window' if window else 'closed'}"
    key = f"{key}.{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.particles_to_grid.{key}", enable_backward=False)
    def particles_to_grid(
        first: int,
        position: wp.array(dtype=vec2),
        velocity: wp.array(dtype=vec2),
        stress: wp.array(dtype=vec4),
        mass: wp.array(dtype=real),
        particle_cell: wp.array(dtype=wp.vec2i),
        columns: wp.array(dtype=vec3),
        rows: wp.array(dtype=vec5),
        outer_radius: real,
        column_count: int,
        node_momentum: wp.array(dtype=vec4),
        cell_stress_sum: wp.array(dtype=vec4),
        cell_mass: wp.array(dtype=real),
    ):
        p = first + wp.tid()
        cell = particle_cell[p]
        i, j = cell[0], cell[1]
        if wp.static(window):
            if i < 0:
                return
        where = natural(position[p], columns[i], rows[j], outer_radius)
        xi, eta = where[0], where[1]
        m = mass[p]

        c = j * column_count + i
        wp.atomic_add(cell_stress_sum, c, m * stress[p])
        wp.atomic_add(cell_mass, c, m)

        v = velocity[p]
        node = j * (column_count + 1) + i
        upper = node + column_count + 1
        wp.atomic_add(node_momentum, node, share((one - xi) * (one - eta) * m, v))
        wp.atomic_add(node_momentum, node + 1, share(xi * (one - eta) * m, v))
        wp.atomic_add(node_momentum, upper, share((one - xi) * eta * m, v))
        wp.atomic_add(node_momentum, upper + 1, share(xi * eta * m, v))

    return particles_to_grid
