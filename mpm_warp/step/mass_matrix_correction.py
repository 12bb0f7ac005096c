"""Mass-matrix correction: what the transfer to particles and back takes at the least, given back.

A field that particles have from the nodes comes back to them smoothed, as if it had diffused: each
particle spreads its momentum over the nodes of its cell. That takes the mean of xi (1 - xi) over
the particles of a cell, times second differences. The operator S gives back the part k of it that
is taken wherever the particles are: k = (1 - 1/n^2) / 6 for n equal points along a side.

Symbols: v_ij velocity of the nodes of a cell after the step before, X and Y its differences across
and up, rho density, V volume of a cell, m_i mass of a node, M_i half a quarter of that of the full
cells around it.

    u_i     = (m v)_i / m_i + (S v)_i / max(m_i, 2 M_i)         velocity before the step
    (S v)_i = sum over cells (+-X +-Y) k rho V / 4     + at the right and at the upper nodes, else -
    X, Y    = v_10 - v_00 + v_11 - v_01,  v_01 - v_00 + v_11 - v_10

Why so much: of a motion that alternates from node to node the particles return the share P, 1/4 to
1/2 for n = 2, and S the share A, 1/2. The force f acts on the nodes at once, and on what comes back
one step later: v' = v + f - q, q' = A q + (1 - A - P) f. An oscillator is then stable up to 0.93 of
the critical time step, without S up to 0.76 of it, and at no time step where A + P > 1. With the
affine part of a particle's momentum instead (Jiang et al. 2015, ACM Trans. Graph. 34(4):51), which
returns all of a linear field, but what it takes from one motion for another not the other way,
waves of pressure grew that alternate between wide, flat cells of nearly incompressible soil.

In cells that are filled in part P may be anything: there is no S where a free surface passes, or
only far below it (`mpm_warp.parts.free_surface`).
"""

import warp as wp

from mpm_warp.kernel_types import one, real, vec2, vec4


@wp.func
def correction_of_cell(v_00: vec4, v_10: vec4, v_01: vec4, v_11: vec4, weight: real) -> vec4:
    """(X, Y) of a cell times its weight k rho V / 4; v_ij is (v_r, v_z, ...) of a node."""
    rising, falling = weight * (v_11 - v_00), weight * (v_10 - v_01)
    X, Y = rising + falling, rising - falling
    return vec4(X[0], X[1], Y[0], Y[1])


@wp.func
def corner(cell: vec4, across: real, up: real) -> vec2:
    """What a cell gives to one of its nodes; the signs say to which."""
    return across * vec2(cell[0], cell[1]) + up * vec2(cell[2], cell[3])


@wp.func
def correction_at_node(
    cells: wp.array(dtype=vec4), i: int, j: int, column_count: int, row_count: int
) -> vec2:
    """(S v)_i of the node in column i and row j, of the results of `correction_of_cell`."""
    total = vec2()
    cell = j * column_count + i
    if j < row_count:
        if i < column_count:
            total += corner(cells[cell], -one, -one)
        if i > 0:
            total += corner(cells[cell - 1], one, -one)
    if j > 0:
        cell -= column_count
        if i < column_count:
            total += corner(cells[cell], -one, one)
        if i > 0:
            total += corner(cells[cell - 1], one, one)
    return total
