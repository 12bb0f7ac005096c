"""The shock in a bar that strikes a rigid wall: exact, and as a simulation shows it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import variable
from mpm_warp.simulation import TimeLoop

TRAVEL = 0.75
"""Part of the bar that the shock has passed at the end; its speed is that over the second half."""


@dataclass(frozen=True)
class Shock:
    """A bar of speed V comes to rest behind a shock, its stress being M ln l at the stretch l.

    With c^2 = M / rho, a shock that passes the length U of the unstrained bar in a unit of time
    leaves, by mass and momentum (Rankine and Hugoniot; the law of energy is not needed where stress
    does not depend on heat),

        l = 1 - V / U,    -M ln l = rho U V,    so that (V / c)^2 = -(V / U) ln(1 - V / U).

    Attributes:
        modulus: M, of uniaxial strain [Pa], > 0.
        density: rho of the unstrained bar [kg/m3], > 0.
        speed: V [m/s], > 0.
    """

    modulus: float
    density: float
    speed: float

    @cached_property
    def shortening(self) -> float:
        """V / U: what the shock takes of the length."""
        square = self.speed**2 * self.density / self.modulus

        def excess(shortening: float) -> float:
            return -shortening * math.log1p(-shortening) - square

        return float(brentq(excess, 0.0, 1.0 - 1e-12))

    @property
    def front_speed(self) -> float:
        """U [m/s]."""
        return self.speed / self.shortening

    @property
    def stress(self) -> float:
        """Stress behind the shock, tension positive [Pa]."""
        return self.modulus * math.log1p(-self.shortening)


def follow_shock(
    loop: TimeLoop,
    shock: Shock,
    *,
    places: Floats,
    section_means: Callable[[Floats], Floats],
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Run until the shock has passed most of the bar, and hold it against the exact one.

    Args:
        loop: a run in which the bar has its speed along the second axis, downward, and is about to
            touch the wall.
        shock: the exact one.
        places: of the bar's sections before it touches the wall, from there up [m], rising.
        section_means: from values of all particles to means over these sections.
        progress: is told the fraction done.
    """

    def along_bar(name: str) -> Floats:
        return section_means(loop.array(f"particle.{name}")[:, 1])

    def front() -> float:
        """Where half the velocity is gone [m]."""
        velocity, half = along_bar("velocity"), -0.5 * shock.speed
        first = int(np.flatnonzero(velocity < half)[0])
        around = [first, first - 1]
        return float(np.interp(half, velocity[around], places[around]))

    fronts = []
    for share in (0.5, 1.0):
        loop.advance_to(share * TRAVEL * places[-1] / shock.front_speed)
        fronts.append((loop.time, front()))
        if progress is not None:
            progress(share)
    loop.check()
    return _dataset(shock, fronts, places, along_bar("velocity"), along_bar("stress"))


def _dataset(
    shock: Shock,
    fronts: list[tuple[float, float]],
    places: Floats,
    velocity: Floats,
    stress: Floats,
) -> xr.Dataset:
    (middle_time, middle), (end_time, end) = fronts
    # Between what the first touch has left at the wall and the shock's own width.
    behind = (places > 0.25 * end) & (places < 0.75 * end)
    front_speed = (end - middle) / (end_time - middle_time)
    errors = {
        "front_speed_error": (abs(front_speed / shock.front_speed - 1.0), "error of its speed"),
        "stress_error": (
            abs(stress[behind].mean() / shock.stress - 1.0),
            "error of the mean stress behind it",
        ),
        "velocity_error": (
            abs(velocity[behind].mean()) / shock.speed,
            "mean velocity behind it over that of the impact",
        ),
    }
    greatest = max(value for value, _ in errors.values())
    scalars = {
        "error": (greatest, "greatest error of the shock's speed, stress and velocity"),
        **errors,
        "stress_scatter": (
            stress[behind].std() / abs(shock.stress),
            "standard deviation of the stress behind the shock over its mean",
        ),
    }
    passed = places < shock.front_speed * end_time
    curves = {
        "stress": (stress, "Pa", "stress at the end"),
        "stress_exact": (np.where(passed, shock.stress, 0.0), "Pa", "stress, exact"),
        "velocity": (velocity, "m s-1", "velocity at the end"),
        "velocity_exact": (np.where(passed, 0.0, -shock.speed), "m s-1", "velocity, exact"),
    }
    variables = {
        name: variable(value, unit="1", meaning=meaning)
        for name, (value, meaning) in scalars.items()
    } | {
        name: variable(values, unit=unit, meaning=meaning, dims=("place",))
        for name, (values, unit, meaning) in curves.items()
    }
    axis = variable(places, unit="m", meaning="place in the unstrained bar", dims=("place",))
    return xr.Dataset(variables, coords={"place": axis})
