"""A bar and a column that strike a rigid wall, against the exact shock."""

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy  # loads its solvers where one is first used: no other scene waits for them
import xarray as xr

from mpm_warp.bodies.body import InterfaceFrame
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import Samples, follow
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.elastic.columns import column, confined, mean_over_sections
from mpm_warp.scenes.limits import LARGEST_ERROR, Limit, Limits
from mpm_warp.scenes.run_size import RunSize, size_of_bodies
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

LENGTH = 1.0
"""Length before the impact [m]."""
SHOCK_TRAVEL = 0.75
"""Part of the length that the shock passes in the run; its speed is measured in the second half."""
BAR_DAMPING = 0.5
"""Retardation time of the bar over the time in which a wave crosses a cell. It spreads the shock
over some cells."""
POINTS_PER_CELL = 2
"""Material points of the bar along and across a cell."""
COLUMN_POISSONS_RATIO = 0.3
COLUMN_BULK_VISCOSITY = 1.0
"""It spreads the shock in the column over some cells."""

GREATEST = "the limit is that of the error, the greatest of three"


@dataclass(frozen=True, kw_only=True)
class Impact(CatalogueScene):
    """A bar along the second axis that moves down on a wall and comes to rest behind a shock.

    The bar has the speed V; its stress at the stretch l is M ln l. The shock travels through the
    unstrained bar at the speed U. With c^2 = M / rho the balances of mass and momentum (Rankine and
    Hugoniot; the balance of energy is not needed, as heat does not affect the stress) give

        l = 1 - V / U,    -M ln l = rho U V,    so that (V / c)^2 = -(V / U) ln(1 - V / U).
    """

    method = ("cell_count",)
    loads_solvers = True  # for the shock
    verifications = compared("cell_count", (40, 80), error=0.02, extreme=True)
    limits: ClassVar[Limits] = {
        "error": Limit(LARGEST_ERROR, "more cell_count"),
        "front_speed_error": GREATEST,
        "stress_error": GREATEST,
        "velocity_error": GREATEST,
    }
    modulus: ClassVar[float]
    """Modulus of uniaxial strain [Pa]."""
    density: ClassVar[float]
    """Density before the impact [kg/m3]."""
    time_step_fraction: ClassVar[float]
    """Time step over the critical one. It is small, because a step is accurate for small strain and
    the shock strains the bar by half."""

    speed_ratio: float = parameter(
        0.5, "speed of the impact over that of waves", minimum=1e-6, maximum=0.9
    )
    cell_count: int = parameter(80, "cells along the length", minimum=20, maximum=1000)

    @property
    def cell_size(self) -> float:
        """Side of a cell [m]."""
        return LENGTH / self.cell_count

    @property
    def wave_speed(self) -> float:
        """Speed of pressure waves before the impact [m/s]."""
        return math.sqrt(self.modulus / self.density)

    @property
    def speed(self) -> float:
        """Speed V of the impact [m/s]."""
        return self.speed_ratio * self.wave_speed

    @cached_property
    def shortening(self) -> float:
        """V / U: the relative shortening behind the shock."""
        square = self.speed**2 * self.density / self.modulus
        found = scipy.optimize.brentq(lambda it: -it * math.log1p(-it) - square, 0.0, 1.0 - 1e-12)
        return float(found)

    @property
    def front_speed(self) -> float:
        """Speed U of the shock through the unstrained bar [m/s]."""
        return self.speed / self.shortening

    @property
    def shock_stress(self) -> float:
        """Stress behind the shock, tension positive [Pa]."""
        return self.modulus * math.log1p(-self.shortening)

    @property
    def end_time(self) -> float:
        """Time of the run [s], up to the height of a section."""
        return SHOCK_TRAVEL * LENGTH / self.front_speed

    @abstractmethod
    def sections(self, simulation: Simulation) -> tuple[Floats, Floats]:
        """Initial heights [m] of the sections of the bar, from the wall up, and weights of points.

        The points of the bar are the first of the simulation. Shapes [section_count] and
        [section_count, points of a section].
        """

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Give the bar its speed, and follow the shock through most of the bar."""
        heights, weights = self.sections(simulation)
        velocity = simulation.array("particle.velocity").copy()
        velocity[: weights.size, 1] = -self.speed
        simulation.assign("particle.velocity", velocity)

        def along_bar(name: str) -> Floats:
            rows = simulation.array(f"particle.{name}")[: weights.size, 1].reshape(weights.shape)
            return np.average(rows, axis=1, weights=weights)

        def front() -> tuple[float, float]:
            """Time, and height in the unstrained bar where the velocity is half of the initial."""
            velocity, half = along_bar("velocity"), -0.5 * self.speed
            first = int(np.flatnonzero(velocity < half)[0])
            around = [first, first - 1]
            return simulation.time, float(np.interp(half, velocity[around], heights[around]))

        def at_end(time: Floats, front: Floats) -> xr.Dataset:
            stress, velocity = along_bar("stress"), along_bar("velocity")
            passed = heights < self.front_speed * simulation.time
            recorded = curves(
                "place",
                (heights, "m", "place in the unstrained bar"),
                stress=(stress, "Pa", "stress at the end"),
                stress_exact=(np.where(passed, self.shock_stress, 0.0), "Pa", "stress, exact"),
                velocity=(velocity, "m s-1", "velocity at the end"),
                velocity_exact=(np.where(passed, 0.0, -self.speed), "m s-1", "velocity, exact"),
            )
            # Away from the wall, where the first contact leaves traces, and from the shock.
            behind = (heights > 0.25 * front[-1]) & (heights < 0.75 * front[-1])
            if time.size < 2:  # the run has ended before
                return recorded
            speed = (front[1] - front[0]) / (time[1] - time[0])
            return recorded.assign(self._errors(speed, stress[behind], velocity[behind]))

        end = SHOCK_TRAVEL * heights[-1] / self.front_speed
        samples = Samples(front, at_end)
        return follow(simulation, [0.5 * end, end], simulation.advance_to, [samples], progress)

    def _errors(
        self, front_speed: float, stress: Floats, velocity: Floats
    ) -> dict[str, xr.Variable]:
        """Errors of the speed of the shock, and of stress and velocity behind it."""
        of_speed = abs(front_speed / self.front_speed - 1.0)
        of_stress = abs(stress.mean() / self.shock_stress - 1.0)
        of_velocity = abs(velocity.mean()) / self.speed
        greatest = max(of_speed, of_stress, of_velocity)
        meaning = "greatest error of the shock's speed, stress and velocity"
        residual = "mean velocity behind the shock over that of the impact"
        scatter = "standard deviation of the stress behind the shock over its mean"
        return (
            labelled(
                role="error",
                front_speed_error=(of_speed, "1", "error of the speed of the shock"),
                stress_error=(of_stress, "1", "error of the mean stress behind the shock"),
                velocity_error=(of_velocity, "1", residual),
            )
            | labelled(role="headline", error=(greatest, "1", meaning))
            | labelled(stress_scatter=(stress.std() / abs(self.shock_stress), "1", scatter))
        )


@dataclass(frozen=True, kw_only=True)
class StruckBar(Impact):
    """A bar of Poisson's ratio 0, one cell thick, that strikes a rigid body.

    Example:
        >>> round(StruckBar(speed_ratio=0.1).wave_speed, 1)  # [m/s]
        44.7
    """

    summary = "bar that strikes a wall at half its wave speed; shock relations"
    version = 2
    modulus = 2e6
    density = 1000.0
    time_step_fraction = 0.1

    def run_size(self) -> RunSize:
        """See `CatalogueScene`."""
        return size_of_bodies(
            cell_count=10 * (self.cell_count + 10),
            particle_count=POINTS_PER_CELL**2 * (self.cell_count + 15),
            step_count=self.end_time * self.wave_speed / self.cell_size / self.time_step_fraction,
        )

    def build(self) -> BodyScene:
        """The bar is body 0, the wall body 1."""
        cell = self.cell_size
        spacing = cell / POINTS_PER_CELL
        frame = InterfaceFrame(angle=0.0)
        material = LinearElastic(
            shear_modulus=0.5 * self.modulus, poissons_ratio=0.0, density=self.density
        )
        bar = frame.body((0.0, cell), (0.0, LENGTH), spacing, material)
        wall = frame.body((-2.0 * cell, 3.0 * cell), (-3.0 * cell, 0.0), spacing, material)
        bodies = (
            replace(bar, retardation_time=BAR_DAMPING * cell / self.wave_speed),
            replace(wall, held=np.ones(wall.particle_count, dtype=bool)),
        )
        return BodyScene(
            grid=frame.grid_around(bodies, travel=0.0, cell_size=cell, offset=0.0),
            bodies=bodies,
            contact=BodyContact(),
            time_step_fraction=self.time_step_fraction,
        )

    def sections(self, simulation: Simulation) -> tuple[Floats, Floats]:
        """Rows of points across the bar, with equal weights."""
        count = POINTS_PER_CELL * self.cell_count
        return LENGTH * (np.arange(count) + 0.5) / count, np.ones((count, POINTS_PER_CELL))


@dataclass(frozen=True, kw_only=True)
class StruckColumn(Impact):
    """A column of soil that strikes its base; as its top comes down, cells above it are empty.

    Example:
        >>> round(StruckColumn(speed_ratio=0.1).wave_speed, 1)  # [m/s]
        76.7
    """

    summary = "column that strikes its base at half its wave speed; shock relations"
    version = 3
    modulus = 1e7
    density = 1700.0
    time_step_fraction = 0.2

    def build(self) -> Scene:
        """The column, which moves along its height only."""
        grid, fixed = column(self.cell_count)
        return Scene(
            grid=grid,
            material=confined(self.modulus, COLUMN_POISSONS_RATIO, self.density),
            time_step_fraction=self.time_step_fraction,
            bulk_viscosity=COLUMN_BULK_VISCOSITY,
            parts=(fixed, FreeSurface()),
        )

    def sections(self, simulation: Simulation) -> tuple[Floats, Floats]:
        """Pairs of points at each height, weighted by mass."""
        mass, position = simulation.array("particle.mass"), simulation.array("particle.position")
        return mean_over_sections(position[:, 1], mass), mass.copy().reshape(-1, 2)
