"""Before the step: dead loads that rise linearly in time, then stay.

f_p = sum over loads min(max((t + dt / 2 - t_0) / T, 0), 1) F_p        then t <- t + dt

In the middle of the step, so that the impulse of a load is exact while it rises or stays.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@functools.cache
def make_body_loads(precision: Precision) -> Any:
    """Forces of all loads on each particle; launched over particles.

    `schedule` holds (t_0, T) of each load.
    """
    real, vec2 = precision.real, precision.vec2
    zero, one = wp.constant(real(0.0)), wp.constant(real(1.0))

    @wp.kernel(module=f"mpm_warp.body_loads.{precision.numpy_name}", enable_backward=False)
    def body_loads(
        schedule: wp.array(dtype=vec2),
        load_forces: wp.array2d(dtype=vec2),
        time: wp.array(dtype=real),
        half_step: real,
        force: wp.array(dtype=vec2),
    ):
        p = wp.tid()
        middle = time[0] + half_step
        total = vec2()
        for k in range(schedule.shape[0]):
            total += (
                wp.clamp((middle - schedule[k][0]) / schedule[k][1], zero, one)
                * (load_forces[k, p])
            )
        force[p] = total

    return body_loads


@functools.cache
def make_clock(precision: Precision) -> Any:
    """Time goes on by a step; launched once."""
    real = precision.real

    @wp.kernel(module=f"mpm_warp.clock.{precision.numpy_name}", enable_backward=False)
    def clock(time_step: real, time: wp.array(dtype=real)):
        time[0] += time_step

    return clock
