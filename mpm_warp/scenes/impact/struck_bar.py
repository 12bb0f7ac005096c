"""A bar that strikes a rigid wall at a speed near that of its waves: the shock that runs back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from mpm_warp.bodies.body import InterfaceFrame
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.linear_elastic import LinearElastic
from mpm_warp.scenes.impact.impact import LENGTH, Impact, Sections
from mpm_warp.scenes.run_size import BODY_CELL_BYTES, BODY_PARTICLE_BYTES, RunSize
from mpm_warp.simulation import Simulation

DAMPING = 0.5
"""Retardation time over the time in which a wave crosses a cell: a shock is some cells wide."""
POINTS_PER_CELL = 2
"""Material points along and across a cell."""
TIME_STEP_FRACTION = 0.1
"""Small: a shock strains what it passes by half, and each step is accurate for small strain."""


@dataclass(frozen=True, kw_only=True)
class StruckBar(Impact):
    """A body, a bar of Poisson's ratio 0 and a cell thick, comes to rest on another, rigid one."""

    summary: ClassVar[str] = "bar that strikes a wall at half its wave speed; shock relations"
    version: ClassVar[int] = 2
    modulus: ClassVar[float] = 2e6
    density: ClassVar[float] = 1000.0

    def run_size(self) -> RunSize:
        """Cells around bar and wall, their points, and the steps until the shock has passed."""
        crossings = self.duration * self.wave_speed / self.cell_size
        return RunSize(
            cell_count=10 * (self.cell_count + 10),
            particle_count=POINTS_PER_CELL**2 * (self.cell_count + 15),
            step_count=crossings / TIME_STEP_FRACTION,
            bytes_per_cell=BODY_CELL_BYTES,
            bytes_per_particle=BODY_PARTICLE_BYTES,
        )

    def build(self) -> BodyScene:
        """The bar is body 0, the wall body 1."""
        cell = self.cell_size
        spacing = cell / POINTS_PER_CELL
        frame = InterfaceFrame(angle=0.0)
        material = LinearElastic(
            shear_modulus=0.5 * self.modulus, poissons_ratio=0.0, density=self.density
        )
        bar = frame.body((0.0, cell), (0.0, LENGTH), spacing, material)
        wall = frame.body((-2.0 * cell, 3.0 * cell), (-3.0 * cell, 0.0), spacing, material)
        bodies = (
            replace(bar, retardation_time=DAMPING * cell / self.wave_speed),
            replace(wall, held=np.ones(wall.particle_count, dtype=bool)),
        )
        return BodyScene(
            grid=frame.grid_around(bodies, travel=0.0, cell_size=cell, offset=0.0),
            bodies=bodies,
            contacts=(BodyContact(body=0, base=1),),
            time_step_fraction=TIME_STEP_FRACTION,
        )

    def sections(self, simulation: Simulation) -> Sections:
        """Rows of points across the bar."""
        count = POINTS_PER_CELL * self.cell_count
        point_count = POINTS_PER_CELL * count

        def means(values: Floats) -> Floats:
            means: Floats = values[:point_count].reshape(-1, POINTS_PER_CELL).mean(axis=1)
            return means

        return Sections(
            heights=LENGTH * (np.arange(count) + 0.5) / count,
            point_count=point_count,
            means=means,
        )
