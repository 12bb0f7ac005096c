"""Stage 3: the momentum equation of the nodes.

Symbols: sigma stress of a cell (rr, zz, rz, tt), m mass, M half a quarter of the mass of the cells
around a node when they are full, u and v velocity before and after the step, G_i the integrals over
a cell of (dN_i/dr r, dN_i/dz r, N_i), S the mass-matrix correction where there is one; of a cell:
v_ij velocity of its nodes after the step before, rho density, V volume.

    f_i     = - sum over cells (sigma_rr G_r + sigma_rz G_z + sigma_tt G_t,
                                sigma_rz G_r + sigma_zz G_z)
    u_i     = (m v)_i / m_i + (S v)_i / max(m_i, 2 M_i)
    v_i     = u_i + dt f_i / max(m_i, M_i)

The force is that of full cells, however few particles are near the node. So M bounds the
acceleration of a node with few of them.

A velocity field that goes from the nodes to particles and back is smoothed, as by diffusion: each
particle spreads its momentum over the nodes of its cell. The loss is the mean of xi (1 - xi) over
the particles of a cell, times second differences. The operator S restores k of it, the part that is
lost wherever the particles are: k = (1 - 1/n^2) / 6 for n equal points along a side.

    (S v)_i = sum over cells (+-X +-Y) k rho V / 4     + at the right and at the upper nodes, else -
    X, Y    = v_10 - v_00 + v_11 - v_01,  v_01 - v_00 + v_11 - v_10

k has this value for stability. Of a motion that alternates from node to node the particles return
the share P, 1/4 to 1/2 for n = 2, and S the share A, 1/2. The force f acts on the velocity of the
nodes at once, and on the returned velocity one step later: v' = v + f - q,
q' = A q + (1 - A - P) f. An oscillator is then stable up to 0.93 of the critical time step, without
S up to 0.76 of it, and at no time step where A + P > 1. The affine part of a particle's momentum
(Jiang et al. 2015, ACM Trans. Graph. 34(4):51) is no alternative: it returns all of a linear field,
but its losses between two motions are not symmetric. With it pressure waves grew that alternate
between wide, flat cells of nearly incompressible soil.

Soil that crosses the grid faster than 0.08 of the speed of shear waves makes short shear waves
grow, with 4 points a cell by up to 7 % a row, as S restores momentum of soil that has moved on. The
growth shows after hundreds of rows (`studies/stability.md`).

In partly filled cells P may have any value. So there is no S where a free surface passes, or only
far below it (`mpm_warp.parts.free_surface`).
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.kernel_types import half, kernel, maybe, one, real, vec2, vec3, vec4, zero
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene

ABSURD_SPEED = 100.0
"""Speed over that of pressure waves above which a node is left out of the step."""


def add_momentum(plan: Plan, scene: Scene, *, corrected: bool) -> None:
    """Add the stage; `corrected`: whether there is a mass-matrix correction."""
    grid = scene.grid
    plan.add_array("cell.integrals", "vec3", grid.gradient_integrals)
    # Where a wall moves it stays that of the start.
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
        # What a cell gives to one of its nodes, see `correction_of_cell`; the signs say to which.
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
            # The particle that gave it such a velocity is left alone until the watch finds it.
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
