"""Stage 2, continued: the adhesive contact law and where it acts.

After Ceccato, Beuth & Simonini (2017, Procedia Engineering 175:182-188) and Bardenhagen et al.
(2001, CMES 2:509-522): a corrector on the velocities predicted for a body alone.

Symbols: m mass of the body at the node, d its predicted velocity less that of the combined system
(of a rigid body: the prescribed one), n unit normal, outward from the body, P impulse that presses
the bodies together, mu friction coefficient, a A adhesion times contact area, p A in-situ pressure
times contact area, which the simulated stress leaves out.

    J_n = m d.n, at least -p A dt: there the bodies part
    J_t = m |w|, w = d - d.n n,     at most mu P + a A dt      (stick, slip)  while P > 0, else 0

On a surface that the grid follows P = m d.n + p A dt, the node's own.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@functools.cache
def make_contact_law(precision: Precision) -> Any:
    """The function (m, d, n, P, mu, a A dt, p A dt) -> (J_n, J_t w/|w|): impulse from the body."""
    real, vec2, vec3 = precision.real, precision.vec2, precision.vec3
    zero = wp.constant(real(0.0))

    @wp.func
    def contact_law(
        m: real, d: vec2, n: vec2, pressing: real, friction: real, adhesion: real, pressure: real
    ) -> vec3:
        normal_speed = wp.dot(d, n)
        J_n = wp.max(m * normal_speed, -pressure)
        if pressing <= zero:
            return vec3(J_n, zero, zero)
        w = d - normal_speed * n
        slip = m * wp.length(w)
        limit = friction * pressing + adhesion
        transmitted = m * w
        if slip > limit:
            transmitted = (limit / slip) * transmitted
        return vec3(J_n, transmitted[0], transmitted[1])

    return contact_law


@functools.cache
def make_surface_contact(moving: bool, precision: Precision) -> Any:
    """Contact with a rigid body whose surface the grid follows; launched over the surface's nodes.

    Adds up the impulses on the rigid body, normal and tangential, since they were last cleared.

    Args:
        moving: whether the grid travels with the body; otherwise the body has a speed of its own.
        precision: floating point types.
    """
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    contact_law = make_contact_law(precision)

    key = f"{'moving' if moving else 'resting'}.{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.surface_contact.{key}", enable_backward=False)
    def surface_contact(
        first: int,
        nodes: wp.array(dtype=int),
        normal: wp.array(dtype=vec2),
        friction: real,
        adhesion: wp.array(dtype=real),
        pressure: wp.array(dtype=real),
        mass: wp.array(dtype=real),
        time_step: real,
        speed: real,
        window_motion: wp.array(dtype=wp.float64),
        motion: wp.array(dtype=vec4),
        impulse: wp.array(dtype=vec2),
    ):
        k = first + wp.tid()
        node = nodes[k]
        m = mass[node]
        if m <= real(0.0):
            return
        v = motion[node]
        n = normal[k]
        d = vec2(v[0], v[1])
        if wp.static(moving):
            # The body sinks through the soil at the speed at which the soil passes the grid.
            d += vec2(real(0.0), real(window_motion[1]))
        else:
            d += vec2(real(0.0), speed)
        in_situ = pressure[k] * time_step
        pressing = m * wp.dot(d, n) + in_situ
        J = contact_law(m, d, n, pressing, friction, adhesion[k] * time_step, in_situ)
        tangential = vec2(J[1], J[2])
        change = -(J[0] * n + tangential) / m
        motion[node] = vec4(v[0] + change[0], v[1] + change[1], v[2], v[3])
        along = wp.dot(tangential, vec2(n[1], -n[0]))
        impulse[k] += vec2(J[0], along)

    return surface_contact
