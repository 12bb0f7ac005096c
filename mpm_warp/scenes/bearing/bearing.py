"""A rigid body pressed slowly into soil, up to its limit load."""

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.errors import UnfinishedRun
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import ContactForces, Samples, follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.limits import limited
from mpm_warp.simulation import Simulation

RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
POISSONS_RATIO = 0.45
"""The limit load does not depend on it."""
NO_PARTING = 100.0 * STRENGTH
"""In-situ stress above any tension of the soil, so that body and soil do not part."""
SAMPLE_COUNT = 60
PLATEAU_SHARE = 0.25
"""Last part of the displacement, over which the load must be constant."""
PLATEAU_CHANGE = 0.01
"""Largest change of a linear fit to the load there, over the mean load."""
LEAST_SAMPLES = 3
"""Fewest samples of a plateau."""
LARGEST_MOTION = 1.0
"""Largest displacement in widths of the narrowest cells. Up to 0.96 footings, cones and cylinders
complete; from 1.2 on all but one lost contact or had no plateau."""

Exact = tuple[float, str]
"""A limit load over area and su; its source, and how exact it is."""


@dataclass(frozen=True, kw_only=True)
class Bearing(CatalogueScene):
    """A rigid body in weightless Tresca soil, pressed by a small part of its radius.

    The limit load does not depend on stiffness and density. They are chosen so that it is reached
    at displacements far below a cell, while the free surface is as sharp as the grid.
    """

    method = ("cells_per_radius", "rigidity_index", "displacement", "speed_ratio")
    limits = limited(error="a lower speed_ratio, or more cells_per_radius")
    material = "tresca"
    """Yield criterion of the soil."""
    planar: ClassVar[bool] = False
    """True: plane strain; False: axisymmetry."""

    cells_per_radius: int = parameter(8, "cells per radius of the body", minimum=1, maximum=40)
    rigidity_index: float = parameter(10_000.0, "rigidity index G/su", minimum=100, maximum=1e6)
    displacement: float = parameter(
        30.0, "displacement over radius times G/su", above=0, maximum=300
    )
    speed_ratio: float = parameter(
        0.2, "speed over shear wave speed times G/su", above=0, maximum=10
    )

    @property
    @abstractmethod
    def exact(self) -> Exact | None:
        """The exact limit load; None where it is not known."""

    @abstractmethod
    def grid(self) -> Grid:
        """The grid; its top is the surface of the ground."""

    @abstractmethod
    def contact(self, grid: Grid) -> SurfaceContact:
        """Contact of the soil with the body, which moves down at `speed`."""

    def load(self, scene: Scene, nodal: Floats) -> float:
        """Load over area and su, from normal and tangential forces at the contact nodes [n, 2]."""
        # Forces act on half a body in plane strain, or on a radian of a round one.
        area = RADIUS if scene.grid.planar else 0.5 * RADIUS**2
        return scene[SurfaceContact].upward_force(nodal) / (area * STRENGTH)

    @property
    def cell_size(self) -> float:
        """Width of the narrowest cells below the body [m]."""
        return RADIUS / self.cells_per_radius

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`: the grid is at rest, and soil leaves the cells beside the body."""
        cells = self.final_displacement / self.cell_size
        if cells <= LARGEST_MOTION:
            return ""
        index = self.rigidity_index * cells / LARGEST_MOTION
        displacement = self.displacement * LARGEST_MOTION / cells
        return (
            f"the body moves by {cells:.2g} cells, and soil leaves those beside it; try "
            f"rigidity_index = {math.ceil(index):g} or more, or displacement = "
            f"{math.floor(10.0 * displacement) / 10.0:g} or less"
        )

    @property
    def final_displacement(self) -> float:
        """Displacement of the body at the end [m]."""
        return self.displacement / self.rigidity_index * RADIUS

    @property
    def soil(self) -> UndrainedClay:
        """Weightless, uniform soil."""
        return CRITERIA[self.material](
            shear_modulus=self.rigidity_index * STRENGTH,
            poissons_ratio=POISSONS_RATIO,
            density=DENSITY,
            strength=STRENGTH,
        )

    @property
    def speed(self) -> float:
        """Speed of the body [m/s]."""
        return self.speed_ratio / self.rigidity_index * self.soil.shear_wave_speed

    def fixed(self, grid: Grid) -> Fixed:
        """Nodes on the axis, the side and the bottom."""
        return Fixed.on(grid, radial=["axis", "side", "bottom"], vertical=["bottom"])

    @property
    def end_time(self) -> float:
        """See `CatalogueScene`."""
        return self.final_displacement / self.speed

    def build(self) -> Scene:
        """The ground, and its contact with the body."""
        grid = self.grid()
        return Scene(
            grid=grid,
            material=self.soil,
            bulk_viscosity=0.2,
            parts=(self.fixed(grid), self.contact(grid)),
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Press the body into the ground, and compare its limit load with the exact one.

        Raises:
            UnfinishedRun: the load still changes at the end of the displacement.
        """
        scene, forces = soil_scene(simulation), ContactForces(simulation)
        per_step = self.speed * simulation.plan.time_step

        def sample() -> tuple[float, float]:
            return simulation.step_count * per_step, self.load(scene, forces.take())

        def load_curve(reached: Floats, load: Floats) -> xr.Dataset:
            # Each load is a mean over the steps since the sample before.
            middles = 0.5 * (reached + np.append(0.0, reached[:-1]))
            axis = (middles / RADIUS, "1", "displacement over radius")
            return curves("displacement", axis, resistance=(load, "1", "load over area and su"))

        # There are fewer samples where there are fewer steps.
        shares = np.arange(1, SAMPLE_COUNT + 1) / SAMPLE_COUNT
        steps = np.rint(shares * self.final_displacement / per_step)
        due: list[int] = np.unique(np.maximum(steps, 1.0)).astype(int).tolist()
        recorded = follow(
            simulation, due, simulation.advance_to_step, [Samples(sample, load_curve)], progress
        )
        limit = plateau(recorded.displacement.values, recorded.resistance.values)
        meaning = "limit load over area and su"
        is_mean = (
            f"mean over the last {PLATEAU_SHARE:.0%} of the displacement, if the load changes "
            f"there by at most {PLATEAU_CHANGE:.0%}; else not a number"
        )
        found = labelled(role="headline", bearing_capacity=(limit, "1", meaning, is_mean))
        if self.exact is not None:
            exact, source = self.exact
            of_plateau = "relative error of the plateau"
            error = (abs(limit / exact - 1), "1", "error of the limit load", of_plateau)
            found |= labelled(bearing_capacity_exact=(exact, "1", f"{meaning}, exact", source))
            found |= labelled(role="error", error=error)
        results = recorded.assign(found)
        if math.isnan(limit):
            raise UnfinishedRun(
                f"the load has no plateau: it changes by more than {PLATEAU_CHANGE:.0%} over the "
                f"last {PLATEAU_SHARE:.0%} of displacement = {self.displacement:g}; try more "
                "displacement",
                results,
            )
        return results


def plateau(displacement: Floats, load: Floats) -> float:
    """Mean load of the plateau at the end of a curve; not a number without a plateau."""
    last = displacement >= (1.0 - PLATEAU_SHARE) * displacement[-1]
    displacement, load = displacement[last], load[last]
    if len(load) < LEAST_SAMPLES:
        return math.nan
    change = abs(np.polyfit(displacement, load, 1)[0]) * (displacement[-1] - displacement[0])
    return float(load.mean()) if change <= PLATEAU_CHANGE * abs(load.mean()) else math.nan
