"""Momentum of nodes by the consistent mass matrix, for waves that are to keep their energy.

Particles that have their velocity from nodes have the momentum of the consistent mass matrix, sum m
N_i N_j; divided by the lumped one, sum m N_i, it makes a smoother velocity than the nodes had. As
the force of a step acts on the nodes at once, and comes back from the particles smoothed, waves are
damped. So the nodes are given the difference of the two matrices times their velocity of the step
before (Burgess, Sulsky & Brackbill 1992, J. Comput. Phys. 103:1-15, solve with the consistent
one): all that `mpm_warp.step.mass_matrix_correction` gives back a part of, at the cost of a pass.

Symbols: m mass of a particle, N_i shape function of node i at it, v_i velocity of the node after
the step before.

    (m v)_i <- (m v)_i + sum m N_i (v_i - sum_j N_j v_j)
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.grid.location import make_location
from mpm_warp.precision import Precision


@functools.cache
def make_consistent_mass(precision: Precision) -> Any:
    """The kernel, launched over particles of a grid with horizontal rows."""
    real, vec2, vec3, vec4 = precision.real, precision.vec2, precision.vec3, precision.vec4
    vec5 = precision.vec5
    natural = make_location(False, precision).natural
    one = wp.constant(real(1.0))

    @wp.func
    def share(m: real, v_i: vec4, v: vec4) -> vec4:
        return m * vec4(real(0.0), v_i[0] - v[0], v_i[1] - v[1], real(0.0))

    @wp.kernel(module=f"mpm_warp.consistent_mass.{precision.numpy_name}", enable_backward=False)
    def consistent_mass(
        first: int,
        position: wp.array(dtype=vec2),
        mass: wp.array(dtype=real),
        particle_cell: wp.array(dtype=wp.vec2i),
        columns: wp.array(dtype=vec3),
        rows: wp.array(dtype=vec5),
        outer_radius: real,
        column_count: int,
        motion: wp.array(dtype=vec4),
        momentum: wp.array(dtype=vec4),
    ):
        p = first + wp.tid()
        i, j = particle_cell[p][0], particle_cell[p][1]
        where = natural(position[p], columns[i], rows[j], outer_radius)
        xi, eta = where[0], where[1]
        node = j * (column_count + 1) + i
        upper = node + column_count + 1
        v_00, v_10, v_01, v_11 = motion[node], motion[node + 1], motion[upper], motion[upper + 1]
        m_00, m_10 = (one - xi) * (one - eta) * mass[p], xi * (one - eta) * mass[p]
        m_01, m_11 = (one - xi) * eta * mass[p], xi * eta * mass[p]
        v = (m_00 * v_00 + m_10 * v_10 + m_01 * v_01 + m_11 * v_11) / mass[p]
        wp.atomic_add(momentum, node, share(m_00, v_00, v))
        wp.atomic_add(momentum, node + 1, share(m_10, v_10, v))
        wp.atomic_add(momentum, upper, share(m_01, v_01, v))
        wp.atomic_add(momentum, upper + 1, share(m_11, v_11, v))

    return consistent_mass
