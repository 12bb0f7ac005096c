"""Rigid footings and cones at the surface of soil whose strength may grow with depth."""

import math
from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from mpm_warp.fields.checked import Group
from mpm_warp.fields.declaration import group, parameter, redefined
from mpm_warp.grid.fitted import Floats, Grid, graded, nodal_areas
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.materials.variation import Variation
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.scene import Scene
from mpm_warp.scenes.bearing.bearing import NO_PARTING, RADIUS, STRENGTH, Bearing, Exact
from mpm_warp.scenes.bearing.slip_lines import SlipLines
from mpm_warp.scenes.cone.groups import Cone
from mpm_warp.scenes.cone.penetrometer import Penetrometer, PenetrometerContact
from mpm_warp.scenes.verification import compared

LARGEST_DEPTH = 100.0 * RADIUS
"""Depth down to which the strength is given, below that of any grid [m]."""
SLIP_LINE_SOURCE = (
    "slip lines with the hypothesis of Haar and von Karman, integrated for this project to 0.2 %"
)


@dataclass(frozen=True, kw_only=True)
class GrowingStrength(Group):
    """Ground of strength su0 + k z, with the depth z; its shear modulus is the same everywhere.

    No limit load depends on the modulus. Adhesion is in proportion to the strength beside it.
    """

    strength_gradient_ratio: float = parameter(
        0.0,
        "growth of strength with depth, k R / su0, where su0 is the strength at the surface",
        minimum=0,
        maximum=10,
    )

    def soil(self, uniform: UndrainedClay, *, surface_height: float) -> UndrainedClay:
        """Soil whose strength grows from a height z of the grid [m] on, the surface, downward."""
        if self.strength_gradient_ratio == 0.0:
            return uniform
        deepest = 1.0 + self.strength_gradient_ratio * LARGEST_DEPTH / RADIUS
        growth = Variation(
            depth=np.array([0.0, LARGEST_DEPTH]),
            strength_ratio=np.array([1.0, deepest]),
            stiffness_ratio=np.ones(2),
            origin_depth=surface_height,
        )
        return replace(uniform, variation=growth)

    @property
    def strength_ratio(self) -> float:
        """Strength half a radius deep over that at the surface."""
        return 1.0 + 0.5 * self.strength_gradient_ratio


def exact_load(lines: SlipLines | None) -> Exact | None:
    """The load over area and su0 by slip lines, and its source; None without them."""
    return None if lines is None else (lines.limit_load, SLIP_LINE_SOURCE)


@dataclass(frozen=True, kw_only=True, init=False)
class Footing(Bearing):
    """A rigid footing; in plane strain the radius is half the width."""

    source: ClassVar[str]
    """Source of `smooth_and_rough`."""
    verifications = compared(
        "cells_per_radius",
        (8, 16, 32),
        {"adhesion_factor": 0.0},
        {"adhesion_factor": 1.0},
        error=0.02,
        least_order=0.9,
    )

    ground: GrowingStrength = group()
    adhesion_factor: float = parameter(0.0, "adhesion factor of the footing", choices=(0.0, 1.0))

    @property
    @abstractmethod
    def smooth_and_rough(self) -> tuple[float, float]:
        """Exact loads of a smooth and of a rough footing on uniform soil."""

    @property
    def exact(self) -> Exact | None:
        """See `Bearing`; over su0."""
        if self.ground.strength_gradient_ratio > 0.0:
            return exact_load(self.slip_lines)
        return self.smooth_and_rough[int(self.adhesion_factor)], self.source

    @property
    def slip_lines(self) -> SlipLines | None:
        """Those of a smooth footing; soil sticks to a rough one."""
        if self.adhesion_factor > 0.0:
            return None
        return SlipLines(
            half_angle=0.5 * math.pi,
            strength_gradient_ratio=self.ground.strength_gradient_ratio,
            planar=self.planar,
        )

    @property
    def soil(self) -> UndrainedClay:
        """See `Bearing`."""
        return self.ground.soil(super().soil, surface_height=0.0)

    @property
    def final_displacement(self) -> float:
        """See `Bearing`; in proportion to the strength."""
        return self.ground.strength_ratio * super().final_displacement

    def grid(self) -> Grid:
        """Columns of one width below the footing; cells grow beside it and with depth."""
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
        """Contact of the surface nodes from the axis to the rim, inclusive."""
        column = np.arange(self.cells_per_radius + 1)
        radius = RADIUS * column / self.cells_per_radius
        areas = nodal_areas(grid.weight(radius), np.diff(radius))
        return SurfaceContact(
            nodes=grid.node(column, np.full_like(column, grid.row_count)),
            normals=np.tile([0.0, 1.0], (len(column), 1)),
            normal_areas=areas,
            adhesion_forces=self.adhesion_factor * STRENGTH * areas,
            in_situ_stress=NO_PARTING,
            speed=self.speed,
        )


@dataclass(frozen=True, kw_only=True, init=False)
class CircularFooting(Footing):
    """A rigid disc on weightless Tresca soil.

    Example:
        >>> round(CircularFooting().exact[0], 2)
        5.69
    """

    summary = "limit load of a circular footing, smooth and rough"
    version = 3
    smooth_and_rough = 5.69, 6.05
    source = (
        "smooth: Shield 1955, Proc. R. Soc. A 233:267-287; rough: Eason & Shield 1960, "
        "Z. angew. Math. Phys. 11:33-43"
    )


