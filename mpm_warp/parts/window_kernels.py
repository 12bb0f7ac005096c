"""Stage 4: the window moves on, and now and then a layer of soil enters at its bottom.

Its motion is (time [s], speed of the soil past the grid [m/s], travel [m]). It is kept on the
device so that a recorded step can be replayed as it is, in double precision whatever that of the
run: a step moves it by a ten-millionth of its travel.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@functools.cache
def make_advance_window(hurried: bool) -> Any:
    """One step of the motion, the speed rising linearly in time; launched once.

    Args:
        hurried: whether it falls again at the end of an approach, linearly in travel.
    """
    zero, one = wp.constant(wp.float64(0.0)), wp.constant(wp.float64(1.0))
    key = "hurried" if hurried else "steady"

    @wp.kernel(module=f"mpm_warp.advance_window.{key}", enable_backward=False)
    def advance_window(
        time_step: wp.float64,
        speed: wp.float64,
        ramp_time: wp.float64,
        final_speed: wp.float64,
        approach_travel: wp.float64,
        slowing_travel: wp.float64,
        window: wp.array(dtype=wp.float64),
    ):
        window[2] += time_step * window[1]
        window[0] += time_step
        risen = speed * wp.min(window[0] / ramp_time, one)
        if wp.static(hurried):
            left = wp.clamp((approach_travel - window[2]) / slowing_travel, zero, one)
            window[1] = wp.min(risen, final_speed + left * (speed - final_speed))
        else:
            window[1] = risen

    return advance_window


@functools.cache
def make_admit(precision: Precision) -> Any:
    """A layer of soil at rest enters, into places of particles that left; over its particles."""
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4

    @wp.kernel(module=f"mpm_warp.admit.{precision.numpy_name}", enable_backward=False)
    def admit(
        layer_position: wp.array(dtype=vec2),
        layer_mass: wp.array(dtype=real),
        layer_cell: wp.array(dtype=wp.vec2i),
        layer_lift: wp.array(dtype=real),
        layer_places: wp.array(dtype=int),
        position: wp.array(dtype=vec2),
        velocity: wp.array(dtype=vec2),
        stress: wp.array(dtype=vec4),
        mass: wp.array(dtype=real),
        particle_cell: wp.array(dtype=wp.vec2i),
    ):
        k = wp.tid()
        p = layer_places[k]
        position[p] = layer_position[k] + vec2(real(0.0), layer_lift[0])
        velocity[p] = vec2()
        stress[p] = vec4()
        mass[p] = layer_mass[k]
        particle_cell[p] = layer_cell[k]

    return admit
