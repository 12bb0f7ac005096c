"""An inner wall that moves outward, the grid with it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class MovingWall:
    """A smooth wall, a cylinder or a sphere, the first column of the grid's nodes, pushed outward.

    The columns between the wall and the outer radius draw together in proportion; soil passes
    from cell to cell.

    Attributes:
        speed: final speed [m/s], > 0.
        ramp_travel: travel over which the speed rises linearly from rest [m], > 0.
    """

    speed: float
    ramp_travel: float

    @property
    def ramp_time(self) -> float:
        """Time until the final speed is reached [s]."""
        return 2.0 * self.ramp_travel / self.speed
