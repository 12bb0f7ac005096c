"""Stage 2, continued: what loads, gravity and damping do to the velocity of nodes.

`motion` is (v_r, v_z, u_r, u_z): velocity after the step and before it. Symbols: m mass, f load,
g gravity, c rate of damping.

    v <- v + dt f / m,    v <- v - dt g e_z,    v <- v / (1 + dt c)
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@functools.cache
def make_nodal_load(precision: Precision) -> Any:
    """Constant forces on some nodes; launched over these nodes."""
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    zero = wp.constant(real(0.0))

    @wp.kernel(module=f"mpm_warp.nodal_load.{precision.numpy_name}", enable_backward=False)
    def nodal_load(
        nodes: wp.array(dtype=int),
        forces: wp.array(dtype=vec2),
        mass: wp.array(dtype=real),
        time_step: real,
        motion: wp.array(dtype=vec4),
    ):
        k = wp.tid()
        node = nodes[k]
        if mass[node] <= zero:
            return
        change = (time_step / mass[node]) * forces[k]
        motion[node] += vec4(change[0], change[1], zero, zero)

    return nodal_load


@functools.cache
def make_gravity(precision: Precision) -> Any:
    """Uniform gravity, downward; launched over all nodes."""
    real, vec4 = precision.real, precision.vec4
    zero = wp.constant(real(0.0))

    @wp.kernel(module=f"mpm_warp.gravity.{precision.numpy_name}", enable_backward=False)
    def gravity(first: int, change: real, mass: wp.array(dtype=real), motion: wp.array(dtype=vec4)):
        node = first + wp.tid()
        if mass[node] > zero:
            motion[node] -= vec4(zero, change, zero, zero)

    return gravity


@functools.cache
def make_damping(precision: Precision) -> Any:
    """Drag in proportion to momentum, implicit; `drag` is c dt. Launched over all nodes."""
    real, vec4 = precision.real, precision.vec4
    one = wp.constant(real(1.0))

    @wp.kernel(module=f"mpm_warp.damping.{precision.numpy_name}", enable_backward=False)
    def damping(first: int, drag: real, motion: wp.array(dtype=vec4)):
        node = first + wp.tid()
        v = motion[node]
        motion[node] = vec4(v[0] / (one + drag), v[1] / (one + drag), v[2], v[3])

    return damping
