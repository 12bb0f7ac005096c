"""A confined column that settles under its own weight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.linear_elastic import LinearElastic
from mpm_warp.parameters import parameter, redefined
from mpm_warp.parts.forces import Damping, Gravity
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import even_steps, follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue import CatalogueScene, Progress, Verification
from mpm_warp.scenes.clay import ClayScene
from mpm_warp.scenes.run_size import RunSize, shortest_crossing, size_in_grid
from mpm_warp.scenes.waves.column import Column
from mpm_warp.simulation import Simulation

HEIGHT = 1.0
GRAVITY = 9.81
DENSITY = 1700.0
PERIODS = 8.0
"""Time to come to rest, in the column's periods: critically damped, e^-50 of the motion stays."""
TIME_STEP_FRACTION = 0.85


@dataclass(frozen=True, kw_only=True)
class GravityColumn(CatalogueScene):
    """Elastic soil, at first without weight and stress, critically damped until it is at rest.

    From the base up, with M the constrained modulus: sigma = -rho g (H - z), and the displacement
    u = -rho g (H z - z^2/2) / M.
    """

    summary: ClassVar[str] = "column under its own weight, stress and settlement"
    version: ClassVar[int] = 3
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(resolution="cell_count", resolutions=(10, 20, 40), bounds={"error": 0.005}),
    )

    cell_count: int = parameter(
        40, unit="1", meaning="cells along the height", minimum=2, maximum=1000
    )
    poissons_ratio: float = redefined(ClayScene, "poissons_ratio", default=0.3)
    settlement_ratio: float = parameter(
        1e-4, unit="1", meaning="settlement over height", minimum=1e-9, maximum=1e-3
    )

    @property
    def material(self) -> LinearElastic:
        """The soil."""
        constrained_modulus = DENSITY * GRAVITY * HEIGHT / (2 * self.settlement_ratio)
        nu = self.poissons_ratio
        return LinearElastic(
            shear_modulus=constrained_modulus * (1 - 2 * nu) / (2 * (1 - nu)),
            poissons_ratio=nu,
            density=DENSITY,
        )

    def run_size(self) -> RunSize:
        """Cells of the column, and the steps until it is at rest."""
        grid = self._column.grid
        crossings = PERIODS * 4 * HEIGHT / shortest_crossing(grid)
        return size_in_grid(grid, particles_per_cell=4, step_count=crossings / TIME_STEP_FRACTION)

    def build(self) -> Scene:
        """The column, its weight, and the damping that brings it to rest."""
        material = self.material
        # Twice the angular frequency of the first mode, pi c / 2 H.
        damping = math.pi * material.pressure_wave_speed / HEIGHT
        return Scene(
            grid=self._column.grid,
            material=material,
            particles_per_side=2,
            time_step_fraction=TIME_STEP_FRACTION,
            parts=(Gravity(GRAVITY), Damping(damping), self._column.fixed),
        )

    @property
    def _column(self) -> Column:
        return Column(height=HEIGHT, cell_count=self.cell_count)

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Let the column come to rest, and compare stress and settlement with the exact ones."""
        position = simulation.array("particle.position").copy()
        period = 4 * HEIGHT / soil_scene(simulation).material.pressure_wave_speed
        step_count = round(PERIODS * period / simulation.plan.time_step)
        steps = even_steps(step_count)
        recorded = follow(simulation, steps, simulation.advance_to_step, [], progress)
        return recorded.merge(self._at_rest(simulation, position))

    def _at_rest(self, simulation: Simulation, position: Floats) -> xr.Dataset:
        """Stress and settlement, beside the exact ones.

        Args:
            simulation: at rest.
            position: of the particles at the start [m], shape [particle_count, 2].
        """
        column = self._column
        mass = simulation.array("particle.mass")
        change = simulation.array("particle.position")[:, 1] - position[:, 1]
        displacement = column.mean_over_sections(change, mass)
        height = column.mean_over_sections(position[:, 1], mass)
        # The settlement of the top lies on the line through the two sections of the last cell.
        slope = (displacement[-1] - displacement[-2]) / (height[-1] - height[-2])
        settlement = -(displacement[-1] + slope * (HEIGHT - height[-1]))
        exact_settlement = self.settlement_ratio * HEIGHT
        stress = simulation.array("cell.stress")[:, 1]
        middles = 0.5 * (column.grid.rows[1:] + column.grid.rows[:-1])
        weight = DENSITY * GRAVITY * HEIGHT
        exact_stress = -DENSITY * GRAVITY * (HEIGHT - middles)
        error = max(
            np.abs(stress - exact_stress).max() / weight,
            abs(settlement / exact_settlement - 1),
        )
        description = (
            "the greater of the greatest error of the vertical stress, over that at the base, and "
            "the relative error of the settlement"
        )
        error_quantity = (error, "1", "error of stress and settlement", description)
        return curves(
            "height",
            (middles, "m", "height of the cell's middle"),
            stress=(stress, "Pa", "vertical stress"),
            stress_exact=(exact_stress, "Pa", "vertical stress, exact"),
        ).assign(
            labelled(role="headline", error=error_quantity)
            | labelled(
                settlement=(settlement, "m", "settlement of the top"),
                settlement_exact=(exact_settlement, "m", "settlement of the top, exact"),
            )
        )
