"""Stage 3: the momentum equation of the nodes.

Symbols: sigma stress of a cell (rr, zz, rz, tt), m mass of a node, M half the mass it has when the
cells around it are full, u and v velocity before and after the step, G_i integrals over a cell of
(dN_i/dr r, dN_i/dz r, N_i), S mass-matrix correction, v_ij velocity of the nodes of a cell after
the last step, rho density, V volume of the cell.

    f_i     = - sum over cells (sigma_rr G_r + sigma_rz G_z + sigma_tt G_t,
                                sigma_rz G_r + sigma_zz G_z)
    u_i     = (m v)_i / m_i + (S v)_i / max(m_i, 2 M_i)
    v_i     = u_i + dt f_i / max(m_i, M_i)

The force is that of full cells, however few particles are near the node. So M bounds the
acceleration of a node with few particles.

Transfer from the nodes to particles and back smooths the velocity field, as diffusion does: each
particle spreads its momentum over the nodes of its cell. The loss is the mean of xi (1 - xi) over
the particles of a cell, times second differences of the velocity. The operator S restores the part
k that is lost at any position of the particles: k = (1 - 1/n^2) / 6 for n equal points along a
side.

    (S v)_i = sum over cells (+-X +-Y) k rho V / 4     + at the right and at the upper nodes, else -
    X, Y    = v_10 - v_00 + v_11 - v_01,  v_01 - v_00 + v_11 - v_10

Stability sets k. Of a motion that alternates from node to node the particles return the share P,
1/4 to 1/2 for n = 2, and S returns the share A, 1/2. The force f acts on the velocity of the nodes
at once, and on the returned velocity one step later: v' = v + f - q, q' = A q + (1 - A - P) f. An
oscillator is then stable up to 0.93 of the critical time step, without S up to 0.76 of it. Where
A + P > 1 it is unstable at every time step. The affine part of a particle's momentum (Jiang et al.
2015, ACM Trans. Graph. 34(4):51) is no alternative: it returns a linear field completely, but its
losses between two motions are not symmetric. With it, pressure waves that alternate between wide,
flat cells of nearly incompressible soil grew.

Soil that crosses the grid faster than 0.08 of the speed of shear waves makes short shear waves
grow, with 4 points a cell by up to 7 % a row, as S restores momentum of soil that has moved on. The
growth shows after hundreds of rows (`studies/stability.md`).

In partly filled cells P may have any value. So S acts only far below a free surface, or not at all
(`mpm_warp.parts.free_surface`).
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.kernel_types import half, kernel, maybe, one, real, vec2, vec3, vec4, zero
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene

ABSURD_SPEED = 100.0
"""Speed above which a node is left out of the step, over that of pressure waves."""


def add_momentum(plan: Plan, scene: Scene, *, corrected: bool) -> None:
    """Add the stage; `corrected`: with the mass-matrix correction."""
    grid = scene.grid
    plan.add_array("cell.integrals", "vec3", grid.gradient_integrals)
    # The least mass stays that of the initial cells where a wall moves.
    plan.add_array("node.least_mass", "real", 0.5 * scene.material.density * grid.node_volumes)
    plan.add_zeros("node.mass", "real", grid.node_count)
    plan.add_zeros("node.velocities", "vec4", grid.node_count)
    if corrected:
        plan.add_zeros("cell.correction", "vec4", grid.cell_count)
    plan.add_launch(
        _make_momentum(plan.share_count, corrected),
        (grid.row_count + 1, grid.column_count + 1),
        absurd_speed=ABSURD_SPEED * plan.speed_limit,
    )


@functools.cache
def _make_momentum(share_count: int, corrected: bool) -> Any:
    """The kernel, launched over (rows, columns) of nodes; it clears the sums of all shares.

    `node_velocities` is (v_r, v_z, u_r, u_z): velocity after the step and before it.
    """

    @wp.func
    def pull(stress: vec4, G: vec3) -> vec2:
        return vec2(
            stress[0] * G[0] + stress[2] * G[1] + stress[3] * G[2],
            stress[2] * G[0] + stress[1] * G[1],
        )

    @wp.func
    def correction(cells: wp.array[vec4], cell: int, across: real, up: real) -> vec2:
        # The correction of one node by a cell; the signs are those of the node.
        if wp.static(not corrected):
            return vec2()
        XY = cells[cell]
        return across * vec2(XY[0], XY[1]) + up * vec2(XY[2], XY[3])

    @kernel
    def momentum(
        offset: int,
        node_momentum: wp.array2d[vec4],
        cell_stress: wp.array[vec4],
        cell_integrals: wp.array2d[vec3],
        column_count: int,
        row_count: int,
        time_step: real,
        node_least_mass: wp.array[real],
        absurd_speed: real,
        cell_correction: maybe(vec4),
        node_mass: wp.array[real],
        node_velocities: wp.array[vec4],
    ):
        row, i = wp.tid()
        j = offset + row
        node = j * (column_count + 1) + i
        sums = vec4()
        for share in range(wp.static(share_count)):
            part = node_momentum[share, node]
            if part[0] != zero:
                sums += part
                node_momentum[share, node] = vec4()
        m = sums[0]
        node_mass[node] = m
        if m <= zero:
            node_velocities[node] = vec4()
            return
        force, given_back = vec2(), vec2()
        cell = j * column_count + i
        if j < row_count:
            if i < column_count:
                force -= pull(cell_stress[cell], cell_integrals[cell, 0])
                given_back += correction(cell_correction, cell, -one, -one)
            if i > 0:
                force -= pull(cell_stress[cell - 1], cell_integrals[cell - 1, 1])
                given_back += correction(cell_correction, cell - 1, one, -one)
        if j > 0:
            cell -= column_count
            if i < column_count:
                force -= pull(cell_stress[cell], cell_integrals[cell, 2])
                given_back += correction(cell_correction, cell, -one, one)
            if i > 0:
                force -= pull(cell_stress[cell - 1], cell_integrals[cell - 1, 3])
                given_back += correction(cell_correction, cell - 1, one, one)
        before = (one / m) * vec2(sums[1], sums[2])
        if wp.static(corrected):
            before += (half / wp.max(half * m, node_least_mass[node])) * given_back
        if not wp.dot(before, before) < absurd_speed * absurd_speed:
            # The node is left out until the watch finds the particle that has this velocity.
            node_velocities[node] = vec4()
            return
        after = before + (time_step / wp.max(m, node_least_mass[node])) * force
        node_velocities[node] = vec4(after[0], after[1], before[0], before[1])

    return momentum


@wp.func
def correction_of_cell(v_00: vec4, v_10: vec4, v_01: vec4, v_11: vec4, weight: real) -> vec4:
    """(X, Y) of a cell times its weight k rho V / 4; v_ij is (v_r, v_z, ...) of a node."""
    rising, falling = weight * (v_11 - v_00), weight * (v_10 - v_01)
    X, Y = rising + falling, rising - falling
    return vec4(X[0], X[1], Y[0], Y[1])
