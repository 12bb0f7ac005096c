"""What the scenes of full flow have in common: a round body that soil surrounds on all sides."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mpm_warp.grid.fitted import Floats, Grid, graded
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.parameters import redefined
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.scene import Scene
from mpm_warp.scenes.bearing.bearing import NO_PARTING, RADIUS, STRENGTH, Bearing
from mpm_warp.scenes.shared_parameters import ConeInGround

OUTER_RADIUS = 6.0
"""Where the soil is held, over radius: the mechanism reaches to about three."""


@dataclass(frozen=True, kw_only=True)
class FullFlow(Bearing):
    """Half a round body on rays, moved by a small part of its radius.

    Soil surrounds the body, so that the limit load of a small displacement is that of steady flow.
    """

    planar: ClassVar[bool]
    """Whether the body is a cylinder in plane strain; otherwise it is a sphere."""

    adhesion_factor: float = redefined(
        ConeInGround, "adhesion_factor", meaning="adhesion factor of the body"
    )

    def grid(self) -> PolarGrid:
        """Half a ring around the body, on rays."""
        size, span = RADIUS / self.cells_per_radius, (OUTER_RADIUS - 1.0) * RADIUS
        row_count = round(np.pi * self.cells_per_radius)
        return PolarGrid(
            columns=graded(size, span, 1.0 + 0.3 * size / RADIUS) / span,
            rows=np.linspace(0.0, np.pi, row_count + 1),
            surface_radius=np.full(row_count + 1, RADIUS),
            fitted_radius=OUTER_RADIUS * RADIUS,
            planar=self.planar,
        )

    def fixed(self, grid: Grid) -> Fixed:
        """Nodes on the line of travel, and those around the soil."""
        vertical = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        vertical[:, -1] = True
        radial = vertical.copy()
        radial[[0, -1]] = True
        return Fixed.where(radial=radial, vertical=vertical)

    def contact(self, grid: Grid) -> SurfaceContact:
        """Contact all around the body."""
        assert isinstance(grid, PolarGrid)
        vectors = -grid.wall_vectors
        vectors[[0, -1], 0] = 0.0  # nothing moves off the line of travel
        areas = np.linalg.norm(vectors, axis=1)
        rows = np.arange(grid.row_count + 1)
        return SurfaceContact(
            nodes=grid.node(np.zeros_like(rows), rows),
            normals=vectors / areas[:, None],
            normal_areas=areas,
            adhesion_forces=self.adhesion_factor * STRENGTH * areas,
            friction=0.0,
            in_situ_stress=NO_PARTING,
            speed=self.speed,
        )

    def load(self, scene: Scene, nodal: Floats) -> float:
        """The force along the line of travel, over projected area and su."""
        normals = scene[SurfaceContact].normals
        upward = nodal[:, 0] * normals[:, 1] - nodal[:, 1] * normals[:, 0]
        # Forces are those on half a cylinder, or on a radian of a sphere.
        area = RADIUS if self.planar else 0.5 * RADIUS**2
        return float(upward.sum()) / (area * STRENGTH)
