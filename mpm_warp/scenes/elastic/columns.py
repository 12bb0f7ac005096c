"""Elastic columns of soil that move along their height only: settlement, and waves."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import parameter, redefined
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.forces import Damping, Gravity
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import even_steps, follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.clay import Clay
from mpm_warp.scenes.limits import limited
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

HEIGHT = 1.0
"""Height of a column [m]."""
GRAVITY = 9.81
DENSITY = 1700.0
PERIODS_TO_REST = 8.0
"""Time to come to rest, in periods of the column: e^-50 of the critically damped motion is left."""


def column(cell_count: int) -> tuple[Grid, Fixed]:
    """Square cells from z = 0 to `HEIGHT`; nodes move along z only, and the base is fixed."""
    grid = Grid(
        columns=np.array([0.0, 1.0]),
        rows=np.linspace(0.0, HEIGHT, cell_count + 1),
        surface_radius=np.zeros(cell_count + 1),
        fitted_radius=HEIGHT / cell_count,
    )
    return grid, Fixed.on(grid, radial=["everywhere"], vertical=["bottom"])


def mean_over_sections(values: Floats, mass: Floats) -> Floats:
    """Means, weighted by mass, over the two points at each height, from the base up."""
    return np.average(values.reshape(-1, 2), axis=1, weights=mass.reshape(-1, 2))


def confined(modulus: float, poissons_ratio: float, density: float) -> LinearElastic:
    """The elastic material with a given modulus of uniaxial strain [Pa]."""
    return LinearElastic(
        shear_modulus=modulus * (1 - 2 * poissons_ratio) / (2 * (1 - poissons_ratio)),
        poissons_ratio=poissons_ratio,
        density=density,
    )


@dataclass(frozen=True, kw_only=True)
class GravityColumn(CatalogueScene):
    """A column, initially without stress, that settles under its weight with critical damping.

    The vertical stress is sigma = -rho g (H - z), and the displacement u = -rho g (H z - z^2/2) / M
    with the height H and the constrained modulus M.

    Example:
        >>> GravityColumn(cell_count=20).build().find(Gravity)
        Gravity(acceleration=9.81)
    """

    summary = "column under its own weight, stress and settlement"
    version = 3
    verifications = compared("cell_count", (10, 20, 40), error=0.005)
    limits = limited(error="more cell_count")

    cell_count: int = parameter(40, "cells along the height", minimum=2, maximum=1000)
    poissons_ratio: float = redefined(Clay, "poissons_ratio", default=0.3)
    settlement_ratio: float = parameter(1e-4, "settlement over height", minimum=1e-9, maximum=1e-3)

    @property
    def material(self) -> LinearElastic:
        """Elastic soil that settles by `settlement_ratio` under its weight."""
        modulus = DENSITY * GRAVITY * HEIGHT / (2 * self.settlement_ratio)
        return confined(modulus, self.poissons_ratio, DENSITY)

    @property
    def end_time(self) -> float:
        """See `CatalogueScene`: the time to come to rest [s]."""
        return PERIODS_TO_REST * 4 * HEIGHT / self.material.pressure_wave_speed

    def build(self) -> Scene:
        """The column, its weight and damping."""
        (grid, fixed), material = column(self.cell_count), self.material
        # Twice the angular frequency pi c / 2 H of the first mode.
        rate = math.pi * material.pressure_wave_speed / HEIGHT
        return Scene(grid=grid, material=material, parts=(Gravity(GRAVITY), Damping(rate), fixed))

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Let the column come to rest, and compare stress and settlement with the exact ones."""
        position = simulation.array("particle.position").copy()
        steps = even_steps(round(self.end_time / simulation.plan.time_step))
        recorded = follow(simulation, steps, simulation.advance_to_step, [], progress)
        mass = simulation.array("particle.mass")
        change = simulation.array("particle.position")[:, 1] - position[:, 1]
        displacement = mean_over_sections(change, mass)
        height = mean_over_sections(position[:, 1], mass)
        # The settlement of the top is extrapolated from the two sections of the last cell.
        slope = (displacement[-1] - displacement[-2]) / (height[-1] - height[-2])
        settlement = -(displacement[-1] + slope * (HEIGHT - height[-1]))
        exact_settlement = self.settlement_ratio * HEIGHT
        stress = simulation.array("cell.stress")[:, 1]
        rows = soil_scene(simulation).grid.rows
        middles = 0.5 * (rows[1:] + rows[:-1])
        weight = DENSITY * GRAVITY * HEIGHT
        exact_stress = -DENSITY * GRAVITY * (HEIGHT - middles)
        error = max(
            np.abs(stress - exact_stress).max() / weight, abs(settlement / exact_settlement - 1)
        )
        description = (
            "the greater of the greatest error of the vertical stress, over that at the base, and "
            "the relative error of the settlement"
        )
        shown = (error, "1", "error of stress and settlement", description)
        along = curves(
            "height",
            (middles, "m", "height of the cell's middle"),
            stress=(stress, "Pa", "vertical stress"),
            stress_exact=(exact_stress, "Pa", "vertical stress, exact"),
        )
        return recorded.merge(along).assign(
            labelled(role="headline", error=shown)
            | labelled(
                settlement=(settlement, "m", "settlement of the top"),
                settlement_exact=(exact_settlement, "m", "settlement of the top, exact"),
            )
        )