@dataclass(frozen=True, kw_only=True, init=False)
class StripFooting(Footing):
    """Half of a rigid strip on weightless Tresca soil; r is the distance from its middle.

    Example:
        >>> round(StripFooting().exact[0], 3)
        5.142
    """

    summary = "limit load of a strip footing in plane strain, smooth and rough"
    version = 3
    planar = True
    smooth_and_rough = 2.0 + math.pi, 2.0 + math.pi
    source = "2 + pi, smooth or rough: Prandtl 1921, Z. angew. Math. Mech. 1:15-20"


RIM_CELL, RIM_GROWTH = 0.25, 3.0
"""Width of the cells at the rim of a cone over that one radius away; increase of the width with the
distance from the rim, which joins the two."""
PSI_ROUNDING = 1e-12
"""Rounding of the angle psi at the face [rad]."""


@dataclass(frozen=True, kw_only=True, init=False)
class ConeBearing(Bearing):
    """A cone that starts with its shoulder at the surface.

    With the half angle a, the face is R / sin(a) long and moves into the soil by sin(a) times the
    displacement. At the same ratio of these lengths, cones of all angles are equally near to their
    limit loads.

    Example:
        >>> round(ConeBearing(adhesion_factor=1.0).exact[0], 2)
        6.69
    """

    summary = "limit load of a cone with its shoulder at the surface"
    version = 4
    verifications = compared(
        "cells_per_radius",
        (2, 4, 8),
        *({"adhesion_factor": adhesion_factor} for adhesion_factor in (0.0, 0.25, 0.5, 0.75, 1.0)),
        *({"apex_angle": apex_angle} for apex_angle in (30.0, 90.0, 120.0)),
        error=0.02,
        least_order=1.0,
    )

    ground: GrowingStrength = group()
    adhesion_factor: float = redefined(
        Cone, "adhesion_factor", meaning="adhesion factor of the cone"
    )
    apex_angle: float = redefined(Cone, "apex_angle")
    cells_per_radius: int = redefined(
        Bearing,
        "cells_per_radius",
        meaning="cells per radius of the cone, one radius from its rim; at the rim 4 times as many",
    )
    displacement: float = redefined(
        Bearing,
        "displacement",
        meaning="displacement over radius times G/su, of a cone of 60 degrees; that of others "
        "is in proportion to 1 / sin^2 of half the apex angle",
    )

    @property
    def slip_lines(self) -> SlipLines | None:
        """Those of the cone; None where it is so blunt and rough that soil sticks to it."""
        lines = SlipLines(
            half_angle=math.radians(0.5 * self.apex_angle),
            adhesion_factor=self.adhesion_factor,
            strength_gradient_ratio=self.ground.strength_gradient_ratio,
        )
        return lines if lines.face_psi >= -PSI_ROUNDING else None

    @property
    def exact(self) -> Exact | None:
        """See `Bearing`; over su0."""
        return exact_load(self.slip_lines)

    @property
    def soil(self) -> UndrainedClay:
        """See `Bearing`."""
        return self.ground.soil(super().soil, surface_height=self.surface_height)

    @property
    def cell_size(self) -> float:
        """See `Bearing`: cells at the rim."""
        return RIM_CELL * super().cell_size

    @property
    def final_displacement(self) -> float:
        """See `Bearing`."""
        ratio = math.sin(math.radians(30.0)) / math.sin(0.5 * self._penetrometer.apex_angle)
        return ratio**2 * (self.ground.strength_ratio * super().final_displacement)

    @property
    def surface_height(self) -> float:
        """Height of the shoulder above the tip, which is at z = 0 [m]."""
        return self._penetrometer.cone_height

    def grid(self) -> Grid:
        """A grid that is fitted to the cone, ends at its shoulder and is finest at the rim.

        Rows beside a blunt face are low, so that nodes along it are as close as columns.
        """
        size, height = RADIUS / self.cells_per_radius, self.surface_height
        edge = self.cell_size
        growth = 1.0 + RIM_GROWTH * edge / RADIUS
        face = graded(edge * min(1.0, height / RADIUS), height, growth)
        below = graded(min(size, face[-1] - face[-2]), 2.0 * RADIUS, growth)
        rows = np.append(height - face, -below[1:])[::-1]
        columns = graded(edge, 4.0 * RADIUS, growth)
        return Grid(
            columns=columns / columns[-1],
            rows=rows,
            surface_radius=self._penetrometer.surface_radius(rows),
            fitted_radius=RADIUS + float(columns[-1]),
        )

    def contact(self, grid: Grid) -> PenetrometerContact:
        """Contact on the face of the cone."""
        return PenetrometerContact.of(
            self._penetrometer,
            grid,
            face_adhesion=self.adhesion_factor * STRENGTH,
            in_situ_stress=NO_PARTING,
            speed=self.speed,
        )

    def load(self, scene: Scene, nodal: Floats) -> float:
        """Upward force on the face over base area and su0."""
        on_face = scene[PenetrometerContact].forces(nodal).on_face
        return on_face / (0.5 * RADIUS**2 * STRENGTH)

    @property
    def _penetrometer(self) -> Penetrometer:
        return Penetrometer(radius=RADIUS, apex_angle=math.radians(self.apex_angle))
