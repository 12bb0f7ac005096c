"""Stage 3: particles take velocity, position and stress from the grid.

Symbols: v velocity of the nodes after the step, u before it, N shape functions at the particle, D
and W strain rate and spin of the cell, tr the trace, U the velocity of the soil past the grid, E
what makes the flow even within cells, of `mpm_warp.parts.even_flow_kernel`, or 0.

    v_p   <- v_p + N (v - u)
    x_p   <- x_p + dt (N v + U) + E
    sigma <- yield(R sigma R' + dt (K tr D + 2 G dev D))     R the rotation by dt W (Cayley)
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.materials.elasticity import make_elastic_trial
from mpm_warp.step.grid_update import cell_step_type
from mpm_warp.grid.location import make_location
from mpm_warp.precision import Precision


@functools.cache
def make_grid_to_particles(
    polar: bool, yielding: Any, even: bool, window: bool, precision: Precision
) -> Any:
    """The kernel, launched over particles.

    Args:
        polar: whether the grid is one of rings and rays.
        yielding: returns a trial stress to the yield surface; None where the material never yields.
        even: whether flow is made even within cells, see `mpm_warp.parts.even_flow_kernel`.
        window: whether particles that rise above the grid leave it; otherwise they stay below.
        precision: floating point types.
    """
    real, vec2, vec3, vec4 = precision.real, precision.vec2, precision.vec3, precision.vec4
    vec5 = precision.vec5
    location = make_location(polar, precision)
    natural, settle, outside_surface = location.natural, location.settle, location.outside_surface
    elastic_trial = make_elastic_trial(precision)
    yields = yielding is not None
    one = wp.constant(real(1.0))
    behaviour = yielding.key if yields else "elastic"
    key = f"{'polar' if polar else 'rows'}.{behaviour}.{'even' if even else 'bilinear'}"
    key = f"{key}.{'window' if window else 'closed'}.{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.grid_to_particles.{key}", enable_backward=False)
    def grid_to_particles(
        first: int,
        motion: wp.array(dtype=vec4),
        cell_step: wp.array(dtype=cell_step_type(even, precision)),
        columns: wp.array(dtype=vec3),
        rows: wp.array(dtype=vec5),
        outer_radius: real,
        cell_counts: wp.vec2i,
        time_step: real,
        strength: real,
        position: wp.array(dtype=vec2),
        velocity: wp.array(dtype=vec2),
        stress: wp.array(dtype=vec4),
        particle_cell: wp.array(dtype=wp.vec2i),
        window_motion: wp.array(dtype=wp.float64),
        top: real,
    ):
        p = first + wp.tid()
        cell = particle_cell[p]
        i, j = cell[0], cell[1]
        if wp.static(window):
            if i < 0:
                return
        x = position[p]
        where = natural(x, columns[i], rows[j], outer_radius)
        xi, eta = where[0], where[1]

        node = j * (cell_counts[0] + 1) + i
        upper = node + cell_counts[0] + 1
        lower_left, lower_right = motion[node], motion[node + 1]
        upper_left, upper_right = motion[upper], motion[upper + 1]
        # (v, u) at the particle: v the velocity after the step, u before it.
        left = lower_left + eta * (upper_left - lower_left)
        right = lower_right + eta * (upper_right - lower_right)
        here = left + xi * (right - left)
        v = vec2(here[0], here[1])
        u = vec2(here[2], here[3])
        velocity[p] += v - u

        step = cell_step[j * cell_counts[0] + i]
        trial = elastic_trial(stress[p], step)
        if wp.static(yields):
            stress[p] = yielding(trial, strength)
        else:
            stress[p] = trial

        x += time_step * v
        if wp.static(even):
            upright = eta * (one - eta)
            across = xi * (one - xi) * (step[7] + xi * step[8])
            x += vec2(across + upright * step[9], upright * step[10])
        if wp.static(window):
            x += vec2(real(0.0), time_step * real(window_motion[1]))
            if x[1] >= top:
                particle_cell[p] = wp.vec2i(-1, -1)
                return
        cell = settle(x, cell, columns, rows, outer_radius, cell_counts)
        particle_cell[p] = cell
        if cell[0] == 0:  # the column along the surface
            x = outside_surface(x, rows[cell[1]])
        position[p] = x

    return grid_to_particles
