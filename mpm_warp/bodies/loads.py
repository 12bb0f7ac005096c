"""Dead loads on the particles of a body: they rise linearly in time, then stay.

    f_p = sum over loads min(max((t + dt / 2 - t_0) / T, 0), 1) F_p        then t <- t + dt

They are taken in the middle of the step: then the impulse of a load is exact in every step in which
it only rises or only stays.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from mpm_warp.arguments import NOT_NEGATIVE, POSITIVE, check_array, check_number
from mpm_warp.bodies.grid import one, real, vec2, zero
from mpm_warp.grid.fitted import Floats
from mpm_warp.plan.plan import Plan


@dataclass(frozen=True, kw_only=True, eq=False)
class Load:
    """Dead forces on the particles of a body, which rise linearly from zero and then stay.

    Attributes:
        forces: final force on each particle [N], shape [particle_count, 2].
        start: time t_0 at which they begin to rise [s], >= 0.
        rise_time: time T that they take to rise [s], > 0.

    Raises:
        SceneError: a value is not allowed.
    """

    forces: Floats
    start: float
    rise_time: float

    def __post_init__(self) -> None:
        check_array("load: forces", self.forces, (None, 2))
        check_number("load: start", self.start, NOT_NEGATIVE, unit="s")
        check_number("load: rise_time", self.rise_time, POSITIVE, unit="s")

    def impulse_time(self, time: Floats) -> Floats:
        """Impulse until each time over the final force: time integral of the fraction acting [s].

        Args:
            time: times since the start of the run [s], of any shape.
        """
        rising = np.clip(time - self.start, 0.0, self.rise_time)
        steady = np.maximum(time - self.start - self.rise_time, 0.0)
        integral: Floats = 0.5 * rising**2 / self.rise_time + steady
        return integral


def add_loads(plan: Plan, loads: Sequence[tuple[slice, Load]]) -> None:
    """Add the forces of the loads on all particles, at the beginning of a step.

    Args:
        plan: to add to.
        loads: each with the particles of its body; one or more.
    """
    forces = np.zeros((len(loads), plan.particle_count, 2))
    for index, (particles, load) in enumerate(loads):
        forces[index, particles] = load.forces
    schedule = np.array([(load.start, load.rise_time) for _, load in loads])
    plan.add_array("load.schedule", "vec2", schedule)
    plan.add_array("load.forces", "vec2", forces)
    plan.add_zeros("load.time", "real", 1)
    plan.add_zeros("particle.load", "vec2", plan.particle_count)
    plan.add_launch(body_loads, plan.particle_count, half_step=0.5 * plan.time_step)


def add_clock(plan: Plan) -> None:
    """Add the time of the loads, which goes on at the end of a step."""
    plan.add_launch(clock, 1)


@wp.kernel(module="mpm_warp.body_loads", enable_backward=False)
def body_loads(
    load_schedule: wp.array(dtype=vec2),
    load_forces: wp.array2d(dtype=vec2),
    load_time: wp.array(dtype=real),
    half_step: real,
    particle_load: wp.array(dtype=vec2),
):
    """Forces of all loads on each particle; launched over particles.

    `load_schedule` holds (t_0, T) of each load.
    """
    p = wp.tid()
    middle = load_time[0] + half_step
    total = vec2()
    for k in range(load_schedule.shape[0]):
        start, rise_time = load_schedule[k][0], load_schedule[k][1]
        total += wp.clamp((middle - start) / rise_time, zero, one) * load_forces[k, p]
    particle_load[p] = total


@wp.kernel(module="mpm_warp.clock", enable_backward=False)
def clock(time_step: real, load_time: wp.array(dtype=real)):
    """Time goes on by a step; launched once."""
    load_time[0] += time_step
