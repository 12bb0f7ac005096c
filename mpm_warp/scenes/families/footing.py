"""What the scenes of rigid footings on the surface of the ground have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Verification
from mpm_warp.scenes.families.bearing import NO_PARTING, RADIUS, STRENGTH, Bearing

if TYPE_CHECKING:
    from mpm_warp.parts.contact import SurfaceContact
    from mpm_warp.grid.fitted import Floats, Grid


@dataclass(frozen=True, kw_only=True)
class Footing(Bearing):
    """A rigid footing; in plane strain the radius is half the width."""

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

    @property
    def exact_load(self) -> float:
        """See `Bearing`."""
        return self.exact[self.adhesion_factor]

    def grid(self) -> Grid:
        """See `Bearing`."""
        import numpy as np

        from mpm_warp.grid.fitted import Grid, graded

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

    def contact(self, grid: Grid) -> SurfaceContact:
        """Contact of the nodes on the surface from the axis to the rim, both included."""
        import numpy as np

        from mpm_warp.parts.contact import SurfaceContact, nodal_areas

        column = np.arange(self.cells_per_radius + 1)
        radius = RADIUS * column / self.cells_per_radius
        areas = nodal_areas(grid.weight(radius), np.diff(radius))
        return SurfaceContact(
            nodes=grid.node(column, np.full_like(column, grid.row_count)),
            normals=np.tile([0.0, 1.0], (len(column), 1)),
            normal_areas=areas,
            adhesion_forces=self.adhesion_factor * STRENGTH * areas,
            friction=0.0,
            in_situ_stress=NO_PARTING,
            speed=self.speed,
        )

    def load(self, grid: Grid, nodal: Floats) -> float:
        """See `Bearing`."""
        area = RADIUS if grid.planar else 0.5 * RADIUS**2
        return float(nodal[:, 0].sum()) / (area * STRENGTH)
