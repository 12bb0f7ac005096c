"""An elastic thick-walled cylinder under internal pressure."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import parameter, redefined
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.forces import Damping, NodalLoad
from mpm_warp.results import labelled
from mpm_warp.sampling import even_steps, follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.clay import Clay
from mpm_warp.scenes.limits import limited
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

INNER_RADIUS = 1.0
SHEAR_MODULUS = 1e6
DENSITY = 1700.0
PRESSURE = 2 * SHEAR_MODULUS * 1e-5
"""Pressure on the inner wall [Pa]; in an infinite body it moves the wall by 1e-5 of its radius."""
REST_TIME = 60.0
"""Time to come to rest over the time in which a shear wave travels the outer radius."""


@dataclass(frozen=True, kw_only=True)
class ThickCylinder(CatalogueScene):
    """A ring between smooth ends; the pressure acts from the first step on.

    It is one row of cells in axisymmetry, or a quarter of the section in plane strain.

    The solution of Lame for the pressure p on the inner radius a, with the outer radius b and
    q = p a^2 / (b^2 - a^2), is sigma_r = q (1 - b^2/r^2), sigma_t = q (1 + b^2/r^2),
    sigma_z = 2 nu q and u(a) = p a / (2 G) ((1 - 2 nu) a^2 + b^2) / (b^2 - a^2).

    Example:
        >>> ThickCylinder(cell_count=10).build().grid.cell_count
        10
    """

    summary = "elastic thick-walled cylinder, stresses and wall displacement"
    version = 3
    verifications = compared(
        "cell_count", (10, 20, 40), {}, {"section": "plane_strain"}, error=0.01, least_order=1.0
    )
    limits = limited(error="more cell_count")

    section: str = parameter(
        "axisymmetric",
        "the half plane through the axis, or the plane across it",
        choices=("axisymmetric", "plane_strain"),
    )
    cell_count: int = parameter(40, "cells across the wall", minimum=2, maximum=1000)
    radius_ratio: float = parameter(3.0, "outer over inner radius", minimum=1.1, maximum=100)
    poissons_ratio: float = redefined(Clay, "poissons_ratio", default=0.3)

    @property
    def material(self) -> LinearElastic:
        """The material of the ring."""
        return LinearElastic(
            shear_modulus=SHEAR_MODULUS, poissons_ratio=self.poissons_ratio, density=DENSITY
        )

    @property
    def end_time(self) -> float:
        """See `CatalogueScene`: the time to come to rest [s]."""
        return REST_TIME * self.radius_ratio / self.material.shear_wave_speed

    def build(self) -> Scene:
        """The ring under pressure, damped until it is at rest."""
        material, outer = self.material, self.radius_ratio * INNER_RADIUS
        planar = self.section == "plane_strain"
        height = (outer - INNER_RADIUS) / self.cell_count
        rows = np.linspace(0.0, 0.5 * np.pi, self.cell_count + 1) if planar else [0.0, height]
        grid = (PolarGrid if planar else Grid)(
            columns=np.linspace(0.0, 1.0, self.cell_count + 1),
            rows=np.array(rows),
            surface_radius=np.full(len(rows), INNER_RADIUS),
            fitted_radius=outer,
            planar=planar,
        )
        fixed = Fixed.on(grid, vertical=["everywhere"])
        if planar:  # two planes of symmetry
            fixed = Fixed.on(grid, radial=["bottom"], vertical=["top"])
        # Of the order of the lowest frequency, shear wave speed over mean radius.
        damping = 2 * material.shear_wave_speed / (0.5 * (INNER_RADIUS + grid.outer_radius))
        wall = grid.node(0, np.arange(grid.row_count + 1))
        load = NodalLoad(nodes=wall, forces=PRESSURE * grid.wall_vectors)
        return Scene(grid=grid, material=material, parts=(load, Damping(damping), fixed))

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Let the ring come to rest, and compare stresses and displacement with the exact ones."""
        position = simulation.array("particle.position").copy()
        steps = even_steps(round(self.end_time / simulation.plan.time_step))
        recorded = follow(simulation, steps, simulation.advance_to_step, [], progress)
        grid = soil_scene(simulation).grid
        displacement = _wall_displacement(grid, position, simulation.array("particle.position"))
        radius = np.linspace(INNER_RADIUS, grid.outer_radius, self.cell_count + 1)
        middles = 0.5 * (radius[1:] + radius[:-1])
        stress = simulation.array("cell.stress")[None, :, [0, 3, 1]]
        if isinstance(grid, PolarGrid):
            stress = grid.along_rays(simulation.array("cell.stress"))
        exact_stress, exact_displacement = self.exact(middles)
        weights = middles[:, None]
        difference = np.mean(np.sum(weights * (stress - exact_stress) ** 2, axis=(1, 2)))
        stress_error = math.sqrt(difference / np.sum(weights * exact_stress**2))
        error = max(stress_error, abs(displacement / exact_displacement - 1))
        description = (
            "the greater of the L2 norm of the error of radial, hoop and axial stress, over that "
            "of the exact ones, and the relative error of the displacement"
        )
        shown = (error, "1", "error of stresses and wall displacement", description)
        wall = "displacement of the inner wall"
        radii = labelled(dims=("radius",), radius=(middles, "m", "radius of the cell's middle"))
        results = xr.Dataset(
            labelled(role="headline", error=shown)
            | labelled(
                dims=("radius", "component"),
                stress=(stress.mean(axis=0), "Pa", "stress, mean over the angle"),
                stress_exact=(exact_stress, "Pa", "stress, exact"),
            )
            | labelled(
                wall_displacement=(displacement, "m", wall),
                wall_displacement_exact=(exact_displacement, "m", f"{wall}, exact"),
            ),
            coords=radii | {"component": ["r", "t", "z"]},
        )
        return recorded.merge(results)

    def exact(self, radius: Floats) -> tuple[Floats, float]:
        """Stresses (r, t, z) at radii [Pa], tension positive, and the wall's displacement [m]."""
        a, b, nu = INNER_RADIUS, self.radius_ratio * INNER_RADIUS, self.poissons_ratio
        q = PRESSURE * a**2 / (b**2 - a**2)
        ratio = (b / radius) ** 2
        stress = q * np.stack([1 - ratio, 1 + ratio, np.full_like(ratio, 2 * nu)], axis=-1)
        wall = PRESSURE * a / (2 * SHEAR_MODULUS) * ((1 - 2 * nu) * a**2 + b**2)
        return stress, wall / (b**2 - a**2)


def _wall_displacement(grid: Grid, before: Floats, after: Floats) -> float:
    """Mean displacement of the inner wall [m], from positions of the particles before and after.

    It is extrapolated from the two rings of particles next to the wall.
    """
    distance, now = (
        np.hypot(*position.T) if grid.polar else position[:, 0] for position in (before, after)
    )
    rings = distance.reshape(2 * grid.row_count, -1)[:, :2]
    change = (now - distance).reshape(2 * grid.row_count, -1)[:, :2]
    slope = (change[:, 1] - change[:, 0]) / (rings[:, 1] - rings[:, 0])
    return float(np.mean(change[:, 0] + slope * (INNER_RADIUS - rings[:, 0])))
