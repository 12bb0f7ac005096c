"""Expansion of a cylindrical cavity in undrained clay, at large strain."""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

if TYPE_CHECKING:
    import numpy as np
    import xarray

    from mpm_warp.scene import Scene

RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
SAMPLE_COUNT = 150


@dataclass(frozen=True, kw_only=True)
class CavityCylinder(ReadyScene):
    """One row of cells between smooth ends; the wall moves and the grid follows it.

    Incompressible Tresca soil with strains of any size: with a the radius, a0 that at the start,
    e = 1 - (a0/a)^2, x = 1 - exp(-1/Ir) and Li2 the dilogarithm, (p - p0)/su = Ir Li2(e) while
    e <= x, then Ir Li2(x) + ln(e/x). The soil here is slightly compressible (Poisson's ratio
    0.495), which lowers the limit by ln(2 (1 + nu) / (5 - 4 nu)) = -0.0101 (Hill 1950); nothing is
    corrected for that.
    """

    summary: ClassVar[str] = "pressure of an expanding cylindrical cavity in undrained clay"
    version: ClassVar[int] = 1
    verifications: ClassVar[tuple[Verification, ...]] = tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=(4, 8),
            bounds={"error": 0.015},
            settings={"rigidity_index": rigidity_index},
        )
        for rigidity_index in (50.0, 500.0)
    )

    rigidity_index: float = parameter(
        100.0, unit="1", meaning="rigidity index G/su", minimum=10, maximum=2000
    )
    poissons_ratio: float = parameter(
        0.495, unit="1", meaning="Poisson's ratio", minimum=0.4, maximum=0.4999
    )
    expansion: float = parameter(
        4.0, unit="1", meaning="final over initial radius of the cavity", minimum=1.1, maximum=10
    )
    cells_per_radius: int = parameter(
        8, unit="1", meaning="cells per initial radius at the wall", minimum=1, maximum=40
    )
    particles_per_cell: int = parameter(
        4, unit="1", meaning="material points per cell", choices=(1, 4, 9, 16, 25)
    )
    speed_ratio: float = parameter(
        0.03,
        unit="1",
        meaning="speed of the wall over sqrt(su / density)",
        minimum=1e-3,
        maximum=0.3,
    )

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.boundaries import FarField, Fixed
        from mpm_warp.grids import Grid, graded
        from mpm_warp.materials import Tresca
        from mpm_warp.moving_wall import MovingWall
        from mpm_warp.scene import Scene

        size = RADIUS / self.cells_per_radius
        # Beyond the plastic zone, so that the far field is elastic as it takes it to be.
        outer = 2.0 * self.expansion * math.sqrt(self.rigidity_index) * RADIUS
        span = outer - RADIUS
        columns = graded(size, span, 1.0 + 0.5 * size / RADIUS) / span
        grid = Grid(
            columns=columns,
            rows=np.array([0.0, size]),
            surface_radius=np.full(2, RADIUS),
            outer_radius=outer,
        )
        material = Tresca(
            shear_modulus=self.rigidity_index * STRENGTH,
            poissons_ratio=self.poissons_ratio,
            density=DENSITY,
            strength=STRENGTH,
        )
        far_field = FarField.around(grid, material)
        vertical = np.ones((2, len(columns)), dtype=bool)
        speed = self.speed_ratio * math.sqrt(STRENGTH / DENSITY)
        return Scene(
            grid=grid,
            material=material,
            particles_per_side=math.isqrt(self.particles_per_cell),
            time_step_fraction=0.85,
            # The time in which the wall passes a cell.
            velocity_memory=size / speed,
            bulk_viscosity=0.2,
            fixed=Fixed.where(radial=np.zeros_like(vertical), vertical=vertical),
            # Dashpots would push against the flow of soil that never stops: no waves, no dashpots.
            far_field=dataclasses.replace(far_field, dashpot=0.0 * far_field.dashpot),
            moving_wall=MovingWall(speed=speed, ramp_travel=0.3 * RADIUS),
        )

    def exact(self, expansion: np.ndarray) -> np.ndarray:
        """Excess cavity pressure over strength at radii over the initial one, both of shape [n]."""
        import numpy as np

        index = self.rigidity_index
        strain = 1.0 - expansion**-2.0
        yielding = -math.expm1(-1.0 / index)
        elastic = index * _dilogarithm(np.minimum(strain, yielding))
        pressure: np.ndarray = elastic + np.log(np.maximum(strain / yielding, 1.0))
        return pressure

    def run(self, progress: Progress | None = None) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np
        import xarray as xr

        from mpm_warp.history import cost, variable
        from mpm_warp.simulation import Simulation

        scene = self.simulated_scene()
        assert scene.moving_wall is not None
        simulation = Simulation(scene)
        height = float(np.ptp(scene.grid.rows))
        travel = (self.expansion - 1.0) * RADIUS + scene.moving_wall.ramp_travel
        step_count = round(travel / scene.moving_wall.speed / simulation.plan.time_step)
        start = time.perf_counter()
        radius, pressure = [], []
        before = RADIUS
        for sample in range(1, SAMPLE_COUNT + 1):
            steps = step_count * sample // SAMPLE_COUNT - simulation.step_count
            simulation.advance(steps)
            now = float(simulation.array("wall.motion")[0, 2])
            force = simulation.array("wall.impulse").sum() / (steps * simulation.plan.time_step)
            simulation.arrays["wall.impulse"].zero_()
            radius.append(0.5 * (before + now))
            pressure.append(force / (radius[-1] * height) / STRENGTH)
            before = now
            if progress is not None:
                progress(sample / SAMPLE_COUNT)
        simulation.check()
        run_time = time.perf_counter() - start

        expansion, computed = np.array(radius) / RADIUS, np.array(pressure)
        exact = self.exact(expansion)
        limit = 1.0 + math.log(self.rigidity_index)
        dims = ("expansion",)
        variables = {
            "error": variable(
                np.abs(computed - exact).max() / limit,
                unit="1",
                meaning="error of the cavity pressure",
                description="greatest difference over the whole curve, over the limit pressure",
            ),
            "cavity_pressure": variable(
                computed, unit="1", meaning="cavity pressure over su", dims=dims
            ),
            "cavity_pressure_exact": variable(
                exact, unit="1", meaning="cavity pressure over su, exact", dims=dims
            ),
        }
        meaning = "radius of the cavity over that at the start"
        axis = variable(expansion, unit="1", meaning=meaning, dims=dims)
        return xr.Dataset(variables, coords={"expansion": axis}).assign(
            cost(simulation, run_time=run_time)
        )


def _dilogarithm(x: np.ndarray) -> np.ndarray:
    """Li2(x) by its series, for 0 <= x <= 0.1: twelve terms are exact to rounding."""
    import numpy as np

    powers = np.arange(1, 13)
    series: np.ndarray = np.sum(np.asarray(x)[..., None] ** powers / powers**2, axis=-1)
    return series
