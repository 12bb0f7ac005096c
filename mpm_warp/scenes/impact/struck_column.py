"""A confined column that strikes its base at a speed near that of its waves: the shock in soil."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.linear_elastic import LinearElastic
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.scene import Scene
from mpm_warp.scenes.impact.impact import LENGTH, Impact, Sections
from mpm_warp.scenes.run_size import RunSize, shortest_crossing, size_in_grid
from mpm_warp.scenes.waves.column import Column
from mpm_warp.simulation import Simulation

POISSONS_RATIO = 0.3
BULK_VISCOSITY = 1.0
"""It spreads a shock over some cells."""
TIME_STEP_FRACTION = 0.2


@dataclass(frozen=True, kw_only=True)
class StruckColumn(Impact):
    """Soil that falls on its base all at once; its top leaves cells behind as it comes down."""

    summary: ClassVar[str] = "column that strikes its base at half its wave speed; shock relations"
    version: ClassVar[int] = 3
    modulus: ClassVar[float] = 1e7
    density: ClassVar[float] = 1700.0

    @property
    def column(self) -> Column:
        """The column before the impact."""
        return Column(height=LENGTH, cell_count=self.cell_count)

    def run_size(self) -> RunSize:
        """Cells of the column, and about the steps until the shock has passed it."""
        grid = self.column.grid
        crossings = self.duration * self.wave_speed / shortest_crossing(grid)
        return size_in_grid(grid, particles_per_cell=4, step_count=crossings / TIME_STEP_FRACTION)

    def build(self) -> Scene:
        """Soil in the column, which can move along its height alone."""
        nu = POISSONS_RATIO
        return Scene(
            grid=self.column.grid,
            material=LinearElastic(
                shear_modulus=self.modulus * (1 - 2 * nu) / (2 * (1 - nu)),
                poissons_ratio=nu,
                density=self.density,
            ),
            particles_per_side=2,
            time_step_fraction=TIME_STEP_FRACTION,
            bulk_viscosity=BULK_VISCOSITY,
            parts=(self.column.fixed, FreeSurface()),
        )

    def sections(self, simulation: Simulation) -> Sections:
        """Points at each height; their means are weighted by mass."""
        column, mass = self.column, simulation.array("particle.mass").copy()

        def means(values: Floats) -> Floats:
            return column.mean_over_sections(values, mass)

        return Sections(
            heights=means(simulation.array("particle.position")[:, 1]),
            point_count=len(mass),
            means=means,
        )
