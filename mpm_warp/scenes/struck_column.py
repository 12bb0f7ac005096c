"""A confined column that strikes its base at a speed near that of its waves: the shock in soil."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.scenes.base import Progress
from mpm_warp.scenes.families.impact import LENGTH, Impact

if TYPE_CHECKING:
    import xarray

    from mpm_warp.execution.execution import Execution
    from mpm_warp.grid.fitted import Floats
    from mpm_warp.scene import Scene
    from mpm_warp.scenes.waves.column import Column

POISSONS_RATIO = 0.3
BULK_VISCOSITY = 1.0
"""A shock is some cells wide."""
TIME_STEP_FRACTION = 0.2


@dataclass(frozen=True, kw_only=True)
class StruckColumn(Impact):
    """Soil that falls on its base all at once; its top leaves cells behind as it comes down."""

    summary: ClassVar[str] = "column that strikes its base at half its wave speed; shock relations"
    version: ClassVar[int] = 2
    modulus: ClassVar[float] = 1e7
    density: ClassVar[float] = 1700.0

    def build(self) -> tuple[Scene, Column]:
        """The scene and its column."""
        from mpm_warp.materials.materials import LinearElastic
        from mpm_warp.scene import Scene
        from mpm_warp.scenes.waves.column import Column

        nu = POISSONS_RATIO
        column = Column(height=LENGTH, cell_count=self.cell_count)
        scene = Scene(
            grid=column.grid,
            material=LinearElastic(
                shear_modulus=self.modulus * (1 - 2 * nu) / (2 * (1 - nu)),
                poissons_ratio=nu,
                density=self.density,
            ),
            particles_per_side=2,
            time_step_fraction=TIME_STEP_FRACTION,
            bulk_viscosity=BULK_VISCOSITY,
            fixed=column.fixed,
            free_surface=True,
            consistent_mass=True,
        )
        return scene, column

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        return self.build()[0]

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.results import cost
        from mpm_warp.shock import follow_shock
        from mpm_warp.simulation import Simulation

        scene, column = self.build()
        simulation = Simulation(scene, execution)
        begin = time.perf_counter()
        mass = simulation.array("particle.mass").copy()
        velocity = simulation.array("particle.velocity")
        velocity[:, 1] = -self.shock.speed
        simulation.arrays["particle.velocity"].assign(velocity)

        def section_means(values: Floats) -> Floats:
            return column.mean_over_sections(values, mass)

        result = follow_shock(
            simulation,
            self.shock,
            places=section_means(simulation.array("particle.position")[:, 1]),
            section_means=section_means,
            progress=progress,
        )
        return result.assign(cost(simulation, run_time=time.perf_counter() - begin))
