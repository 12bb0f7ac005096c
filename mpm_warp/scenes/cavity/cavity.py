"""Cylindrical and spherical cavities that expand in undrained clay, against exact pressures."""

import dataclasses
import math
from abc import abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import Value, parameter, redefined
from mpm_warp.grid.fitted import Floats, Grid, graded
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material
from mpm_warp.materials.perfectly_plastic import UndrainedClay
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
from mpm_warp.scenes.limits import limited
from mpm_warp.simulation import Simulation

STRENGTH = 1e3
DENSITY = 1700.0
SAMPLE_COUNT = 150


@dataclass(frozen=True, kw_only=True)
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

    rigidity_index: float = redefined(ClayScene, "rigidity_index", minimum=10, maximum=2000)
    poissons_ratio: float = redefined(ClayScene, "poissons_ratio", default=0.495, minimum=0.4)
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
        return float(self.expansion * self.rigidity_index ** (1.0 / self.exponent) * RADIUS)

    def columns(self, outer_radius: float) -> Floats:
        """Columns of the grid, closest together at the wall."""
        span = outer_radius - RADIUS
        columns: Floats = graded(self.cell_size, span, 1.0 + 0.5 * self.cell_size / RADIUS)
        return columns / span

    @property
    def undrained_shear_strength(self) -> float:
        """Strength su of the clay [Pa]; a law may have its own."""
        return STRENGTH if self.own_strength is None else self.own_strength

    @property
    def clay(self) -> Material:
        """The clay around the cavity, with strain rates as in the real expansion."""
        return self.clay_with(
            density=DENSITY, speed_up=self.wall.speed / (self.expansion_rate * RADIUS)
        )

    @property
    def wall(self) -> MovingWall:
        """The wall, which reaches its speed after 0.3 of the initial radius."""
        speed = self.speed_ratio * math.sqrt(self.undrained_shear_strength / DENSITY)
        return MovingWall(speed=speed, ramp_travel=0.3 * RADIUS)

    @property
    def end_time(self) -> float:
        """Time at which the wall reaches the final radius [s]."""
        wall = self.wall
        return ((self.expansion - 1.0) * RADIUS + wall.ramp_travel) / wall.speed

    def build(self) -> Scene:
        """The soil around the cavity and the moving wall."""
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
        """The exact pressures; None for a law of another package."""
        clay = self.clay
        if not isinstance(clay, UndrainedClay) or not self.is_criterion:
            return None
        return ExactCavity(
            clay=clay,
            rigidity_index=self.rigidity_index,
            wall=self.wall,
            exponent=self.exponent,
            strength_share=self.von_mises_strength if self.material.name == "von_mises" else 1.0,
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
            unit_force = area * middle ** (self.exponent - 1) * self.undrained_shear_strength
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


MOST_ANISOTROPY = 0.5
"""Largest |Delta| of Tresca soil around a cylinder. Up to it the vertical stress stays between the
radial and the hoop stress."""


def verifications(largest_error: float, resolutions: tuple[int, ...]) -> tuple[Verification, ...]:
    """Perfectly plastic soils, and clays with a rate effect or softening, at two resolutions."""
    perfectly_plastic: tuple[dict[str, Value], ...] = (
        {"rigidity_index": 50.0, "material": "tresca"},
        {"rigidity_index": 500.0, "material": "tresca"},
        {"rigidity_index": 50.0, "material": "von_mises"},
    )
    changing: tuple[dict[str, Value], ...] = (
        {"rate_factor": 0.1, "reference_strain_rate": 0.01},
        {"remoulded_strength_ratio": 0.2, "ductility": 10.0},
        {"remoulded_strength_ratio": 0.2, "ductility": 1.0},
    )
    at = partial(compared, "cells_per_radius", resolutions, pore_pressure_error=0.02)
    return at(*perfectly_plastic, error=largest_error) + at(*changing, error=0.01)


@dataclass(frozen=True, kw_only=True)
class CavityCylinder(Cavity):
    """A cylinder with a vertical axis, in one row of cells between smooth ends.

    The pressure is in excess of the initial horizontal stress. The vertical stress does not affect
    Tresca soil while it is the intermediate principal stress; the limits of the stress anisotropy
    ensure this.
    """

    summary = "pressure of an expanding cylindrical cavity in undrained clay"
    version = 6
    verifications = verifications(0.015, (4, 8))
    exponent = 2
    von_mises_strength = 1.0

    stress_anisotropy: float = redefined(
        ConeInGround,
        "stress_anisotropy",
        meaning="stress anisotropy Delta of the ground at rest: vertical less horizontal stress "
        "over 2 su; 0 in von Mises soil, -0.5 to 0.5 in Tresca soil",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        delta, ratio = self.stress_anisotropy, self.remoulded_strength_ratio
        material = self.material.name
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
        """See `ClayScene`; in excess of the horizontal stress."""
        over_horizontal = 2.0 * self.stress_anisotropy * self.undrained_shear_strength
        return np.array([0.0, -over_horizontal, 0.0, 0.0])

    def grid(self) -> Grid:
        """One row of cells, to twice the plastic radius: `FarField` assumes elastic soil."""
        outer = 2.0 * self.plastic_radius
        return Grid(
            columns=self.columns(outer),
            rows=np.array([0.0, self.cell_size]),
            surface_radius=np.full(2, RADIUS),
            fitted_radius=outer,
        )

    def boundaries(self, grid: Grid, material: Material) -> tuple[Part, ...]:
        """Nothing moves along the axis; springs stand for the elastic ground around the grid."""
        fixed = Fixed.on(grid, vertical=["everywhere"])
        far_field = FarField.around(grid, material)
        # Dashpots would resist the steady outward flow, and there are no waves to absorb.
        return fixed, dataclasses.replace(far_field, dashpot=0.0 * far_field.dashpot)


@dataclass(frozen=True, kw_only=True)
class CavitySphere(Cavity):
    """A sphere in a polar grid of the quarter plane from the axis to the equator.

    The grid ends without traction at six times the radius of the plastic zone. The missing ground
    lowers the pressure by 4/3 su / 6^3, a thousandth of the limit.

    The initial stress is isotropic. With stress anisotropy soil would not move along the rays, and
    no exact pressure is known.

    Where the clay softens, soil is guided along the rays, as the exact pressure assumes. Softening
    Tresca soil that is free to flow leaves them and resists less.
    """

    summary = "pressure of an expanding spherical cavity in clay under equal stress"
    version = 6
    verifications = verifications(0.02, (4, 6))
    exponent = 3
    von_mises_strength = math.sqrt(0.75)

    def grid(self) -> PolarGrid:
        """Rays from the axis to the equator, to six times the plastic radius."""
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
