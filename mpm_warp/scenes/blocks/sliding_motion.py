"""The motion of a rigid block on a plane, pushed by a force that rises and then stays."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mpm_warp.grid.fitted import Floats


@dataclass(frozen=True, kw_only=True)
class SlidingMotion:
    """A block sticks while its driving force F <= R = a A + mu N; then M dv/dt = F - R.

    Attributes:
        mass: M [kg], > 0.
        driving_force: final value of F, which rises linearly from zero [N], > 0.
        resistance: R [N], >= 0.
        rise_time: time in which F rises [s], > 0; None: F rises until the motion ends.
    """

    mass: float
    driving_force: float
    resistance: float
    rise_time: float | None

    @property
    def slides(self) -> bool:
        """Whether the driving force comes to exceed the resistance."""
        return self.driving_force > self.resistance

    def duration(self, travel: float) -> float:
        """Time from the beginning of the drive until a sliding block has covered a distance [s].

        Where there is a `rise_time`, the distance covered while the force rises is left out.

        Args:
            travel: the distance [m].
        """
        excess = 1.0 - self.resistance / self.driving_force
        unit = travel * self.mass / self.driving_force
        if self.rise_time is None:
            return math.sqrt(6.0 * unit / excess**3)
        return self.rise_time + math.sqrt(2.0 * unit / excess)

    def at(self, since: Floats) -> tuple[Floats, Floats, Floats]:
        """Velocity [m/s], displacement [m] and base shear [N].

        Args:
            since: times since the driving force began [s]; where there is no `rise_time`, the last
                one is the end of the rise.

        Returns:
            Three arrays of the shape of `since`.
        """
        rise = float(since[-1]) if self.rise_time is None else self.rise_time
        onset = min(self.resistance / self.driving_force, 1.0) * rise
        # While the force rises v is quadratic in time, afterwards linear.
        rising = np.clip(since, onset, rise) - onset
        steady = np.maximum(since - rise, 0.0) if self.slides else np.zeros_like(since)
        growth = self.driving_force / rise / self.mass
        final = growth * (rise - onset)
        velocity = 0.5 * growth * rising**2 + final * steady
        at_rise = 0.5 * growth * (rise - onset) ** 2
        displacement = growth * rising**3 / 6.0 + at_rise * steady + 0.5 * final * steady**2
        drive = self.driving_force * np.minimum(since / rise, 1.0)
        return velocity, displacement, np.minimum(drive, self.resistance)
