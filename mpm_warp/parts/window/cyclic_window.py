"""The cyclic window: the grid travels with a body down and up again, over a stroke.

Its motion is that of a `Window`, (time, speed, travel), but it turns at the end of each passage of
the stroke. With t the time since the last turn, t_p that of a passage, t_r that of a ramp, and V
the greatest speed, the speed is

    +-V min(1, t / t_r, (t_p - t) / t_r)        + on the way down

At a turn the body stands still, and the soil is set at rest with it. Particles have velocities that
no node has a share in; these would add up from passage to passage, until soil is thrown about.

No soil enters, and none is lost: what is outside the grid rests (`resting_ground`).
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.arguments import POSITIVE, Range, check_number
from mpm_warp.grid.fitted import Grid
from mpm_warp.parts.part import Setting
from mpm_warp.parts.window.resting_ground import rows_below
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision


@dataclass(frozen=True, kw_only=True)
class CyclicWindow:
    """The grid moves down through the soil over a stroke, up again, and so on.

    Attributes:
        speed: greatest speed of the grid [m/s], > 0.
        ramp_travel: travel over which the speed rises after a turn, and falls before the next,
            linearly in time [m], > 0.
        stroke: travel of a passage, from turn to turn [m], at least that of two ramps.

    Raises:
        SceneError: a value is not allowed.
    """

    speed: float
    ramp_travel: float
    stroke: float

    def __post_init__(self) -> None:
        check_number("window: speed", self.speed, POSITIVE, unit="m/s")
        check_number("window: ramp_travel", self.ramp_travel, POSITIVE, unit="m")
        two_ramps = Range(minimum=2.0 * self.ramp_travel)
        check_number("window: stroke", self.stroke, two_ramps, unit="m")

    @property
    def first_speed(self) -> float:
        """The greatest speed [m/s]."""
        return self.speed

    @property
    def ramp_time(self) -> float:
        """Time of a ramp [s]."""
        return 2.0 * self.ramp_travel / self.speed

    @property
    def passage_time(self) -> float:
        """Time from turn to turn [s]."""
        return self.ramp_time + self.stroke / self.speed

    def time_to(self, way: float) -> float:
        """Time to go so far down and up [s]; each passage adds a stroke to the way [m], >= 0."""
        passages, since = divmod(way, self.stroke)
        to_turn = self.stroke - since
        if since < self.ramp_travel:
            time = self.ramp_time * math.sqrt(since / self.ramp_travel)
        elif to_turn < self.ramp_travel:
            time = self.passage_time - self.ramp_time * math.sqrt(to_turn / self.ramp_travel)
        else:
            time = self.ramp_time + (since - self.ramp_travel) / self.speed
        return passages * self.passage_time + time

    def spare_fraction_in(self, grid: Grid) -> float:
        """Slots for the ground below a grid, over the number of particles that fill it."""
        return rows_below(grid, self.stroke) / grid.row_count

    def top(self, setting: Setting) -> float:
        """Height above which the stage of the particles takes them out of the grid: none [m]."""
        return math.inf

    def add_to(self, plan: Plan) -> None:
        """Add the launches that set soil at rest at a turn, and move the grid on after a step."""
        plan.add_launch(
            _make_rest_at_turn(plan.precision),
            plan.arrays["particle.mass"].shape,
            passage_time=self.passage_time,
        )
        plan.add_launch(
            _make_advance_cyclic_window(),
            1,
            speed=self.speed,
            ramp_time=self.ramp_time,
            passage_time=self.passage_time,
        )


@functools.cache
def _make_rest_at_turn(precision: Precision) -> Any:
    """The kernel, launched over slots of particles; it does nothing but in the step of a turn."""
    real, vec2 = precision.real, precision.vec2

    @wp.kernel(module=f"mpm_warp.rest_at_turn.{precision.numpy_name}", enable_backward=False)
    def rest_at_turn(
        offset: int,
        time_step: wp.float64,
        passage_time: wp.float64,
        window_motion: wp.array(dtype=wp.float64),
        particle_velocity: wp.array(dtype=vec2),
    ):
        p = offset + wp.tid()
        now = window_motion[0]
        if wp.floor((now + time_step) / passage_time) > wp.floor(now / passage_time):
            particle_velocity[p] = vec2(real(0.0))

    return rest_at_turn


@functools.cache
def _make_advance_cyclic_window() -> Any:
    """One step of the motion; launched once."""
    one, two = wp.constant(wp.float64(1.0)), wp.constant(wp.float64(2.0))

    @wp.kernel(module="mpm_warp.advance_cyclic_window", enable_backward=False)
    def advance_cyclic_window(
        time_step: wp.float64,
        speed: wp.float64,
        ramp_time: wp.float64,
        passage_time: wp.float64,
        window_motion: wp.array(dtype=wp.float64),
    ):
        window_motion[2] += time_step * window_motion[1]
        window_motion[0] += time_step
        passages = wp.floor(window_motion[0] / passage_time)
        since_turn = window_motion[0] - passages * passage_time
        to_turn = passage_time - since_turn
        share = wp.min(one, wp.min(since_turn, to_turn) / ramp_time)
        upward = passages - two * wp.floor(passages / two)  # 0 or 1
        window_motion[1] = (one - two * upward) * share * speed

    return advance_cyclic_window
