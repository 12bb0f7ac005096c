"""Rigid footings on the surface of the ground: a disc, and a strip in plane strain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.spacing import graded
from mpm_warp.parameters import parameter
from mpm_warp.parts.contact import SurfaceContact, nodal_areas
from mpm_warp.scene import Scene
from mpm_warp.scenes.bearing.common import NO_PARTING, RADIUS, STRENGTH
from mpm_warp.scenes.bearing.on_ground import OnGround
from mpm_warp.scenes.bearing.slip_lines import SlipLines
from mpm_warp.scenes.catalogue import Verification


@dataclass(frozen=True, kw_only=True)
class Footing(OnGround):
    """A rigid footing; in plane strain the radius is half the width."""

    planar: ClassVar[bool]
    """Whether strain is plane; otherwise the footing is circular."""
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
    def slip_lines(self) -> SlipLines | None:
        """Those of a smooth footing; below a rough one soil is stuck."""
        if self.adhesion_factor > 0.0:
            return None
        return SlipLines(
            half_angle=0.5 * math.pi,
            strength_gradient_ratio=self.strength_gradient_ratio,
            planar=self.planar,
        )

    def grid(self) -> Grid:
        """Cells of one size below the footing, growing beside it and with depth."""
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
            fitted_radius=outer_radius,
            planar=self.planar,
        )

    def contact(self, grid: Grid) -> SurfaceContact:
        """Contact of the nodes on the surface from the axis to the rim, both included."""
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

    def load(self, scene: Scene, nodal: Floats) -> float:
        """The sum of the normal forces, over area and su0."""
        area = RADIUS if scene.grid.planar else 0.5 * RADIUS**2
        return float(nodal[:, 0].sum()) / (area * STRENGTH)


@dataclass(frozen=True, kw_only=True)
class CircularFooting(Footing):
    """A rigid disc on weightless Tresca soil."""

    summary: ClassVar[str] = "limit load of a circular footing, smooth and rough"
    version: ClassVar[int] = 3
    uniform_exact_source: ClassVar[str] = (
        "smooth: Shield 1955, Proc. R. Soc. A 233:267-287; rough: Eason & Shield 1960, "
        "Z. angew. Math. Phys. 11:33-43"
    )
    planar: ClassVar[bool] = False

    @property
    def uniform_exact_load(self) -> float:
        """Exact limit load over area and su, of a smooth or a rough disc."""
        return 5.69 if self.adhesion_factor == 0.0 else 6.05


@dataclass(frozen=True, kw_only=True)
class StripFooting(Footing):
    """A rigid strip on weightless Tresca soil, half of it: r is the distance from its middle."""

    summary: ClassVar[str] = "limit load of a strip footing in plane strain, smooth and rough"
    version: ClassVar[int] = 3
    uniform_exact_source: ClassVar[str] = (
        "2 + pi, smooth or rough: Prandtl 1921, Z. angew. Math. Mech. 1:15-20"
    )
    planar: ClassVar[bool] = True

    @property
    def uniform_exact_load(self) -> float:
        """Exact limit load over area and su, whatever the adhesion."""
        return 2.0 + math.pi
