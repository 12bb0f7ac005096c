"""Cavities that expand in undrained clay: walls that move, pressures beside the exact ones."""

import dataclasses
import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats, Grid, graded
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.parameters import Value, parameter, redefined
from mpm_warp.parts.boundaries import FarField, Fixed, RadialMotion
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
from mpm_warp.scenes.catalogue import Progress, Verification, compared
from mpm_warp.scenes.cavity.exact import RADIUS, ExactCavity
from mpm_warp.scenes.clay import STRAIN_RATE, ClayScene
from mpm_warp.scenes.cone.parameters import ConeInGround
from mpm_warp.simulation import Simulation

STRENGTH = 1e3
DENSITY = 1700.0
SAMPLE_COUNT = 150


@dataclass(frozen=True, kw_only=True)
class Cavity(ClayScene):
    """A cavity in clay whose wall moves, the grid following it.

    The exact pressures are those of incompressible clay with strains of any size (`ExactCavity`).
    Soil of von Mises, with sqrt(J2) = su, yields like that of Tresca in the plane strain around a
    cylinder, and around a sphere like one with sqrt(3)/2 su. The soil here is slightly compressible
    (Poisson's ratio 0.495), which lowers the limit by ln(2 (1 + nu) / (5 - 4 nu)) = -0.0100 and
    4/3 ln((1 + nu) / (3 (1 - nu))) = -0.0177 (Hill 1950); nothing is corrected for that.
    """

    method = ("cells_per_radius", "particles_per_cell", "speed_ratio")
    exponent: ClassVar[int]
    """m: 2 for the cylinder, 3 for the sphere."""
    von_mises_strength: ClassVar[float]
    """Strength of soil of von Mises over su where the cavity takes it to yield."""

    rigidity_index: float = redefined(ClayScene, "rigidity_index", minimum=10, maximum=2000)
    poissons_ratio: float = redefined(ClayScene, "poissons_ratio", default=0.495, minimum=0.4)
    expansion_rate: float = parameter(
        1.0,
        "real speed of the wall over the radius at the start, which strain rates are of",
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
        """Planes and axes of symmetry, and the medium around the grid."""

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
    def undrained_shear_strength(self) -> float:
        """Strength su of the clay [Pa]: that of the law where it has its own."""
        return STRENGTH if self.own_strength is None else self.own_strength

    @property
    def clay(self) -> Material:
        """The clay around the cavity; strain rates are those of the real expansion."""
        return self.clay_with(
            density=DENSITY, speed_up=self.wall.speed / (self.expansion_rate * RADIUS)
        )

    @property
    def wall(self) -> MovingWall:
        """The wall, which reaches its speed after 0.3 of the radius at the start."""
        speed = self.speed_ratio * math.sqrt(self.undrained_shear_strength / DENSITY)
        return MovingWall(speed=speed, ramp_travel=0.3 * RADIUS)

    @property
    def end_time(self) -> float:
        """Time in which the wall gets to the final radius [s]."""
        wall = self.wall
        return ((self.expansion - 1.0) * RADIUS + wall.ramp_travel) / wall.speed

    def build(self) -> Scene:
        """The soil around the cavity, and the wall that moves."""
        grid, material = self.grid(), self.clay
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
        """Closed form or integral of the pressures around it; None in a law of another package."""
        clay = self.clay
        if not isinstance(clay, UndrainedClay) or self.law is not None:
            return None
        return ExactCavity(
            clay=clay,
            rigidity_index=self.rigidity_index,
            wall=self.wall,
            exponent=self.exponent,
            strength_share=self.von_mises_strength if self.material == "von_mises" else 1.0,
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Expand the cavity, and compare its pressure with the exact one, where that is known."""
        grid, exact = soil_scene(simulation).grid, self.exact
        # Of the wall's nodes, per radian; of a sphere together r^2 less 0.6 % at 4 cells.
        areas = (grid.wall_vectors * grid.surface_normals).sum(axis=1)
        area = float(areas.sum())
        times, radii, on_rows = [simulation.time], [RADIUS], list[Floats]()

        def sample() -> tuple[float, float] | None:
            """Expansion and pressure over su, means since the sample before; none in no time."""
            if simulation.time == times[-1]:
                return None  # one step may go past several samples
            on_rows.append(simulation.array("wall.impulse") / (simulation.time - times[-1]))
            simulation.assign("wall.impulse", 0.0)
            times.append(simulation.time)
            radii.append(float(simulation.array("wall.motion")[0, 2]))
            middle = 0.5 * (radii[-2] + radii[-1]) / RADIUS
            unit_force = area * middle ** (self.exponent - 1) * self.undrained_shear_strength
            return middle, on_rows[-1].sum() / unit_force

        def curve(expansion: Floats, pressure: Floats) -> xr.Dataset:
            meaning = "excess pressure over su"
            found: dict[str, Quantity] = {"cavity_pressure": (pressure, "1", meaning)}
            if exact is not None:
                of_exact = (exact.pressure(expansion), "1", f"{meaning}, exact")
                found["cavity_pressure_exact"] = of_exact
            axis = (expansion, "1", "radius of the cavity over that at the start")
            return curves("expansion", axis, **found)

        moments, samples = evenly(self.end_time, SAMPLE_COUNT), Samples(sample, curve)
        recorded = follow(simulation, moments, simulation.advance_to, [samples], progress)
        if isinstance(grid, PolarGrid):
            departure = float(np.ptp(on_rows[-1] / areas) / (on_rows[-1] / areas).mean())
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
    """Excess pore pressure at the end over the distance from the middle, beside the exact one."""
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


MOST_ANISOTROPY = 0.5
"""Of Tresca soil around a cylinder: the vertical stress then stays between the others."""
SOILS: tuple[dict[str, Value], ...] = (
    {"rigidity_index": 50.0, "material": "tresca"},
    {"rigidity_index": 500.0, "material": "tresca"},
    {"rigidity_index": 50.0, "material": "von_mises"},
)
"""Soft and stiff soil, and soil of von Mises."""
CHANGING: tuple[dict[str, Value], ...] = (
    {"rate_factor": 0.1, "reference_strain_rate": 0.01},
    {"remoulded_strength_ratio": 0.2, "ductility": 10.0},
    {"remoulded_strength_ratio": 0.2, "ductility": 1.0},
)
"""Clay with a rate effect, and clay that softens, later and sooner."""


def verifications(largest_error: float, resolutions: tuple[int, ...]) -> tuple[Verification, ...]:
    """Perfectly plastic soils, and clays whose strength changes, at two resolutions."""
    at = partial(compared, "cells_per_radius", resolutions, pore_pressure_error=0.02)
    return at(*SOILS, error=largest_error) + at(*CHANGING, error=0.01)


@dataclass(frozen=True, kw_only=True)
class CavityCylinder(Cavity):
    """One row of cells between smooth ends, around a cylinder whose wall moves outward.

    The axis is vertical. The pressure is that over the horizontal stress before. While the vertical
    stress stays between the others it does not matter to soil of Tresca, which is so for any stress
    anisotropy that is allowed there.
    """

    summary = "pressure of an expanding cylindrical cavity in undrained clay"
    version = 6
    verifications = verifications(0.015, (4, 8))
    exponent = 2
    von_mises_strength = 1.0

    stress_anisotropy: float = redefined(
        ConeInGround,
        "stress_anisotropy",
        meaning="stress anisotropy Delta in the ground before: vertical less horizontal stress "
        "over 2 su; not of von Mises soil, of Tresca -0.5 to 0.5",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        delta, ratio = self.stress_anisotropy, self.remoulded_strength_ratio
        material = self.material
        unknown = "there is no exact pressure"
        is_beyond = material in CRITERIA and abs(delta) > MOST_ANISOTROPY
        for refused, allowed in (
            (delta and material == "von_mises", f"0 where material is {material}: {unknown}"),
            (delta and ratio != 1.0, f"0 where remoulded_strength_ratio is {ratio}: {unknown}"),
            (is_beyond, f">= {-MOST_ANISOTROPY:g} and <= {MOST_ANISOTROPY:g} in Tresca soil"),
        ):
            if refused:
                self.refuse("stress_anisotropy", f": must be {allowed}")

    @property
    def stress_at_rest(self) -> Floats:
        """See `ClayScene`; over the horizontal stress, which the vertical one differs from."""
        over_horizontal = 2.0 * self.stress_anisotropy * self.undrained_shear_strength
        return np.array([0.0, -over_horizontal, 0.0, 0.0])

    def grid(self) -> Grid:
        """One row of cells, to twice the radius of the plastic zone."""
        # Beyond the plastic zone, so that the far field is elastic as it takes it to be.
        outer = 2.0 * self.plastic_radius
        return Grid(
            columns=self.columns(outer),
            rows=np.array([0.0, self.cell_size]),
            surface_radius=np.full(2, RADIUS),
            fitted_radius=outer,
        )

    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Nothing moves along the axis; around the grid is the elastic medium, as springs."""
        fixed = Fixed.on(grid, vertical=["everywhere"])
        far_field = FarField.around(grid, material)
        # Dashpots would push against the flow of soil that never stops: no waves, no dashpots.
        return fixed, dataclasses.replace(far_field, dashpot=0.0 * far_field.dashpot)


@dataclass(frozen=True, kw_only=True)
class CavitySphere(Cavity):
    """A quarter of the half plane, from the axis to the equator, on rays.

    The grid ends, without traction, at six times the radius of the plastic zone: what is missing
    beyond lowers the pressure by 4/3 su / 6^3, a thousandth of the limit.

    The stress before is the same in all directions, so there is no stress anisotropy: with it soil
    does not move along the rays, and neither the strain path of a point nor any pressure is known.

    Where the clay softens, soil moves along the rays alone, as the exact pressure takes it to: a
    free flow of Tresca soil parts from that and bears less.
    """

    summary = "pressure of an expanding spherical cavity in clay under equal stress"
    version = 6
    verifications = verifications(0.02, (4, 6))
    exponent = 3
    von_mises_strength = math.sqrt(0.75)

    def grid(self) -> PolarGrid:
        """Rays from the axis to the equator, to six times the radius of the plastic zone."""
        outer = 6.0 * self.plastic_radius
        row_count = max(2, round(0.5 * math.pi * self.cells_per_radius))
        return PolarGrid(
            columns=self.columns(outer),
            rows=np.linspace(0.0, 0.5 * math.pi, row_count + 1),
            surface_radius=np.full(row_count + 1, RADIUS),
            fitted_radius=outer,
        )

    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Nothing moves across the axis or the equator; the grid ends without traction."""
        fixed = Fixed.on(grid, radial=["bottom"], vertical=["top"])
        return (RadialMotion(), fixed) if self.remoulded_strength_ratio < 1.0 else (fixed,)
