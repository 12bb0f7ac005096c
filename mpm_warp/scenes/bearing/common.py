"""What the scenes of bearing capacity have in common: a rigid body pressed into the ground."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.errors import UnfinishedRun
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic
from mpm_warp.materials.tresca import Tresca
from mpm_warp.parameters import parameter
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.sampling import follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.bearing.limit_load import PLATEAU_CHANGE, PLATEAU_SHARE, LoadSampler
from mpm_warp.scenes.catalogue import CatalogueScene, Progress
from mpm_warp.scenes.run_size import RunSize, shortest_crossing, size_in_grid
from mpm_warp.simulation import Simulation

RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
POISSONS_RATIO = 0.45
"""The limit load does not depend on it."""
NO_PARTING = 100.0 * STRENGTH
"""In-situ stress above any that the soil can pull with: the body and the soil do not part."""
SAMPLE_COUNT = 60
TIME_STEP_FRACTION = 0.85


@dataclass(frozen=True, kw_only=True)
class Bearing(CatalogueScene):
    """A rigid body in weightless Tresca soil, pressed by a small part of its radius.

    What a limit load does not depend on is chosen such that it comes soon: displacements stay far
    below a cell, where the free surface is as sharp as the grid.
    """

    method: ClassVar[tuple[str, ...]] = (
        "cells_per_radius",
        "rigidity_index",
        "displacement",
        "speed_ratio",
    )

    cells_per_radius: int = parameter(
        8, unit="1", meaning="cells per radius of the body", minimum=1, maximum=40
    )
    rigidity_index: float = parameter(
        10_000.0, unit="1", meaning="rigidity index G/su", minimum=100, maximum=1e6
    )
    displacement: float = parameter(
        30.0, unit="1", meaning="displacement over radius times G/su", above=0, maximum=300
    )
    speed_ratio: float = parameter(
        0.2, unit="1", meaning="speed over shear wave speed times G/su", above=0, maximum=10
    )

    @property
    @abstractmethod
    def exact_load(self) -> float:
        """Exact limit load over area and su."""

    @property
    @abstractmethod
    def exact_source(self) -> str:
        """Where the exact load comes from, and how exact it is."""

    @abstractmethod
    def grid(self) -> Grid:
        """The grid of the soil, its top the surface of the ground."""

    @abstractmethod
    def contact(self, grid: Grid) -> SurfaceContact:
        """Contact of the soil with the body, which sinks at `speed`."""

    @abstractmethod
    def load(self, scene: Scene, nodal: Floats) -> float:
        """Load over area and su.

        Args:
            scene: what is simulated.
            nodal: normal and tangential forces from the soil at the nodes of its contact [N], shape
                [node_count, 2].
        """

    @property
    def final_displacement(self) -> float:
        """How far the body is pressed [m]."""
        return self.displacement / self.rigidity_index * RADIUS

    @property
    def clay(self) -> PerfectlyPlastic:
        """The soil."""
        return Tresca(
            shear_modulus=self.rigidity_index * STRENGTH,
            poissons_ratio=POISSONS_RATIO,
            density=DENSITY,
            strength=STRENGTH,
        )

    @property
    def speed(self) -> float:
        """Speed of the body [m/s]."""
        return self.speed_ratio / self.rigidity_index * self.clay.shear_wave_speed

    def fixed(self, grid: Grid) -> Fixed:
        """Nodes on the axis, on the side of the soil and below it."""
        vertical = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        vertical[0] = True
        radial = vertical.copy()
        radial[grid.surface_radius == 0.0, 0] = True
        radial[:, -1] = True
        return Fixed.where(radial=radial, vertical=vertical)

    def run_size(self) -> RunSize:
        """Cells of the ground, and the steps to the end of the displacement."""
        grid = self.grid()
        time_step = TIME_STEP_FRACTION * shortest_crossing(grid) / self.clay.pressure_wave_speed
        step_count = self.final_displacement / self.speed / time_step
        return size_in_grid(grid, particles_per_cell=4, step_count=step_count)

    def build(self) -> Scene:
        """The ground, and its contact with the body."""
        grid = self.grid()
        return Scene(
            grid=grid,
            material=self.clay,
            particles_per_side=2,
            time_step_fraction=TIME_STEP_FRACTION,
            bulk_viscosity=0.2,
            parts=(self.fixed(grid), self.contact(grid)),
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Press the body into the ground, and compare the limit of its load with the exact one.

        Raises:
            UnfinishedRun: the load still changes at the end of the displacement.
        """
        scene = soil_scene(simulation)
        sampler = LoadSampler(simulation, length=RADIUS, load=lambda nodal: self.load(scene, nodal))
        steps = sampler.steps(self.final_displacement, SAMPLE_COUNT)
        recorded = follow(simulation, steps, simulation.advance_to_step, [sampler], progress)
        results = recorded.assign(sampler.curve.limit_beside(self.exact_load, self.exact_source))
        if math.isnan(sampler.curve.limit):
            raise UnfinishedRun(
                f"the load has no plateau: it changes by more than {PLATEAU_CHANGE:.0%} over the "
                f"last {PLATEAU_SHARE:.0%} of displacement = {self.displacement:g}; try more "
                "displacement",
                results,
            )
        return results
