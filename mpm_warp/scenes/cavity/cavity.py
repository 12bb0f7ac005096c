"""Cylindrical and spherical cavities that expand in undrained clay, against exact pressures."""

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import group, parameter, redefined
from mpm_warp.grid.fitted import Floats, Grid, graded
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials.material import Material
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.results import Quantity, curves, labelled
from mpm_warp.sampling import (
    PORE_PRESSURE_IS,
    Samples,
    evenly,
    excess_pore_pressure,
    follow,
    soil_scene,
)
from mpm_warp.scene import Part, Scene
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.cavity.exact import RADIUS, ExactCavity
from mpm_warp.scenes.clay import STRAIN_RATE, Clay
from mpm_warp.scenes.clay_scene import ClayScene
from mpm_warp.scenes.limits import limited
from mpm_warp.simulation import Simulation

STRENGTH = 1e3
DENSITY = 1700.0
SAMPLE_COUNT = 150


@dataclass(frozen=True, kw_only=True)
class ClayAroundCavity(Clay):
    """Clay whose strength is the unit of stress, unless its law has a strength of its own."""

    rigidity_index: float = redefined(Clay, "rigidity_index", minimum=10, maximum=2000)
    poissons_ratio: float = redefined(Clay, "poissons_ratio", default=0.495, minimum=0.4)

    @property
    def undrained_shear_strength(self) -> float:
        """See `Clay`."""
        return STRENGTH if self.own_strength is None else self.own_strength


@dataclass(frozen=True, kw_only=True, init=False)
class Cavity(ClayScene):
    """A cavity in clay. Its wall moves outward, and the grid follows it.

    The exact pressures are those of incompressible clay at strains of any size (`ExactCavity`). Von
    Mises soil, with sqrt(J2) = su, yields like Tresca soil in the plane strain around a cylinder,
    and around a sphere like Tresca soil of strength sqrt(3)/2 su. The simulated soil is slightly
    compressible (Poisson's ratio 0.495). This changes the limit pressure over su by
    ln(2 (1 + nu) / (5 - 4 nu)) = -0.0100 for the cylinder and by
    4/3 ln((1 + nu) / (3 (1 - nu))) = -0.0177 for the sphere (Hill 1950), without a correction.
    """

    method = ("cells_per_radius", "particles_per_cell", "speed_ratio")
    limits = limited(
        error="more cells_per_radius or particles_per_cell, or a lower speed_ratio",
        pore_pressure_error="more cells_per_radius or particles_per_cell, or a lower speed_ratio",
    )
    exponent: ClassVar[int]
    """m: 2 for the cylinder, 3 for the sphere."""
    von_mises_strength: ClassVar[float]
    """Shear stress (s1 - s3) / 2 at which von Mises soil around the cavity yields, over su."""

    clay: ClayAroundCavity = group()
    expansion_rate: float = parameter(
        1.0,
        "real speed of the wall over the initial radius, for the rate effect",
        **STRAIN_RATE,
    )
    expansion: float = parameter(
        4.0, "final over initial radius of the cavity", minimum=1.1, maximum=10
    )
    cells_per_radius: int = parameter(
        8, "cells per initial radius at the wall", minimum=1, maximum=40
    )
    particles_per_cell: int = parameter(4, "material points per cell", choices=(1, 4, 9, 16, 25))
    speed_ratio: float = parameter(
        0.03, "speed of the wall over sqrt(su / density)", minimum=1e-3, maximum=0.3
    )

    @abstractmethod
    def grid(self) -> Grid:
        """The grid around the cavity."""

    @abstractmethod
    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Symmetry planes and axes, and the edge of the grid."""

    @property
    def cell_size(self) -> float:
        """Width of the cells at the wall [m]."""
        return RADIUS / self.cells_per_radius

    @property
    def plastic_radius(self) -> float:
        """Approximate radius of the plastic zone at the end [m]."""
        return float(self.expansion * self.clay.rigidity_index ** (1.0 / self.exponent) * RADIUS)

    def columns(self, outer_radius: float) -> Floats:
        """Columns of the grid, closest together at the wall."""
        span = outer_radius - RADIUS
        columns: Floats = graded(self.cell_size, span, 1.0 + 0.5 * self.cell_size / RADIUS)
        return columns / span

    @property
    def soil(self) -> Material:
        """The clay around the cavity, with strain rates as in the real expansion."""
        return self.clay.built(
            density=DENSITY,
            speed_up=self.wall.speed / (self.expansion_rate * RADIUS),
            stress_at_rest=self.stress_at_rest,
        )

    @property
    def wall(self) -> MovingWall:
        """The wall, which reaches its speed after 0.3 of the initial radius."""
        speed = self.speed_ratio * math.sqrt(self.clay.undrained_shear_strength / DENSITY)
        return MovingWall(speed=speed, ramp_travel=0.3 * RADIUS)

    @property
    def end_time(self) -> float:
        """Time at which the wall reaches the final radius [s]."""
        wall = self.wall
        return ((self.expansion - 1.0) * RADIUS + wall.ramp_travel) / wall.speed

    def build(self) -> Scene:
        """The soil around the cavity and the moving wall."""
        grid, material = self.grid(), self.soil
        return Scene(
            grid=grid,
            material=material,
            particles_per_side=math.isqrt(self.particles_per_cell),
            bulk_viscosity=0.2,
            stress_at_rest=self.stress_at_rest,
            parts=(*self.boundaries(grid, material), self.wall),
        )

    @property
    def exact(self) -> ExactCavity | None:
        """The exact pressures; None for a law of another package."""
        soil, law = self.soil, self.clay.material.name
        if not isinstance(soil, UndrainedClay) or not self.clay.is_criterion:
            return None
        return ExactCavity(
            clay=soil,
            rigidity_index=self.clay.rigidity_index,
            wall=self.wall,
            exponent=self.exponent,
            strength_share=self.von_mises_strength if law == "von_mises" else 1.0,
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Expand the cavity, and compare its pressure with the exact one where this is known."""
        grid, exact = soil_scene(simulation).grid, self.exact
        # Areas of the wall at its nodes, per radian. For a sphere their sum is r^2 less 0.6 % at 4
        # cells per radius.
        areas = (grid.wall_vectors * grid.surface_normals).sum(axis=1)
        area = float(areas.sum())
        times, radii, nodal_forces = [simulation.time], [RADIUS], list[Floats]()

        def sample() -> tuple[float, float] | None:
            """Mean expansion and pressure over su since the sample before."""
            if simulation.time == times[-1]:
                return None  # one step may go past several samples
            nodal_forces.append(simulation.array("wall.impulse") / (simulation.time - times[-1]))
            simulation.assign("wall.impulse", 0.0)
            times.append(simulation.time)
            radii.append(float(simulation.array("wall.motion")[0, 2]))
            middle = 0.5 * (radii[-2] + radii[-1]) / RADIUS
            unit_force = area * middle ** (self.exponent - 1) * self.clay.undrained_shear_strength
            return middle, nodal_forces[-1].sum() / unit_force

        def curve(expansion: Floats, pressure: Floats) -> xr.Dataset:
            meaning = "excess pressure over su"
            found: dict[str, Quantity] = {"cavity_pressure": (pressure, "1", meaning)}
            if exact is not None:
                of_exact = (exact.pressure(expansion), "1", f"{meaning}, exact")
                found["cavity_pressure_exact"] = of_exact
            axis = (expansion, "1", "radius of the cavity over the initial radius")
            return curves("expansion", axis, **found)

        moments, samples = evenly(self.end_time, SAMPLE_COUNT), Samples(sample, curve)
        recorded = follow(simulation, moments, simulation.advance_to, [samples], progress)
        if isinstance(grid, PolarGrid):
            pressure = nodal_forces[-1] / areas
            departure = float(np.ptp(pressure) / pressure.mean())
            is_range = "range of the pressure over the wall at the end, over its mean"
            of_shape = (departure, "1", "departure from a sphere", is_range)
            recorded = recorded.assign(labelled(departure=of_shape))
        recorded = recorded.merge(pore_pressure_profile(simulation, exact))
        if exact is None:
            last = recorded.cavity_pressure.values[-1]
            final = (last, "1", "excess cavity pressure at the end over su")
            return recorded.assign(labelled(role="headline", final_cavity_pressure=final))
        difference = recorded.cavity_pressure - recorded.cavity_pressure_exact
        largest = float(np.abs(difference.values).max()) / exact.limit(self.expansion)
        over = (
            "greatest difference over the whole curve, over the limit pressure, or the exact one "
            "at the end where the strength changes"
        )
        error = (largest, "1", "error of the cavity pressure", over)
        return recorded.assign(labelled(role="headline", error=error))


