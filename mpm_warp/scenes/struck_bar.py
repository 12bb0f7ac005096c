"""A bar that strikes a rigid wall at a speed near that of its waves: the shock that runs back."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

if TYPE_CHECKING:
    import xarray

    from mpm_warp.bodies.planning import BodyPlan
    from mpm_warp.grids import Floats
    from mpm_warp.simulation import TimeLoop

LENGTH = 1.0
"""Length of the bar [m]; it is a cell thick."""
MODULUS = 2e6
DENSITY = 1000.0
WAVE_SPEED = math.sqrt(MODULUS / DENSITY)
DAMPING = 0.5
"""Retardation time over the time in which a wave crosses a cell: a shock is some cells wide."""
POINTS_PER_CELL = 2
"""Material points along and across a cell."""
TRAVEL = 0.75
"""Part of the bar that the shock has passed at the end; its speed is that over the second half."""


@dataclass(frozen=True, kw_only=True)
class StruckBar(ReadyScene):
    """A bar of Poisson's ratio 0 and speed V strikes a wall and comes to rest behind a shock.

    With the stress M ln l at the stretch l, the density rho and c^2 = M / rho, a shock that passes
    the length U of the unstrained bar in a unit of time leaves, by mass and momentum (Rankine and
    Hugoniot; no law of energy is needed where stress does not depend on it),

        l = 1 - V / U,    -M ln l = rho U V,    so that (V / c)^2 = -(V / U) ln(1 - V / U).
    """

    summary: ClassVar[str] = "bar that strikes a wall at half its wave speed; shock relations"
    version: ClassVar[int] = 1
    method: ClassVar[tuple[str, ...]] = ("cell_count", "time_step_fraction")
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="cell_count",
            resolutions=(40, 80),
            bounds={"error": 0.02},
            extreme=True,
        ),
    )

    speed_ratio: float = parameter(
        0.5, unit="1", meaning="speed of the bar over that of its waves", above=0, maximum=0.9
    )
    cell_count: int = parameter(
        80, unit="1", meaning="cells along the bar", minimum=20, maximum=1000
    )
    time_step_fraction: float = parameter(
        0.1,
        unit="1",
        meaning="time step over that in which a wave crosses a cell",
        above=0,
        maximum=1,
    )

    @property
    def cell_size(self) -> float:
        """Side of a cell, the thickness of the bar [m]."""
        return LENGTH / self.cell_count

    @property
    def shortening(self) -> float:
        """V / U: what the shock takes of the length."""
        from scipy.optimize import brentq

        def excess(shortening: float) -> float:
            return -shortening * math.log1p(-shortening) - self.speed_ratio**2

        return float(brentq(excess, 0.0, 1.0 - 1e-12))

    @property
    def shock_speed(self) -> float:
        """U, in lengths of the unstrained bar [m/s]."""
        return self.speed_ratio * WAVE_SPEED / self.shortening

    @property
    def shock_stress(self) -> float:
        """Stress behind the shock [Pa]."""
        return MODULUS * math.log1p(-self.shortening)

    def plan(self) -> BodyPlan:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.bodies.interface import InterfaceFrame
        from mpm_warp.bodies.planning import make_body_plan
        from mpm_warp.bodies.scene import BodyContact, BodyScene
        from mpm_warp.materials import LinearElastic

        cell = self.cell_size
        spacing = cell / POINTS_PER_CELL
        frame = InterfaceFrame(angle=0.0)
        material = LinearElastic(shear_modulus=0.5 * MODULUS, poissons_ratio=0.0, density=DENSITY)
        bar = frame.body((0.0, cell), (0.0, LENGTH), spacing, material)
        wall = frame.body((-2.0 * cell, 3.0 * cell), (-3.0 * cell, 0.0), spacing, material)
        bodies = (
            replace(bar, retardation_time=DAMPING * cell / WAVE_SPEED),
            replace(wall, held=np.ones(wall.particle_count, dtype=bool)),
        )
        return make_body_plan(
            BodyScene(
                grid=frame.grid_around(bodies, travel=0.0, cell_size=cell, offset=0.0),
                bodies=bodies,
                contacts=(BodyContact(body=0, base=1),),
                time_step_fraction=self.time_step_fraction,
            )
        )

    def run(self, progress: Progress | None = None) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.history import cost
        from mpm_warp.simulation import TimeLoop

        loop = TimeLoop(self.plan())
        begin = time.perf_counter()
        velocity = loop.array("particle.velocity")
        velocity[: self._point_count, 1] = -self.speed_ratio * WAVE_SPEED
        loop.arrays["particle.velocity"].assign(velocity)
        fronts = []
        for share in (0.5, 1.0):
            until = share * TRAVEL * LENGTH / self.shock_speed
            loop.advance(round(until / loop.plan.time_step) - loop.step_count)
            fronts.append((loop.time, self._front(loop)))
            if progress is not None:
                progress(share)
        loop.check()
        run_time = time.perf_counter() - begin
        return self._dataset(loop, np.array(fronts)).assign(cost(loop, run_time=run_time))

    def _dataset(self, loop: TimeLoop, fronts: Floats) -> xarray.Dataset:
        import numpy as np
        import xarray as xr

        from mpm_warp.history import variable

        speed = self.speed_ratio * WAVE_SPEED
        (middle_time, middle_front), (end_time, end_front) = fronts
        shock_speed = (end_front - middle_front) / (end_time - middle_time)
        velocity = self._along_bar(loop, "particle.velocity", 1)
        stress = self._along_bar(loop, "particle.stress", 1)
        places = self._places
        # Between what the first touch has left at the wall and the shock's own width.
        behind = (places > 0.25 * end_front) & (places < 0.75 * end_front)
        errors = {
            "shock_speed_error": (
                shock_speed / self.shock_speed - 1.0,
                "error of the shock's speed",
            ),
            "stress_error": (
                stress[behind].mean() / self.shock_stress - 1.0,
                "error of the mean stress behind the shock",
            ),
            "velocity_error": (
                velocity[behind].mean() / speed,
                "mean velocity behind the shock over that of the bar",
            ),
        }
        passed = places < self.shock_speed * end_time
        curves = {
            "stress": (stress, "Pa", "stress along the bar at the end"),
            "stress_exact": (np.where(passed, self.shock_stress, 0.0), "Pa", "stress, exact"),
            "velocity": (velocity, "m s-1", "velocity along the bar at the end"),
            "velocity_exact": (np.where(passed, 0.0, -speed), "m s-1", "velocity, exact"),
        }
        greatest = max(abs(value) for value, _ in errors.values())
        variables = {
            "error": variable(
                greatest, unit="1", meaning="greatest error of shock speed, stress and velocity"
            ),
            "stress_scatter": variable(
                stress[behind].std() / abs(self.shock_stress),
                unit="1",
                meaning="standard deviation of the stress behind the shock, over it",
            ),
        }
        variables |= {
            name: variable(abs(value), unit="1", meaning=meaning)
            for name, (value, meaning) in errors.items()
        } | {
            name: variable(values, unit=unit, meaning=meaning, dims=("place",))
            for name, (values, unit, meaning) in curves.items()
        }
        axis = variable(places, unit="m", meaning="place in the unstrained bar", dims=("place",))
        return xr.Dataset(variables, coords={"place": axis})

    def _front(self, loop: TimeLoop) -> float:
        """Where in the unstrained bar half the velocity is gone [m]."""
        import numpy as np

        half = -0.5 * self.speed_ratio * WAVE_SPEED
        velocity = self._along_bar(loop, "particle.velocity", 1)
        first = int(np.flatnonzero(velocity < half)[0])
        around = [first, first - 1]
        return float(np.interp(half, velocity[around], self._places[around]))

    def _along_bar(self, loop: TimeLoop, name: str, component: int) -> Floats:
        """Means over the thickness, from the wall up."""
        values = loop.array(name)[: self._point_count, component]
        mean: Floats = values.reshape(-1, POINTS_PER_CELL).mean(axis=1)
        return mean

    @property
    def _point_count(self) -> int:
        return POINTS_PER_CELL**2 * self.cell_count

    @property
    def _places(self) -> Floats:
        """Places of the points along the unstrained bar, from the wall [m]."""
        import numpy as np

        count = POINTS_PER_CELL * self.cell_count
        places: Floats = LENGTH * (np.arange(count) + 0.5) / count
        return places
