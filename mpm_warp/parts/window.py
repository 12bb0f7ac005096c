"""The window that travels with the penetrometer: soil enters below and leaves above."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Approach:
    """The window hurries to where it matters, then falls to its final speed.

    What the soil remembers of the way is its stress, which hardly depends on the speed; what it
    owes to inertia is gone when the soil around has been replaced.

    Attributes:
        speed: of the grid on the way [m/s], above the final one.
        travel: where it has fallen to the final speed [m], > `slowing_travel`.
        slowing_travel: travel over which it falls, linearly [m], > 0.
    """

    speed: float
    travel: float
    slowing_travel: float


@dataclass(frozen=True, kw_only=True)
class Window:
    """The grid moves down through the soil; velocities stay those relative to undisturbed soil.

    Whenever the grid has travelled by the height of a layer of particles, a layer of undisturbed
    soil enters the lowest row, into the places of particles that left above the highest.

    Attributes:
        speed: final speed of the grid [m/s], > 0.
        ramp_travel: travel over which the speed rises linearly from rest [m], > 0.
        approach: a hurried start, or none.
        spare_fraction: places for particles beyond those of the full grid, over their number,
            dimensionless, > 0.
    """

    speed: float
    ramp_travel: float
    spare_fraction: float
    approach: Approach | None = None

    @property
    def first_speed(self) -> float:
        """The speed after the ramp [m/s]."""
        return self.speed if self.approach is None else self.approach.speed

    @property
    def ramp_time(self) -> float:
        """Time until the speed after the ramp is reached [s]."""
        return 2.0 * self.ramp_travel / self.first_speed

    def time_to(self, travel: float) -> float:
        """Time to travel so far [s], where the approach is longer than ramp and slowing."""
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
        """The highest speed that the grid has beyond some travel [m/s]."""
        if self.approach is None:
            return self.speed
        left = (self.approach.travel - travel) / self.approach.slowing_travel
        return self.speed + min(1.0, max(0.0, left)) * (self.approach.speed - self.speed)
