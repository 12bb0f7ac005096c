"""A bound on what a point carries beside the velocity of the soil at it, in a grid that travels.

Symbols: v_p velocity of the point, v velocity of the nodes, N shape functions at the point.

    w = v_p - N v, |w| at most W:    v_p <- N v + w W / |w| beyond

No point moves by its w; it is what the point brings to the nodes in the next step beside their own
velocity. A point that stays near a tip, a shoulder or a pole for long gathers more and more of it,
for it gets the same changes as those that hurry past, and would at last be faster than waves. That
takes many steps: the bound is kept whenever a layer of soil enters, and costs next to nothing. What
is faster than waves already is a fault, left for the watch to tell.
"""

import warp as wp

from mpm_warp.grid.location import make_location
from mpm_warp.kernel_types import kernel, real, vec2, vec3, vec4, vec5
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene

VELOCITY_BOUND = "velocity.bound"
"""The launch, ordered between steps."""
SHARE_OF_WAVE, OVER_WINDOW = 0.5, 4.0
"""W is the lesser of these, over the speed of the pressure wave and the greatest of the grid; in
sound runs points have up to 0.12 and 2.7 of it."""


def add_velocity_bound(plan: Plan, scene: Scene, *, window_speed: float) -> None:
    """Add the launch, over slots; `window_speed` is the greatest of the grid [m/s]."""
    plan.between_steps[VELOCITY_BOUND] = plan.launch(
        bound_velocity,
        len(plan.initial("particle.cell")),
        stride=scene.grid.column_count + 1,
        fitted_radius=scene.grid.fitted_radius,
        W=min(SHARE_OF_WAVE * scene.material.pressure_wave_speed, OVER_WINDOW * window_speed),
        speed_limit=plan.speed_limit,
    )


natural = make_location(polar=False).natural


@kernel
def bound_velocity(
    node_velocities: wp.array(dtype=vec4),
    grid_columns: wp.array(dtype=vec3),
    grid_rows: wp.array(dtype=vec5),
    stride: int,
    fitted_radius: real,
    particle_cell: wp.array(dtype=wp.vec2i),
    particle_position: wp.array(dtype=vec2),
    W: real,
    speed_limit: real,
    particle_velocity: wp.array(dtype=vec2),
):
    """Launched over slots."""
    p = wp.tid()
    i, j = particle_cell[p][0], particle_cell[p][1]
    if i < 0:
        return
    where = natural(particle_position[p], grid_columns[i], grid_rows[j], fitted_radius)
    xi, eta = where[0], where[1]
    node = j * stride + i
    left = node_velocities[node] + eta * (node_velocities[node + stride] - node_velocities[node])
    right = node_velocities[node + 1]
    right += eta * (node_velocities[node + stride + 1] - node_velocities[node + 1])
    here = left + xi * (right - left)
    v = vec2(here[0], here[1])
    w = particle_velocity[p] - v
    if wp.length(w) > W and wp.length(w) < speed_limit:
        particle_velocity[p] = v + (W / wp.length(w)) * w
