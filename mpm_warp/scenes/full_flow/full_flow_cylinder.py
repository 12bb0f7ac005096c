"""A cylinder (T-bar) that soil flows around on all sides, in plane strain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mpm_warp.grid.fitted import Floats, Grid, graded
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.parameters import parameter
from mpm_warp.parts.boundaries.fixed import Fixed
from mpm_warp.parts.contact.contact import SurfaceContact
from mpm_warp.scene import Scene
from mpm_warp.scenes.bearing.common import NO_PARTING, RADIUS, STRENGTH, Bearing
from mpm_warp.scenes.catalogue import Verification

OUTER_RADIUS = 6.0
"""Where the soil is held, over radius: the mechanism reaches to about three."""


@dataclass(frozen=True, kw_only=True)
class FullFlowCylinder(Bearing):
    """Half a cylinder on rays, moved by a small part of its radius.

    Soil surrounds the cylinder, so that the limit load of a small displacement is that of steady
    flow. Force over (diameter times su), with D = asin(adhesion factor):
    pi + 2 D + 2 cos D + 4 (cos(D/2) + sin(D/2)); the attribute `exact_source` says where from.
    """

    summary: ClassVar[str] = "force on a cylinder that soil flows around (T-bar), plane strain"
    version: ClassVar[int] = 3
    verifications: ClassVar[tuple[Verification, ...]] = tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=(4, 8),
            bounds={"error": 0.03},
            settings={"adhesion_factor": adhesion_factor},
        )
        for adhesion_factor in (0.0, 0.5, 1.0)
    )

    adhesion_factor: float = parameter(
        0.0, unit="1", meaning="adhesion factor of the cylinder", minimum=0, maximum=1
    )

    @property
    def exact_load(self) -> float:
        """Exact limit load over diameter and su."""
        delta = math.asin(self.adhesion_factor)
        fans = math.cos(0.5 * delta) + math.sin(0.5 * delta)
        return math.pi + 2.0 * delta + 2.0 * math.cos(delta) + 4.0 * fans

    @property
    def exact_source(self) -> str:
        """Where the exact load comes from, and how exact it is."""
        return (
            "lower bound of Randolph & Houlsby 1984, Geotechnique 34(4):613-623, exact for a rough "
            "cylinder; upper bounds for others are at most 0.65 % higher (Martin & Randolph 2006, "
            "Geotechnique 56(2):141-145)"
        )

    def grid(self) -> PolarGrid:
        """Half a ring around the cylinder, on rays."""
        size, span = RADIUS / self.cells_per_radius, (OUTER_RADIUS - 1.0) * RADIUS
        row_count = round(math.pi * self.cells_per_radius)
        return PolarGrid(
            columns=graded(size, span, 1.0 + 0.3 * size / RADIUS) / span,
            rows=np.linspace(0.0, math.pi, row_count + 1),
            surface_radius=np.full(row_count + 1, RADIUS),
            outer_radius=OUTER_RADIUS * RADIUS,
            planar=True,
        )

    def fixed(self, grid: Grid) -> Fixed:
        """Nodes on the line of travel, and those around the soil."""
        vertical = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        vertical[:, -1] = True
        radial = vertical.copy()
        radial[[0, -1]] = True
        return Fixed.where(radial=radial, vertical=vertical)

    def contact(self, grid: Grid) -> SurfaceContact:
        """Contact all around the cylinder."""
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
        """The force along the line of travel, over diameter and su."""
        assert scene.contact is not None
        normals = scene.contact.normals
        upward = nodal[:, 0] * normals[:, 1] - nodal[:, 1] * normals[:, 0]
        return float(upward.sum()) / (RADIUS * STRENGTH)
