"""A cone pushed into the ground from first touch."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

if TYPE_CHECKING:
    import xarray

    from mpm_warp.execution.execution import Execution
    from mpm_warp.grid.fitted import GroundGrid
    from mpm_warp.penetrometer import Penetrometer, PenetrometerSurface
    from mpm_warp.scene import Scene

RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
POISSONS_RATIO = 0.49
FINAL_DEPTH = 0.6
"""Over the height of the cone: the ground that rises beside it stays below the shoulder."""
FITTED_FROM = 0.3
"""Share of the final depth from which the exponent is fitted: before, the cone is in few cells."""
SAMPLE_COUNT = 60


@dataclass(frozen=True, kw_only=True)
class ConeSelfSimilar(ReadyScene):
    """Nothing in the problem has a length but the depth: the load is proportional to its square.

    The grid travels down with the cone, through the surface of the ground, which cuts its cells.
    """

    summary: ClassVar[str] = "load of a cone against its depth, from first touch"
    version: ClassVar[int] = 3
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="cells_per_radius",
            resolutions=(12, 16),
            bounds={"error": 0.05},
        ),
    )

    rigidity_index: float = parameter(
        100.0, unit="1", meaning="rigidity index G/su", minimum=10, maximum=1000
    )
    adhesion_factor: float = parameter(
        0.0, unit="1", meaning="adhesion factor of the cone", minimum=0, maximum=1
    )
    apex_angle: float = parameter(
        60.0, unit="degree", meaning="apex angle of the cone", minimum=30, maximum=120
    )
    cells_per_radius: int = parameter(
        16, unit="1", meaning="cells per radius of the cone's base", minimum=4, maximum=40
    )
    speed_ratio: float = parameter(
        0.03, unit="1", meaning="speed over shear wave speed", minimum=1e-3, maximum=0.1
    )

    def build(self) -> tuple[Scene, PenetrometerSurface]:
        """The scene, and the surface from whose nodes the load is read."""
        import numpy as np

        from mpm_warp.parts.boundaries import Fixed
        from mpm_warp.materials.materials import Tresca
        from mpm_warp.penetrometer import PenetrometerSurface
        from mpm_warp.scene import Scene
        from mpm_warp.parts.window import Window

        material = Tresca(
            shear_modulus=self.rigidity_index * STRENGTH,
            poissons_ratio=POISSONS_RATIO,
            density=DENSITY,
            strength=STRENGTH,
        )
        grid = self._grid()
        radial = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        radial[0] = radial[:, -1] = True
        vertical = radial.copy()
        radial[grid.surface_radius == 0.0, 0] = True
        surface = PenetrometerSurface(
            penetrometer=self._penetrometer,
            grid=grid,
            face_adhesion=self.adhesion_factor * STRENGTH,
            shaft_adhesion=0.0,
            friction=0.0,
            in_situ_stress=0.0,
        )
        speed = self.speed_ratio * material.shear_wave_speed
        scene = Scene(
            grid=grid,
            material=material,
            particles_per_side=2,
            time_step_fraction=0.7,
            bulk_viscosity=0.2,
            fixed=Fixed.where(radial=radial, vertical=vertical),
            contact=surface.contact,
            # Soil enters below, and none leaves above.
            window=Window(speed=speed, ramp_travel=0.1 * RADIUS, spare_fraction=1.0),
            free_surface=True,
        )
        return scene, surface

    @property
    def _penetrometer(self) -> Penetrometer:
        from mpm_warp.penetrometer import Penetrometer

        return Penetrometer(radius=RADIUS, apex_angle=math.radians(self.apex_angle))

    def _grid(self) -> GroundGrid:
        from mpm_warp.grid.fitted import GroundGrid

        fitted = self._penetrometer.fitted_grid(
            cell_size=RADIUS / self.cells_per_radius,
            cell_growth=0.8,
            outer_radius=20.0 * RADIUS,
            depth_below=12.0 * RADIUS,
            height_above=RADIUS,
        )
        return GroundGrid(
            columns=fitted.columns,
            rows=fitted.rows,
            surface_radius=fitted.surface_radius,
            outer_radius=fitted.outer_radius,
            ground_level=0.0,
        )

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        return self.build()[0]

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.results import cost, curves_kept, variable
        from mpm_warp.simulation import Simulation
        from mpm_warp.travel import Travel

        scene, surface = self.build()
        simulation = Simulation(scene, execution)
        travel = Travel(simulation)
        final = FINAL_DEPTH * self._penetrometer.cone_height
        start = time.perf_counter()
        reached: list[float] = [0.0]
        loads: list[float] = []
        with curves_kept(lambda: _curve(reached, loads)):
            for sample in range(1, SAMPLE_COUNT + 1):
                travel.advance_to(final * sample / SAMPLE_COUNT)
                forces = surface.forces(simulation.take_contact_forces())
                reached.append(travel.distance)
                loads.append(2.0 * math.pi * (forces.face_normal + forces.face_shear))
                if progress is not None:
                    progress(sample / SAMPLE_COUNT)
            simulation.check()
        run_time = time.perf_counter() - start

        curve = _curve(reached, loads)
        depth, load = curve["depth"].values, curve["load"].values
        late = depth > FITTED_FROM * final
        # By the work, whose exponent is greater by one: in it the load's noise averages out.
        travelled = np.array(reached[1:])
        work = np.cumsum(load * np.diff(reached))
        exponent = float(np.polyfit(np.log(travelled[late]), np.log(work[late]), 1)[0]) - 1.0
        factor = load / (
            STRENGTH * math.pi * (depth * math.tan(math.radians(self.apex_angle) / 2)) ** 2
        )
        variables = {
            "error": variable(
                abs(exponent - 2.0), unit="1", meaning="error of the exponent of the depth"
            ),
            "exponent": variable(
                exponent,
                unit="1",
                meaning="exponent of the depth in the load",
                description="that in the work less 1, by least squares of logarithms from "
                f"{FITTED_FROM:.0%} of the final depth; exactly 2 where nothing has a length",
            ),
            "load_factor": variable(
                float(factor[late].mean()),
                unit="1",
                meaning="load over su and the cone's section at the ground's first level",
            ),
        }
        return curve.assign(variables).assign(cost(simulation, run_time=run_time))


def _curve(reached: list[float], loads: list[float]) -> xarray.Dataset:
    """Mean loads over the travel since the sample before, which stand in its middle."""
    import numpy as np
    import xarray as xr

    from mpm_warp.results import variable

    depth = 0.5 * (np.array(reached[1:]) + np.array(reached[:-1]))
    load = variable(np.array(loads), unit="N", meaning="load", dims=("depth",))
    axis = variable(depth, unit="m", meaning="depth of the tip", dims=("depth",))
    return xr.Dataset({"load": load}, coords={"depth": axis})
