"""A bar that strikes a rigid wall at a speed near that of its waves: the shock that runs back."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.scenes.base import Progress
from mpm_warp.scenes.families.impact import LENGTH, Impact

if TYPE_CHECKING:
    import xarray

    from mpm_warp.bodies.planning import BodyPlan
    from mpm_warp.execution.execution import Execution
    from mpm_warp.grid.fitted import Floats

DAMPING = 0.5
"""Retardation time over the time in which a wave crosses a cell: a shock is some cells wide."""
POINTS_PER_CELL = 2
"""Material points along and across a cell."""
TIME_STEP_FRACTION = 0.1
"""Small: a shock strains what it passes by half, and steps are accurate for small strain each."""


@dataclass(frozen=True, kw_only=True)
class StruckBar(Impact):
    """A body, a bar of Poisson's ratio 0 and a cell thick, comes to rest on another, rigid one."""

    summary: ClassVar[str] = "bar that strikes a wall at half its wave speed; shock relations"
    version: ClassVar[int] = 2
    modulus: ClassVar[float] = 2e6
    density: ClassVar[float] = 1000.0

    def plan(self) -> BodyPlan:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.bodies.interface import InterfaceFrame
        from mpm_warp.bodies.planning import make_body_plan
        from mpm_warp.bodies.scene import BodyContact, BodyScene
        from mpm_warp.materials.materials import LinearElastic

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
        return make_body_plan(
            BodyScene(
                grid=frame.grid_around(bodies, travel=0.0, cell_size=cell, offset=0.0),
                bodies=bodies,
                contacts=(BodyContact(body=0, base=1),),
                time_step_fraction=TIME_STEP_FRACTION,
            )
        )

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.results import cost
        from mpm_warp.shock import follow_shock
        from mpm_warp.simulation import TimeLoop

        loop = TimeLoop(self.plan(), execution)
        begin = time.perf_counter()
        section_count = POINTS_PER_CELL * self.cell_count
        point_count = POINTS_PER_CELL * section_count
        velocity = loop.array("particle.velocity")
        velocity[:point_count, 1] = -self.shock.speed
        loop.arrays["particle.velocity"].assign(velocity)

        def section_means(values: Floats) -> Floats:
            means: Floats = values[:point_count].reshape(-1, POINTS_PER_CELL).mean(axis=1)
            return means

        result = follow_shock(
            loop,
            self.shock,
            places=LENGTH * (np.arange(section_count) + 0.5) / section_count,
            section_means=section_means,
            progress=progress,
        )
        return result.assign(cost(loop, run_time=time.perf_counter() - begin))
