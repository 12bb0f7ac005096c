"""What the scenes of rigid footings on the surface of the ground have in common."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

if TYPE_CHECKING:
    import xarray

    from mpm_warp.contact import SurfaceContact
    from mpm_warp.grids import Floats, Grid
    from mpm_warp.materials import Tresca
    from mpm_warp.scene import Scene

RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
POISSONS_RATIO = 0.45
"""The limit load does not depend on it."""
SAMPLE_COUNT = 60


@dataclass(frozen=True, kw_only=True)
class Footing(ReadyScene):
    """A rigid footing on weightless Tresca soil, pressed by a small part of its radius.

    In plane strain the radius is half the width.
    """

    planar: ClassVar[bool]
    """Whether strain is plane; otherwise the footing is circular."""
    exact: ClassVar[Mapping[float, float]]
    """Exact load over area and su by adhesion factor, smooth and rough."""
    verifications: ClassVar[tuple[Verification, ...]] = tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=(8, 16, 32),
            bounds={"error": 0.02},
            least_order=0.9,
            settings={"adhesion_factor": adhesion_factor},
        )
        for adhesion_factor in (0.0, 1.0)
    )

    adhesion_factor: float = parameter(
        0.0, unit="1", meaning="adhesion factor of the footing", choices=(0.0, 1.0)
    )
    cells_per_radius: int = parameter(
        8, unit="1", meaning="cells per radius below the footing", minimum=1, maximum=40
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

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.boundaries import Fixed
        from mpm_warp.materials import Tresca
        from mpm_warp.scene import Scene

        material = Tresca(
            shear_modulus=self.rigidity_index * STRENGTH,
            poissons_ratio=POISSONS_RATIO,
            density=DENSITY,
            strength=STRENGTH,
        )
        grid = self._grid()
        vertical = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        vertical[0] = True
        radial = vertical.copy()
        radial[:, [0, -1]] = True
        return Scene(
            grid=grid,
            material=material,
            particles_per_side=2,
            time_step_fraction=0.85,
            # A few passages of a shear wave through a cell.
            velocity_memory=20 * RADIUS / self.cells_per_radius / material.shear_wave_speed,
            bulk_viscosity=0.2,
            fixed=Fixed.where(radial=radial, vertical=vertical),
            contact=self._contact(grid, material),
        )

    def _grid(self) -> Grid:
        import numpy as np

        from mpm_warp.grids import Grid, graded

        size = RADIUS / self.cells_per_radius
        outer_radius, depth = 5.0 * RADIUS, 3.0 * RADIUS
        below = np.linspace(0.0, RADIUS, self.cells_per_radius + 1)
        growth = 1.0 + 0.6 * size / RADIUS
        beside = RADIUS + graded(size, outer_radius - RADIUS, growth)
        rows = -graded(size, depth, growth)[::-1]
        return Grid(
            columns=np.append(below, beside[1:]) / outer_radius,
            rows=rows,
            surface_radius=np.zeros_like(rows),
            outer_radius=outer_radius,
            planar=self.planar,
        )

    def _contact(self, grid: Grid, material: Tresca) -> SurfaceContact:
        """Contact of the nodes on the surface from the axis to the rim, both included."""
        import numpy as np

        from mpm_warp.contact import SurfaceContact

        column = np.arange(self.cells_per_radius + 1)
        radius = RADIUS * column / self.cells_per_radius
        # Integrals of N over the footing, or of N r.
        if self.planar:
            lower = upper = 0.5 * np.diff(radius)
        else:
            lower = np.diff(radius) * (radius[:-1] / 3 + radius[1:] / 6)
            upper = np.diff(radius) * (radius[:-1] / 6 + radius[1:] / 3)
        areas = np.append(lower, 0.0) + np.insert(upper, 0, 0.0)
        return SurfaceContact(
            nodes=grid.node(column, np.full_like(column, grid.row_count)),
            normals=np.tile([0.0, 1.0], (len(column), 1)),
            normal_areas=areas,
            adhesion_forces=self.adhesion_factor * STRENGTH * areas,
            friction=0.0,
            # More than the soil can pull: footing and soil do not part.
            in_situ_stress=100.0 * STRENGTH,
            speed=self.speed_ratio / self.rigidity_index * material.shear_wave_speed,
        )

    def run(self, progress: Progress | None = None) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.history import cost
        from mpm_warp.limit_load import press
        from mpm_warp.simulation import Simulation

        simulation = Simulation(self.simulated_scene())
        area = RADIUS if self.planar else 0.5 * RADIUS**2

        def load(nodal: Floats) -> float:
            return float(nodal[:, 0].sum()) / (area * STRENGTH)

        start = time.perf_counter()
        curve = press(
            simulation,
            displacement=self.displacement / self.rigidity_index * RADIUS,
            sample_count=SAMPLE_COUNT,
            load=load,
            progress=progress,
        )
        run_time = time.perf_counter() - start
        result = curve.beside(self.exact[self.adhesion_factor], length=RADIUS)
        return result.assign(cost(simulation, run_time=run_time))
