"""What the scenes of expanding cavities have in common: a wall that moves, and its pressure."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats, Grid, graded
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material
from mpm_warp.parameters import parameter
from mpm_warp.parts.boundaries.far_field import FarField
from mpm_warp.parts.boundaries.fixed import Fixed
from mpm_warp.parts.boundaries.moving_wall import MovingWall
from mpm_warp.results import curves, variable
from mpm_warp.sampling import follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue import CatalogueScene, Progress, Verification
from mpm_warp.scenes.cavity.pore_pressure import pore_pressure_profile
from mpm_warp.scenes.run_size import RunSize, shortest_crossing, size_in_grid
from mpm_warp.scenes.shared_parameters import yield_criterion
from mpm_warp.simulation import Simulation

RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
SAMPLE_COUNT = 150
TIME_STEP_FRACTION = 0.85
LARGEST_PORE_PRESSURE_ERROR = 0.02
"""Of the profile of excess pore pressure in verifications, over that at the wall."""


@dataclass(frozen=True, kw_only=True)
class Cavity(CatalogueScene):
    """A cavity in perfectly plastic soil whose wall moves, the grid following it.

    Incompressible soil with strains of any size: with a the radius, a0 that at the start,
    e = 1 - (a0/a)^m, x = 1 - exp(-1/Ir) and Li2 the dilogarithm, (p - p0)/su = k Ir Li2(e) while
    e <= x, then k (Ir Li2(x) + ln(e/x)); m = 2 and k = 1 for the cylinder, m = 3 and k = 4/3 for
    the sphere. Soil of von Mises, with sqrt(J2) = su, yields like that of Tresca in the plane
    strain around a cylinder, and around a sphere like one with sqrt(3)/2 su. The soil here is
    slightly compressible (Poisson's ratio 0.495), which lowers the limit by
    ln(2 (1 + nu) / (5 - 4 nu)) = -0.0100 and 4/3 ln((1 + nu) / (3 (1 - nu))) = -0.0177 (Hill 1950);
    nothing is corrected for that.
    """

    method: ClassVar[tuple[str, ...]] = ("cells_per_radius", "particles_per_cell", "speed_ratio")
    exponent: ClassVar[int]
    """m: 2 for the cylinder, 3 for the sphere."""
    factor: ClassVar[float]
    """k: 1 for the cylinder, 4/3 for the sphere."""
    von_mises_strength: ClassVar[float]
    """Strength of soil of von Mises over su where the cavity takes it to yield."""

    rigidity_index: float = parameter(
        100.0, unit="1", meaning="rigidity index G/su", minimum=10, maximum=2000
    )
    material: str = yield_criterion()
    poissons_ratio: float = parameter(
        0.495, unit="1", meaning="Poisson's ratio", minimum=0.4, maximum=0.4999
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
    def fixed(self, grid: Grid) -> Fixed:
        """Nodes on planes and axes of symmetry."""

    @abstractmethod
    def far_field(self, grid: Grid, material: Material) -> FarField | None:
        """The medium around the grid, or none."""

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
    def clay(self) -> Material:
        """The soil."""
        return CRITERIA[self.material](
            shear_modulus=self.rigidity_index * STRENGTH,
            poissons_ratio=self.poissons_ratio,
            density=DENSITY,
            strength=STRENGTH,
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
            fixed=self.fixed(grid),
            far_field=self.far_field(grid, material),
            moving_wall=self.wall,
        )

    @property
    def stress_at_rest(self) -> Floats:
        """Stress (rr, zz, rz, tt) of the soil before, over that across the wall [Pa], shape [4]."""
        return np.zeros(4)

    def exact(self, expansion: Floats) -> Floats:
        """Excess cavity pressure over strength at radii over the initial one, both of shape [n]."""
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
        m, index = self.exponent, self.rigidity_index / self._strength
        local = distance / (distance**m - 1.0 + expansion**-m) ** (1.0 / m)
        shear = np.minimum(index * m * np.log(local), 1.0)
        pressure: Floats = self.exact(local) - self.factor * self._strength * shear
        return STRENGTH * pressure

    @property
    def limit(self) -> float:
        """Excess pressure over strength that no expansion exceeds."""
        return self.factor * self._strength * (1.0 + math.log(self.rigidity_index / self._strength))

    @property
    def _strength(self) -> float:
        """Half the difference of the stresses along and across the wall at yield, over su."""
        return self.von_mises_strength if self.material == "von_mises" else 1.0

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Expand the cavity, and compare its pressure with the exact one over the whole curve."""
        wall = soil_scene(simulation).moving_wall
        assert wall is not None
        duration = self.duration(wall)
        curve = _PressureCurve(self, simulation)
        moments = [duration * it / SAMPLE_COUNT for it in range(1, SAMPLE_COUNT + 1)]
        recorded = follow(simulation, moments, simulation.advance_to, [curve], progress)
        difference = recorded.cavity_pressure - recorded.cavity_pressure_exact
        error = variable(
            float(np.abs(difference.values).max()) / self.limit,
            unit="1",
            meaning="error of the cavity pressure",
            description="greatest difference over the whole curve, over the limit pressure",
            role="headline",
        )
        shape = self.shape(soil_scene(simulation).grid, curve.on_rows)
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


class _PressureCurve:
    """Samples the pressure in a cavity: means over the time since the sample before.

    Args:
        cavity: the scene.
        simulation: a run of it.
    """

    def __init__(self, cavity: Cavity, simulation: Simulation) -> None:
        self._cavity = cavity
        self._simulation = simulation
        self._sampled_at = simulation.time
        self._radius = RADIUS
        self._expansion: list[float] = []
        self._pressure: list[float] = []
        self.on_rows = np.zeros(soil_scene(simulation).grid.row_count + 1)

    def sample(self) -> None:
        """Take down the radius and the mean pressure since the sample before."""
        simulation = self._simulation
        if simulation.time == self._sampled_at:
            return  # one step may go past several samples
        radius = float(simulation.array("wall.motion")[0, 2])
        self.on_rows = simulation.array("wall.impulse") / (simulation.time - self._sampled_at)
        simulation.assign("wall.impulse", 0.0)
        middle = 0.5 * (self._radius + radius)
        area = self._cavity.wall_area(soil_scene(simulation).grid, middle)
        self._expansion.append(middle / RADIUS)
        self._pressure.append(self.on_rows.sum() / area / STRENGTH)
        self._radius, self._sampled_at = radius, simulation.time

    def dataset(self) -> xr.Dataset:
        """Pressure over su against radius over that at the start, computed and exact."""
        expansion = np.array(self._expansion)
        return curves(
            "expansion",
            (expansion, "1", "radius of the cavity over that at the start"),
            cavity_pressure=(np.array(self._pressure), "1", "excess cavity pressure over su"),
            cavity_pressure_exact=(
                self._cavity.exact(expansion),
                "1",
                "excess cavity pressure over su, exact",
            ),
        )


def verifications(largest_error: float, resolutions: tuple[int, ...]) -> tuple[Verification, ...]:
    """Soft and stiff soil, and soil of von Mises, at two resolutions; bounds the finer's error."""
    return tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=resolutions,
            bounds={"error": largest_error, "pore_pressure_error": LARGEST_PORE_PRESSURE_ERROR},
            settings={"rigidity_index": rigidity_index, "material": material},
        )
        for rigidity_index, material in ((50.0, "tresca"), (500.0, "tresca"), (50.0, "von_mises"))
    )


def _dilogarithm(x: Floats) -> Floats:
    """Li2(x) by its series, for 0 <= x <= 0.1: twelve terms are exact to rounding."""
    powers = np.arange(1, 13)
    series: Floats = np.sum(np.asarray(x)[..., None] ** powers / powers**2, axis=-1)
    return series
