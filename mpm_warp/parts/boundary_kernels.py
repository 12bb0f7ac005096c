"""Stage 2, continued: what boundaries do to the velocity of their nodes.

`motion` is (v_r, v_z, u_r, u_z): velocity after the step and before it.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@functools.cache
def make_fixed(precision: Precision) -> Any:
    """Nodes at rest in r, z or both; `free` is 0 or 1 for each. Launched over these nodes."""
    vec2, vec4 = precision.vec2, precision.vec4

    @wp.kernel(module=f"mpm_warp.fixed.{precision.numpy_name}", enable_backward=False)
    def fixed(
        first: int,
        nodes: wp.array(dtype=int),
        free: wp.array(dtype=vec2),
        motion: wp.array(dtype=vec4),
    ):
        k = first + wp.tid()
        v = motion[nodes[k]]
        motion[nodes[k]] = vec4(free[k][0] * v[0], free[k][1] * v[1], v[2], v[3])

    return fixed


@functools.cache
def make_far_field(precision: Precision) -> Any:
    """The elastic medium outside the grid, on the nodes of its side; launched over these nodes.

    Spring k and dashpots c per radian, the dashpots implicit: m dv/dt = -k w - c v, dw/dt = v_r.
    """
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    zero, one = wp.constant(real(0.0)), wp.constant(real(1.0))

    @wp.kernel(module=f"mpm_warp.far_field.{precision.numpy_name}", enable_backward=False)
    def far_field(
        first: int,
        nodes: wp.array(dtype=int),
        spring: wp.array(dtype=real),
        dashpot: wp.array(dtype=vec2),
        mass: wp.array(dtype=real),
        time_step: real,
        displacement: wp.array(dtype=real),
        motion: wp.array(dtype=vec4),
    ):
        k = first + wp.tid()
        if mass[nodes[k]] <= zero:
            return
        v = motion[nodes[k]]
        rate = time_step / mass[nodes[k]]
        v_r = (v[0] - rate * spring[k] * displacement[k]) / (one + rate * dashpot[k][0])
        v_z = v[1] / (one + rate * dashpot[k][1])
        displacement[k] += time_step * v_r
        motion[nodes[k]] = vec4(v_r, v_z, v[2], v[3])

    return far_field
