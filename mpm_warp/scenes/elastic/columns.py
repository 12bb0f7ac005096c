"""A column of soil that moves along its height alone; one that settles under its own weight."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parameters import parameter, redefined
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.forces import Damping, Gravity
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import even_steps, follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue import CatalogueScene, Progress, compared
from mpm_warp.scenes.clay import ClayScene
from mpm_warp.simulation import Simulation

HEIGHT = 1.0
"""Of any column [m]."""
GRAVITY = 9.81
DENSITY = 1700.0
PERIODS = 8.0
"""Time to come to rest, in the column's periods: critically damped, e^-50 of the motion stays."""


def column(cell_count: int) -> tuple[Grid, Fixed]:
    """Square cells from z = 0 up to `HEIGHT`, which move along z alone, and at the base not."""
    grid = Grid(
        columns=np.array([0.0, 1.0]),
        rows=np.linspace(0.0, HEIGHT, cell_count + 1),
        surface_radius=np.zeros(cell_count + 1),
        fitted_radius=HEIGHT / cell_count,
    )
    return grid, Fixed.on(grid, radial=["everywhere"], vertical=["bottom"])


def mean_over_sections(values: Floats, mass: Floats) -> Floats:
    """Means by mass over the two particles at each height, as seeded, from the base up."""
    return np.average(values.reshape(-1, 2), axis=1, weights=mass.reshape(-1, 2))


def confined(modulus: float, poissons_ratio: float, density: float) -> LinearElastic:
    """An elastic material of a modulus in uniaxial strain [Pa], and a density [kg/m3]."""
    return LinearElastic(
        shear_modulus=modulus * (1 - 2 * poissons_ratio) / (2 * (1 - poissons_ratio)),
        poissons_ratio=poissons_ratio,
        density=density,
    )


@dataclass(frozen=True, kw_only=True)
class GravityColumn(CatalogueScene):
    """Elastic soil, at first without weight and stress, critically damped until it is at rest.

    From the base up, with M the constrained modulus: sigma = -rho g (H - z), and the displacement
    u = -rho g (H z - z^2/2) / M.
    """

    summary = "column under its own weight, stress and settlement"
    version = 3
    verifications = compared("cell_count", (10, 20, 40), error=0.005)

    cell_count: int = parameter(40, "cells along the height", minimum=2, maximum=1000)
    poissons_ratio: float = redefined(ClayScene, "poissons_ratio", default=0.3)
    settlement_ratio: float = parameter(1e-4, "settlement over height", minimum=1e-9, maximum=1e-3)

    @property
    def material(self) -> LinearElastic:
        """Elastic soil that settles by `settlement_ratio` of the height under its weight."""
        modulus = DENSITY * GRAVITY * HEIGHT / (2 * self.settlement_ratio)
        return confined(modulus, self.poissons_ratio, DENSITY)

    @property
    def end_time(self) -> float:
        """See `CatalogueScene`: the time to come to rest [s]."""
        return PERIODS * 4 * HEIGHT / self.material.pressure_wave_speed

    def build(self) -> Scene:
        """The column, its weight, and the damping that brings it to rest."""
        (grid, fixed), material = column(self.cell_count), self.material
        # Twice the angular frequency of the first mode, pi c / 2 H.
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
        # The settlement of the top lies on the line through the two sections of the last cell.
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
