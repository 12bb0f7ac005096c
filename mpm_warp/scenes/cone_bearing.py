"""Bearing capacity of a cone whose shoulder is level with the surface of the ground."""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

if TYPE_CHECKING:
    import xarray

    from mpm_warp.grids import Floats
    from mpm_warp.penetrometer import PenetrometerSurface
    from mpm_warp.scene import Scene

EXACT = {0.0: 4.443, 0.25: 5.089, 0.5: 5.679, 0.75: 6.218, 1.0: 6.690}
"""Load over (base area times su) by adhesion factor: slip lines with the hypothesis of Haar and
von Karman, for an apex angle of 60 degrees."""
RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
POISSONS_RATIO = 0.45
"""The limit load does not depend on it."""
SAMPLE_COUNT = 60


@dataclass(frozen=True, kw_only=True)
class ConeBearing(ReadyScene):
    """A 60 degree cone in weightless Tresca soil, pressed by a small part of its radius.

    What a limit load does not depend on is chosen such that it comes soon: displacements stay far
    below a cell, where the free surface is as sharp as the grid.
    """

    summary: ClassVar[str] = "limit load of a cone with its shoulder at the surface"
    version: ClassVar[int] = 1
    verifications: ClassVar[tuple[Verification, ...]] = tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=(4, 8, 16),
            bounds={"error": 0.02},
            least_order=1.0,
            settings={"adhesion_factor": adhesion_factor},
        )
        for adhesion_factor in EXACT
    )

    adhesion_factor: float = parameter(
        0.0, unit="1", meaning="adhesion factor of the cone", choices=tuple(EXACT)
    )
    cells_per_radius: int = parameter(
        8, unit="1", meaning="cells per cone radius at the cone", minimum=1, maximum=40
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

    def build(self) -> tuple[Scene, PenetrometerSurface]:
        """The scene, and the surface from whose nodes the load is read."""
        import numpy as np

        from mpm_warp.boundaries import Fixed
        from mpm_warp.materials import Tresca
        from mpm_warp.penetrometer import Penetrometer, PenetrometerSurface
        from mpm_warp.scene import Scene

        material = Tresca(
            shear_modulus=self.rigidity_index * STRENGTH,
            poissons_ratio=POISSONS_RATIO,
            density=DENSITY,
            strength=STRENGTH,
        )
        penetrometer = Penetrometer(radius=RADIUS, apex_angle=math.radians(60.0))
        grid = penetrometer.fitted_grid(
            cell_size=RADIUS / self.cells_per_radius,
            cell_growth=0.3,
            outer_radius=5.0 * RADIUS,
            depth_below=2.0 * RADIUS,
            height_above=0.0,
        )
        surface = PenetrometerSurface(
            penetrometer=penetrometer,
            grid=grid,
            face_adhesion=self.adhesion_factor * STRENGTH,
            shaft_adhesion=0.0,
            friction=0.0,
            # More than the soil can pull: the cone and the soil do not part.
            in_situ_stress=100.0 * STRENGTH,
        )
        vertical = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        vertical[0] = True
        radial = vertical.copy()
        radial[grid.surface_radius == 0.0, 0] = True
        radial[:, -1] = True
        speed = self.speed_ratio / self.rigidity_index * material.shear_wave_speed
        scene = Scene(
            grid=grid,
            material=material,
            particles_per_side=2,
            time_step_fraction=0.85,
            # A few passages of a shear wave through a cell.
            velocity_memory=20 * RADIUS / self.cells_per_radius / material.shear_wave_speed,
            bulk_viscosity=0.2,
            fixed=Fixed.where(radial=radial, vertical=vertical),
            contact=dataclasses.replace(surface.contact, speed=speed),
        )
        return scene, surface

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        return self.build()[0]

    def run(self, progress: Progress | None = None) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.history import cost
        from mpm_warp.limit_load import press
        from mpm_warp.simulation import Simulation

        scene, surface = self.build()
        simulation = Simulation(scene)

        def load(nodal: Floats) -> float:
            forces = surface.forces(nodal)
            return (forces.face_normal + forces.face_shear) / (0.5 * RADIUS**2 * STRENGTH)

        start = time.perf_counter()
        curve = press(
            simulation,
            displacement=self.displacement / self.rigidity_index * RADIUS,
            sample_count=SAMPLE_COUNT,
            load=load,
            progress=progress,
        )
        run_time = time.perf_counter() - start
        result = curve.beside(EXACT[self.adhesion_factor], length=RADIUS)
        return result.assign(cost(simulation, run_time=run_time))
