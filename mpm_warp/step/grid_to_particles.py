"""Stage 6: particles take velocity, position and stress from the grid.

Symbols: v velocity of the nodes after the step, u before it, N shape functions at the particle, e
and R strain of the cell in the step and rotation by its spin, q properties and s state of the
particle, U velocity of the soil past a grid that travels, E displacement by the flow within the
cell (`ConservativeInterpolation`), a PIC fraction of the cell (`PassingSurface`).

    v_p   <- v_p + N (v - u) + a (N u - v_p)
    x_p   <- x_p + dt (N v + U) + E
    sigma, s <- law(R sigma R', e, dt, q, s)
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.grid.location import between_nodes, make_location
from mpm_warp.kernel_types import kernel, maybe, real, vec2, vec3, vec4, vec5, vec7, zero
from mpm_warp.materials.elasticity import make_stress_update
from mpm_warp.materials.material import Law
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene


def add_grid_to_particles(
    plan: Plan, scene: Scene, *, flow_displacement: Any | None, window_top: float | None
) -> None:
    """Add the stage.

    `flow_displacement` is a device function (flow within the cell over the step, xi, eta) ->
    displacement; None: there is no such flow. `window_top` is the height [m] above which particles
    leave a travelling grid; None: the grid rests.
    """
    plan.add_launch(
        _make_grid_to_particles(
            scene.grid.polar,
            scene.material.law(),
            flow_displacement,
            window_top is not None,
            "cell.pic_fraction" in plan.arrays,
        ),
        plan.arrays["particle.mass"].shape,
        top=0.0 if window_top is None else window_top,
    )


@functools.cache
def _make_grid_to_particles(
    polar: bool, law: Law, flow_displacement: Any, travelling: bool, blended: bool
) -> Any:
    """The kernel, launched over slots of particles."""
    location = make_location(polar)
    natural, settle, outside_surface = location.natural, location.settle, location.outside_surface
    stress_update = make_stress_update(law)

    @kernel
    def grid_to_particles(
        offset: int,
        node_velocities: wp.array[vec4],
        cell_motion: wp.array[vec7],
        cell_internal_flow: maybe(vec4),
        cell_pic_fraction: maybe(real),
        grid_columns: wp.array[vec3],
        grid_rows: wp.array[vec5],
        fitted_radius: real,
        cell_counts: wp.vec2i,
        time_step: real,
        properties: law.properties_argument,
        particle_position: wp.array[vec2],
        particle_velocity: wp.array[vec2],
        particle_stress: wp.array[vec4],
        particle_state: maybe(law.state_type),
        particle_cell: wp.array[wp.vec2i],
        window_motion: maybe(real),
        top: real,
    ):
        p = offset + wp.tid()
        cell = particle_cell[p]
        i, j = cell[0], cell[1]
        if wp.static(travelling):
            if i < 0:
                return
        x = particle_position[p]
        where = natural(x, grid_columns[i], grid_rows[j], fitted_radius)
        xi, eta = where[0], where[1]

        stride = cell_counts[0] + 1
        # (v, u) at the particle: v the velocity after the step, u before it.
        here = between_nodes(node_velocities, j * stride + i, stride, xi, eta)
        v = vec2(here[0], here[1])
        u = vec2(here[2], here[3])
        c = j * cell_counts[0] + i
        change = v - u
        if wp.static(blended):
            change += cell_pic_fraction[c] * (u - particle_velocity[p])
        particle_velocity[p] += change

        own, remembered = law.of_point(properties, particle_state, p)
        sigma, remembered = stress_update(
            particle_stress[p], cell_motion[c], time_step, own, remembered
        )
        particle_stress[p] = sigma
        if wp.static(law.remembers):
            particle_state[p] = remembered

        x += time_step * v
        if wp.static(flow_displacement is not None):
            x += flow_displacement(cell_internal_flow[c], xi, eta)
        if wp.static(travelling):
            x += vec2(zero, time_step * window_motion[1])
            if x[1] >= top:
                particle_cell[p] = wp.vec2i(-1, -1)
                return
        cell = settle(x, cell, grid_columns, grid_rows, fitted_radius, cell_counts)
        particle_cell[p] = cell
        if cell[0] == 0:  # the column along the surface
            x = outside_surface(x, grid_rows[cell[1]])
        particle_position[p] = x

    return grid_to_particles