def pore_pressure_profile(simulation: Simulation, exact: ExactCavity | None) -> xr.Dataset:
    """Excess pore pressure at the end by distance from the centre, and the exact one if known."""
    grid = soil_scene(simulation).grid
    radius = float(simulation.array("wall.motion")[0, 2])
    middles = 0.5 * (grid.columns[:-1] + grid.columns[1:])
    distance = 1.0 + (grid.outer_radius / radius - 1.0) * middles
    by_rows = excess_pore_pressure(simulation).reshape(grid.row_count, grid.column_count)
    volumes = simulation.array("cell.volume").reshape(by_rows.shape)
    pressure = np.average(by_rows, axis=0, weights=volumes)
    axis = (distance, "1", "distance from the middle over the radius of the cavity")
    where = f"mean over each column of cells at the end; {PORE_PRESSURE_IS}"
    computed = (pressure, "Pa", "excess pore pressure", where)
    profile = curves("distance", axis, excess_pore_pressure=computed)
    if exact is None:
        return profile
    expected = exact.pore_pressure(distance, expansion=radius / RADIUS)
    of_profile = (expected, "Pa", "excess pore pressure, exact")
    greatest = np.abs(pressure - expected).max() / expected.max()
    over = "greatest difference over the whole profile, over the exact one in the innermost cell"
    error = (greatest, "1", "error of the excess pore pressure", over)
    return profile.assign(
        labelled(dims=("distance",), excess_pore_pressure_exact=of_profile)
        | labelled(role="error", pore_pressure_error=error)
    )
