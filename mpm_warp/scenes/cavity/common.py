"""What the scenes of expanding cavities have in common: a wall that moves, and its pressure."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.spacing import graded
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.material import Material
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic
from mpm_warp.parameters import parameter, redefined
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.results import variable
from mpm_warp.sampling import follow, soil_scene
from mpm_warp.scene import Part, Scene
from mpm_warp.scenes.catalogue import Progress
from mpm_warp.scenes.cavity.changing_strength import ChangingStrengthCavity
from mpm_warp.scenes.cavity.pore_pressure import pore_pressure_profile
from mpm_warp.scenes.cavity.pressure_curve import PressureCurve
from mpm_warp.scenes.clay import ClayScene
from mpm_warp.scenes.run_size import RunSize, shortest_crossing, size_in_grid
from mpm_warp.simulation import Simulation

RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
SAMPLE_COUNT = 150
TIME_STEP_FRACTION = 0.85


@dataclass(frozen=True, kw_only=True)
class Cavity(ClayScene):
    """A cavity in clay whose wall moves, the grid following it.

    Incompressible soil with strains of any size: with a the radius, a0 that at the start,
    e = 1 - (a0/a)^m, x = 1 - exp(-1/Ir) and Li2 the dilogarithm, (p - p0)/su = k Ir Li2(e) while
    e <= x, then k (Ir Li2(x) + ln(e/x)); m = 2 and k = 1 for the cylinder, m = 3 and k = 4/3 for
    the sphere. Soil of von Mises, with sqrt(J2) = su, yields like that of Tresca in the plane
    strain around a cylinder, and around a sphere like one with sqrt(3)/2 su. The soil here is
    slightly compressible (Poisson's ratio 0.495), which lowers the limit by
    ln(2 (1 + nu) / (5 - 4 nu)) = -0.0100 and 4/3 ln((1 + nu) / (3 (1 - nu))) = -0.0177 (Hill 1950);
    nothing is corrected for that. Where the strength changes, the pressure is an integral over the
    strain (`strength_law`).
    """

    method: ClassVar[tuple[str, ...]] = ("cells_per_radius", "particles_per_cell", "speed_ratio")
    exponent: ClassVar[int]
    """m: 2 for the cylinder, 3 for the sphere."""
    factor: ClassVar[float]
    """k: 1 for the cylinder, 4/3 for the sphere."""
    von_mises_strength: ClassVar[float]
    """Strength of soil of von Mises over su where the cavity takes it to yield."""

    rigidity_index: float = redefined(ClayScene, "rigidity_index", minimum=10, maximum=2000)
    poissons_ratio: float = redefined(ClayScene, "poissons_ratio", default=0.495, minimum=0.4)
    expansion_rate: float = parameter(
        1.0,
        unit="s-1",
        meaning="real speed of the wall over the radius at the start, which strain rates are of",
        minimum=1e-12,
        maximum=1e6,
    )
    expansion: float = parameter(
        4.0, unit="1", meaning="final over initial radius of the cavity", minimum=1.1, maximum=10
    )
    cells_per_radius: int = parameter(
        8, unit="1", meaning="cells per initial radius at the wall", minimum=1, maximum=40
    )
    particles_per_cell: int = parameter(
        4, unit="1", meaning="material points per cell", choices=(1, 4, 9, 16, 25)
    )
    speed_ratio: float = parameter(
        0.03,
        unit="1",
        meaning="speed of the wall over sqrt(su / density)",
        minimum=1e-3,
        maximum=0.3,
    )

    @abstractmethod
    def grid(self) -> Grid:
        """The grid around the cavity."""

    @abstractmethod
    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Planes and axes of symmetry, and the medium around the grid."""

    @abstractmethod
    def wall_area(self, grid: Grid, radius: float) -> float:
        """Area of the wall per radian [m2] when the cavity has a radius [m]."""

    @property
    def cell_size(self) -> float:
        """Width of the cells at the wall [m]."""
        return RADIUS / self.cells_per_radius

    @property
    def plastic_radius(self) -> float:
        """Radius of the plastic zone at the end [m], about."""
        return float(self.expansion * self.rigidity_index ** (1.0 / self.exponent) * RADIUS)

    def columns(self, outer_radius: float) -> Floats:
        """Columns of the grid, dense at the wall."""
        span = outer_radius - RADIUS
        columns: Floats = graded(self.cell_size, span, 1.0 + 0.5 * self.cell_size / RADIUS)
        return columns / span

    @property
    def clay(self) -> PerfectlyPlastic:
        """The soil."""
        return self.clay_with(
            strength=STRENGTH,
            density=DENSITY,
            speed_up=self.wall.speed / (self.expansion_rate * RADIUS),
        )

    @property
    def wall(self) -> MovingWall:
        """The wall."""
        speed = self.speed_ratio * math.sqrt(STRENGTH / DENSITY)
        return MovingWall(speed=speed, ramp_travel=0.3 * RADIUS)

    def duration(self, wall: MovingWall) -> float:
        """Time in which the wall gets to the final radius [s]."""
        return ((self.expansion - 1.0) * RADIUS + wall.ramp_travel) / wall.speed

    def run_size(self) -> RunSize:
        """Cells around the cavity; the steps are those with the first time step."""
        grid = self.grid()
        time_step = TIME_STEP_FRACTION * shortest_crossing(grid) / self.clay.pressure_wave_speed
        return size_in_grid(
            grid,
            particles_per_cell=self.particles_per_cell,
            step_count=self.duration(self.wall) / time_step,
        )

    def build(self) -> Scene:
        """The soil around the cavity, and the wall that moves."""
        grid, material = self.grid(), self.clay
        return Scene(
            grid=grid,
            material=material,
            particles_per_side=math.isqrt(self.particles_per_cell),
            time_step_fraction=TIME_STEP_FRACTION,
            bulk_viscosity=0.2,
            stress_at_rest=self.stress_at_rest,
            parts=(*self.boundaries(grid, material), self.wall),
        )

    @property
    def stress_at_rest(self) -> Floats:
        """Stress (rr, zz, rz, tt) of the soil before, over that across the wall [Pa], shape [4]."""
        return np.zeros(4)

    def exact(self, expansion: Floats) -> Floats:
        """Excess cavity pressure over strength at radii over the initial one, both of shape [n]."""
        if self._changing is not None:
            return self._changing.pressure(expansion) / STRENGTH
        index = self.rigidity_index / self._strength
        strain = 1.0 - expansion ** -float(self.exponent)
        yielding = -math.expm1(-1.0 / index)
        elastic = index * _dilogarithm(np.minimum(strain, yielding))
        pressure: Floats = elastic + np.log(np.maximum(strain / yielding, 1.0))
        return self.factor * self._strength * pressure

    def exact_pore_pressure(self, distance: Floats, *, expansion: float) -> Floats:
        """Excess pore pressure at distances from the middle [Pa], shape [n].

        Soil at a distance r that was at r0 bears the radial stress of a cavity that has expanded
        from r0 to r, p say; r^m - r0^m is the same everywhere. The mean stress is less than that by
        k times the shear stress, G m ln(r/r0) up to the strength. So in the plastic zone around a
        cavity that has expanded far, (p - p0)/su = k (ln Ir - m ln(r/a)).

        Args:
            distance: over the radius a of the cavity, >= 1, shape [n].
            expansion: a/a0, > 1.
        """
        if self._changing is not None:
            return self._changing.pore_pressure(distance, expansion=expansion)
        m, index = self.exponent, self.rigidity_index / self._strength
        local = distance / (distance**m - 1.0 + expansion**-m) ** (1.0 / m)
        shear = np.minimum(index * m * np.log(local), 1.0)
        pressure: Floats = self.exact(local) - self.factor * self._strength * shear
        return STRENGTH * pressure

    @property
    def limit(self) -> float:
        """Excess pressure over strength that no expansion exceeds, or that at the end."""
        if self._changing is not None:
            return float(self.exact(np.array([self.expansion]))[0])
        return self.factor * self._strength * (1.0 + math.log(self.rigidity_index / self._strength))

    @property
    def _strength(self) -> float:
        """Half the difference of the stresses along and across the wall at yield, over su."""
        return self.von_mises_strength if self.material == "von_mises" else 1.0

    @property
    def _changing(self) -> ChangingStrengthCavity | None:
        """The exact pressures where the strength changes, or none."""
        clay = self.clay
        if not isinstance(clay, EinavRandolph):
            return None
        return ChangingStrengthCavity(
            clay=clay,
            wall=self.wall,
            radius=RADIUS,
            exponent=self.exponent,
            factor=self.factor,
            strength_share=self._strength,
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Expand the cavity, and compare its pressure with the exact one over the whole curve."""
        duration = self.duration(soil_scene(simulation)[MovingWall])
        grid = soil_scene(simulation).grid
        curve = PressureCurve(
            simulation,
            radius=RADIUS,
            strength=STRENGTH,
            wall_area=lambda radius: self.wall_area(grid, radius),
            exact=self.exact,
        )
        moments = [duration * it / SAMPLE_COUNT for it in range(1, SAMPLE_COUNT + 1)]
        recorded = follow(simulation, moments, simulation.advance_to, [curve], progress)
        difference = recorded.cavity_pressure - recorded.cavity_pressure_exact
        error = variable(
            float(np.abs(difference.values).max()) / self.limit,
            unit="1",
            meaning="error of the cavity pressure",
            description="greatest difference over the whole curve, over the limit pressure, "
            "or the exact one at the end where the strength changes",
            role="headline",
        )
        shape = self.shape(grid, curve.on_rows)
        profile = pore_pressure_profile(
            simulation, radius_at_start=RADIUS, exact=self.exact_pore_pressure
        )
        return recorded.assign(error=error).assign(shape).merge(profile)

    def shape(self, grid: Grid, on_rows: Floats) -> dict[str, xr.Variable]:
        """How well the cavity keeps its shape, from the forces on the wall's nodes at the end.

        Args:
            grid: that of the start.
            on_rows: normal forces on the wall by row of nodes [N], shape [row_count + 1].
        """
        return {}


def _dilogarithm(x: Floats) -> Floats:
    """Li2(x) by its series, for 0 <= x <= 0.1: twelve terms are exact to rounding."""
    powers = np.arange(1, 13)
    series: Floats = np.sum(np.asarray(x)[..., None] ** powers / powers**2, axis=-1)
    return series
