"""A confined column that strikes its base at a speed near that of its waves: the shock in soil."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

if TYPE_CHECKING:
    import xarray

    from mpm_warp.column import Column
    from mpm_warp.execution import Execution
    from mpm_warp.grids import Floats
    from mpm_warp.scene import Scene
    from mpm_warp.shock import Shock

HEIGHT = 1.0
MODULUS = 1e7
"""Modulus of uniaxial strain [Pa]."""
POISSONS_RATIO = 0.3
DENSITY = 1700.0
BULK_VISCOSITY = 1.0
"""A shock is some cells wide."""
TIME_STEP_FRACTION = 0.2


@dataclass(frozen=True, kw_only=True)
class StruckColumn(ReadyScene):
    """Soil that falls on its base all at once; its top leaves cells behind as it comes down.

    The exact solution is that of :class:`mpm_warp.shock.Shock`.
    """

    summary: ClassVar[str] = "column that strikes its base at half its wave speed; shock relations"
    version: ClassVar[int] = 1
    method: ClassVar[tuple[str, ...]] = ("cell_count",)
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="cell_count", resolutions=(40, 80), bounds={"error": 0.02}, extreme=True
        ),
    )

    speed_ratio: float = parameter(
        0.5, unit="1", meaning="speed of the column over that of its waves", above=0, maximum=0.9
    )
    cell_count: int = parameter(
        80, unit="1", meaning="cells along the height", minimum=20, maximum=1000
    )

    @property
    def shock(self) -> Shock:
        """The exact solution."""
        from mpm_warp.shock import Shock

        speed = self.speed_ratio * math.sqrt(MODULUS / DENSITY)
        return Shock(modulus=MODULUS, density=DENSITY, speed=speed)

    def build(self) -> tuple[Scene, Column]:
        """The scene and its column."""
        from mpm_warp.column import Column
        from mpm_warp.materials import LinearElastic
        from mpm_warp.scene import Scene

        nu = POISSONS_RATIO
        column = Column(height=HEIGHT, cell_count=self.cell_count)
        scene = Scene(
            grid=column.grid,
            material=LinearElastic(
                shear_modulus=MODULUS * (1 - 2 * nu) / (2 * (1 - nu)),
                poissons_ratio=nu,
                density=DENSITY,
            ),
            particles_per_side=2,
            time_step_fraction=TIME_STEP_FRACTION,
            velocity_memory=math.inf,
            bulk_viscosity=BULK_VISCOSITY,
            fixed=column.fixed,
            free_surface=True,
        )
        return scene, column

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        return self.build()[0]

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.history import cost
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
