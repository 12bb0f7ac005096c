"""The window: the grid travels with the penetrometer down through the soil.

Its motion (time [s], speed of the soil past the grid [m/s], travel [m]) is an array on the device,
so a recorded step can be replayed. Soil enters at the bottom and leaves at the top.
"""

import math
from dataclasses import dataclass

import warp as wp

from mpm_warp.fields.checked import Checked
from mpm_warp.fields.checks import Range, check_number
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Grid
from mpm_warp.kernel_types import kernel, one, real, zero
from mpm_warp.parts.inflow import Inflow, add_inflow
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.scene import BetweenSteps, Part, Scene, refuse_together


@dataclass(frozen=True, kw_only=True)
class RampedMotion(Part):
    """Motion at a speed that rises from rest."""

    speed: float = parameter(meaning="speed after the ramp", unit="m/s", above=0)
    ramp_travel: float = parameter(
        meaning="travel over which the speed rises from rest, linearly in time", unit="m", above=0
    )

    @property
    def first_speed(self) -> float:
        """Speed after the first ramp, the greatest [m/s]."""
        return self.speed

    @property
    def ramp_time(self) -> float:
        """Time of the first ramp [s]."""
        return 2.0 * self.ramp_travel / self.first_speed


class MovingGrid(RampedMotion):
    """A grid that moves through the soil; velocities are relative to undisturbed soil.

    The array "window.motion" has (time [s], speed of the soil past the grid [m/s], travel [m]).
    """

    def spare_fraction_in(self, grid: Grid) -> float:
        """Empty slots at the start, over the number of particles that fill the grid; default 0."""
        return 0.0

    def fill_spare_slots(self, plan: Plan, scene: Scene) -> None:
        """Put points into empty slots, before parts add arrays of points; by default none."""

    def top(self, scene: Scene) -> float:
        """Height above which particles leave the grid [m].

        Half a layer stays above the top; without it the mass of the top nodes could vanish.
        """
        rows = scene.grid.rows
        return float(rows[-1] + 0.5 * (rows[-1] - rows[-2]) / scene.particles_per_side)

    def check(self, scene: Scene) -> None:
        """Check that the grid is not polar: soil rises through its rows."""
        refuse_together(type(self).__name__, scene.grid.polar, "a grid of rays")

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Add the array of the motion."""
        plan.add_zeros("window.motion", "real", 3)


@dataclass(frozen=True, kw_only=True)
class Approach(Checked):
    """A fast start of a window, which then slows down to its final speed.

    The stress that it leaves in the soil hardly depends on the speed. The effect of inertia is gone
    when the soil around the body has been replaced.

    Attributes:
        travel: at which the grid reaches the final speed [m], > `slowing_travel`.

    Example:
        >>> Approach(speed=3.0, travel=0.1, slowing_travel=0.04)
        Approach(speed=3.0, travel=0.1, slowing_travel=0.04)
    """

    speed: float = parameter(
        meaning="speed of the grid before it slows down, above the final one", unit="m/s", above=0
    )
    travel: float
    slowing_travel: float = parameter(
        meaning="travel over which the speed falls, linearly", unit="m", above=0
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        beyond = Range(above=self.slowing_travel)
        check_number("Approach: travel", self.travel, beyond, unit="m")


@dataclass(frozen=True, kw_only=True)
class Window(MovingGrid):
    """The grid moves down through the soil.

    Each time the grid has travelled by the height of a layer of particles, a layer of undisturbed
    soil enters the lowest row, into slots of particles that have left at the top. `speed` is that
    after the approach.

    Attributes:
        approach: a fast start; None: there is none.

    Example:
        >>> window = Window(speed=0.5, ramp_travel=0.02, spare_fraction=0.1)
        >>> round(window.time_to(0.5), 3)  # [s] for 0.5 m
        1.04
    """

    # more where soil does not fill the grid at the start
    spare_fraction: float = parameter(
        meaning="empty slots at the start over the number of particles", above=0
    )
    approach: Approach | None = None
    stray_speed: float | None = parameter(
        None,
        "bound s of `mpm_warp.parts.inflow` on the speed of a point in the grid; None: W alone",
        unit="m/s",
        above=0,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.approach is not None:
            faster = Range(above=self.speed)
            check_number("Window: approach.speed", self.approach.speed, faster, unit="m/s")

    @property
    def first_speed(self) -> float:
        """See `RampedMotion`."""
        return self.speed if self.approach is None else self.approach.speed

    def time_to(self, travel: float) -> float:
        """Time [s] to a travel [m], >= 0; an approach is longer than ramp and slowing."""
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
        """Highest speed of the grid beyond a travel [m], after the ramp [m/s]."""
        if self.approach is None:
            return self.speed
        left = (self.approach.travel - travel) / self.approach.slowing_travel
        return self.speed + min(1.0, max(0.0, left)) * (self.approach.speed - self.speed)

    def spare_fraction_in(self, grid: Grid) -> float:
        """See `MovingGrid`."""
        return self.spare_fraction

    def add_after_motion(self, plan: Plan, scene: Scene) -> None:
        """Add the launch of the motion, and the arrays and launches of the inflow."""
        approach = self.approach
        plan.add_launch(
            advance_window,
            1,
            speed=self.first_speed,
            ramp_time=self.ramp_time,
            final_speed=self.speed,
            # Without an approach the speed never falls.
            approach_travel=math.inf if approach is None else approach.travel,
            slowing_travel=1.0 if approach is None else approach.slowing_travel,
        )
        closer = self.stray_speed or math.inf
        add_inflow(plan, scene, window_speed=self.first_speed, stray_speed=closer)

    def between_steps(self, run: Run, scene: Scene) -> BetweenSteps:
        """The inflow of soil."""
        return Inflow(run, scene, self.highest_speed_from)


@kernel
def advance_window(
    time_step: real,
    speed: real,
    ramp_time: real,
    final_speed: real,
    approach_travel: real,
    slowing_travel: real,
    window_motion: wp.array[real],
):
    """One step of the motion; launched once.

    The speed rises linearly in time; at the end of an approach it falls linearly in travel.
    """
    window_motion[2] += time_step * window_motion[1]
    window_motion[0] += time_step
    risen = speed * wp.min(window_motion[0] / ramp_time, one)
    left = wp.clamp((approach_travel - window_motion[2]) / slowing_travel, zero, one)
    window_motion[1] = wp.min(risen, final_speed + left * (speed - final_speed))
