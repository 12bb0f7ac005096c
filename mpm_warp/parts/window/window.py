"""The window: the grid travels with the penetrometer down through the soil.

Its motion is (time [s], speed of the soil past the grid [m/s], travel [m]). It is kept on the
device so that a recorded step can be replayed as it is, in double precision whatever that of the
run: a step moves it by a ten-millionth of its travel. Soil enters below and leaves above.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.arguments import POSITIVE, Range, check_kind, check_number
from mpm_warp.grid.fitted import Grid
from mpm_warp.parts.part import Setting
from mpm_warp.plan.plan import Plan


@dataclass(frozen=True, kw_only=True)
class Approach:
    """The window hurries to where it matters, then falls to its final speed.

    What the soil remembers of the way is its stress, which hardly depends on the speed; what it
    owes to inertia is gone when the soil around has been replaced.

    Attributes:
        speed: of the grid on the way [m/s], above the final one.
        travel: where it has fallen to the final speed [m], > `slowing_travel`.
        slowing_travel: travel over which it falls, linearly [m], > 0.

    Raises:
        SceneError: a value is not allowed.
    """

    speed: float
    travel: float
    slowing_travel: float

    def __post_init__(self) -> None:
        check_number("approach: speed", self.speed, POSITIVE, unit="m/s")
        check_number("approach: slowing_travel", self.slowing_travel, POSITIVE, unit="m")
        beyond = Range(above=self.slowing_travel)
        check_number("approach: travel", self.travel, beyond, unit="m")


@dataclass(frozen=True, kw_only=True)
class Window:
    """The grid moves down through the soil; velocities stay those relative to undisturbed soil.

    Whenever the grid has travelled by the height of a layer of particles, a layer of undisturbed
    soil enters the lowest row, into the slots of particles that left above the highest.

    Attributes:
        speed: final speed of the grid [m/s], > 0.
        ramp_travel: travel over which the speed rises linearly from rest [m], > 0.
        approach: a hurried start, or none.
        spare_fraction: slots for particles beyond those of the full grid, over their number,
            dimensionless, > 0.

    Raises:
        SceneError: a value is not allowed.
    """

    speed: float
    ramp_travel: float
    spare_fraction: float
    approach: Approach | None = None

    def __post_init__(self) -> None:
        check_number("window: speed", self.speed, POSITIVE, unit="m/s")
        check_number("window: ramp_travel", self.ramp_travel, POSITIVE, unit="m")
        check_number("window: spare_fraction", self.spare_fraction, POSITIVE)
        check_kind("window: approach", self.approach, (Approach, type(None)))
        if self.approach is not None:
            faster = Range(above=self.speed)
            check_number("approach: speed", self.approach.speed, faster, unit="m/s")

    @property
    def first_speed(self) -> float:
        """The speed after the ramp [m/s]."""
        return self.speed if self.approach is None else self.approach.speed

    @property
    def ramp_time(self) -> float:
        """Time until the speed after the ramp is reached [s]."""
        return 2.0 * self.ramp_travel / self.first_speed

    def time_to(self, travel: float) -> float:
        """Time to a travel [m], >= 0, where the approach is longer than ramp and slowing [s]."""
        if travel <= self.ramp_travel:
            return self.ramp_time * math.sqrt(travel / self.ramp_travel)
        if self.approach is None:
            return self.ramp_time + (travel - self.ramp_travel) / self.speed
        fast, slow, falling = self.approach.speed, self.speed, self.approach.slowing_travel
        begin = self.approach.travel - falling
        time = self.ramp_time + (min(travel, begin) - self.ramp_travel) / fast
        fallen = min(1.0, max(0.0, travel - begin) / falling) * (fast - slow)
        time += falling / (fast - slow) * math.log(fast / (fast - fallen))
        return time + max(0.0, travel - self.approach.travel) / slow

    def highest_speed_from(self, travel: float) -> float:
        """The highest speed that the grid has beyond a travel [m], after the ramp [m/s]."""
        if self.approach is None:
            return self.speed
        left = (self.approach.travel - travel) / self.approach.slowing_travel
        return self.speed + min(1.0, max(0.0, left)) * (self.approach.speed - self.speed)

    def spare_fraction_in(self, grid: Grid) -> float:
        """Empty slots at the start, over the number of particles that fill a grid."""
        return self.spare_fraction

    def top(self, setting: Setting) -> float:
        """Height above which particles leave the grid for good [m]."""
        return height_of_leaving(setting)

    def add_to(self, plan: Plan) -> None:
        """Add the launch that moves it on, at the end of a step."""
        approach = self.approach
        plan.add_launch(
            _make_advance_window(approach is not None),
            1,
            speed=self.first_speed,
            ramp_time=self.ramp_time,
            final_speed=self.speed,
            approach_travel=0.0 if approach is None else approach.travel,
            slowing_travel=0.0 if approach is None else approach.slowing_travel,
        )


def add_window_motion(plan: Plan) -> None:
    """Add the array of the motion of a window, which stages and parts read."""
    plan.add_zeros("window.motion", "double", 3)


def height_of_leaving(setting: Setting) -> float:
    """Height above which particles leave a grid that travels [m].

    Half a layer stays above the top, else the mass of the nodes there could vanish.
    """
    rows = setting.grid.rows
    return float(rows[-1] + 0.5 * (rows[-1] - rows[-2]) / setting.particles_per_side)


@functools.cache
def _make_advance_window(hurried: bool) -> Any:
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
        window_motion: wp.array(dtype=wp.float64),
    ):
        window_motion[2] += time_step * window_motion[1]
        window_motion[0] += time_step
        risen = speed * wp.min(window_motion[0] / ramp_time, one)
        if wp.static(hurried):
            left = wp.clamp((approach_travel - window_motion[2]) / slowing_travel, zero, one)
            window_motion[1] = wp.min(risen, final_speed + left * (speed - final_speed))
        else:
            window_motion[1] = risen

    return advance_window
