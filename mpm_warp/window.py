"""The window that travels with the penetrometer: soil enters below and leaves above."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Window:
    """The grid moves down through the soil; velocities stay those relative to undisturbed soil.

    Whenever the grid has travelled by the height of a layer of particles, a layer of undisturbed
    soil enters the lowest row, into the places of particles that left above the highest.

    Attributes:
        speed: final speed of the grid [m/s], > 0.
        ramp_travel: travel over which the speed rises linearly from rest [m], > 0.
        spare_fraction: places for particles beyond those of the full grid, over their number,
            because soil beside a rough shaft leaves late; dimensionless, > 0.
    """

    speed: float
    ramp_travel: float
    spare_fraction: float = 0.1

    @property
    def ramp_time(self) -> float:
        """Time until the final speed is reached [s]."""
        return 2.0 * self.ramp_travel / self.speed
