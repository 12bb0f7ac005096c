"""The penetrometer: a cone below a shaft, the grid fitted to it, its contact, the forces on it.

The standard penetrometer has a diameter of 35.7 mm and a base of 10 cm2. The cylindrical part of
the cone is 10 mm high; the friction sleeve of 150 cm2 begins above it. Heights are over the radius,
so they scale with the penetrometer.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from mpm_warp.grid.fitted import Floats, Grid, nodal_areas
from mpm_warp.parts.contact import SurfaceContact

_RADIUS = 17.85
"""Radius of the standard penetrometer [mm]."""
SLEEVE_BEGIN = 10.0 / _RADIUS
"""Height of the lower end of the sleeve above the shoulder, over the radius."""
SLEEVE_LENGTH = 133.7 / _RADIUS
"""Length of the sleeve over the radius."""


@dataclass(frozen=True, kw_only=True)
class Penetrometer:
    """A cone with its tip at z = 0, and above its shoulder a shaft of the same radius."""

    radius: float  # radius of the shaft [m], > 0
    apex_angle: float  # full angle of the cone [rad], 0 < angle < pi

    @property
    def cone_height(self) -> float:
        """Height of the shoulder above the tip [m]."""
        return self.radius / float(np.tan(0.5 * self.apex_angle))

    def surface_radius(self, height: Floats) -> Floats:
        """Radius of the surface at heights above the tip [m]; 0 below it."""
        fraction: Floats = np.clip(height / self.cone_height, 0.0, 1.0)
        return fraction * self.radius

    def rows_on_face(self, cell_size: float) -> int:
        """Number of rows beside the face whose height is nearest to `cell_size` [m]."""
        return max(1, round(self.cone_height / cell_size))

    def fitted_grid(
        self, *, cell_size: float, columns: Floats, depth_below: float, height_above: float
    ) -> Grid:
        """A grid whose rows meet tip and shoulder and whose first column follows the surface.

        Args:
            cell_size: height of all rows [m], rounded so that a whole number fits the face.
            columns: distances of the columns of nodes from the shaft, increasing from 0 [m].
            depth_below: extent of the grid below the tip, to the nearest row [m].
            height_above: extent of the grid above the shoulder, to the nearest row [m], >= 0.
        """
        rows_on_face = self.rows_on_face(cell_size)
        cell_height = self.cone_height / rows_on_face
        rows_below = max(1, round(depth_below / cell_height))
        rows_above = round(height_above / cell_height)
        row = np.arange(-rows_below, rows_on_face + rows_above + 1)
        rows = cell_height * row.astype(np.float64)
        surface = self.surface_radius(rows)
        # Tip and shoulder are nodes exactly, in spite of the rounding of rows.
        surface[row <= 0] = 0.0
        surface[row >= rows_on_face] = self.radius
        return Grid(
            columns=columns / columns[-1],
            rows=rows,
            surface_radius=surface,
            fitted_radius=self.radius + float(columns[-1]),
        )


def sleeve_mean(heights: Floats, values: Floats) -> float:
    """Mean over the sleeve of values at increasing heights above the shoulder, over the radius.

    Values are linear between heights. The mean is NaN where the sleeve ends above the highest.
    """
    begin, end = SLEEVE_BEGIN, SLEEVE_BEGIN + SLEEVE_LENGTH
    if heights[-1] < end:
        return math.nan
    at = np.concatenate([[begin], heights[(heights > begin) & (heights < end)], [end]])
    return float(np.trapezoid(np.interp(at, heights, values), at)) / SLEEVE_LENGTH


class PenetrometerForces(NamedTuple):
    """Forces on the penetrometer per radian, upward positive [N]."""

    face_normal: float  # from the normal traction on the cone's face
    face_shear: float  # from the shear traction on it
    shaft_shear: float  # from the shear traction on the shaft
    contact_share: float  # share of face and shaft that the soil touches, dimensionless

    @property
    def on_face(self) -> float:
        """The force on the cone's face [N]."""
        return self.face_normal + self.face_shear

    @property
    def upward(self) -> float:
        """The whole force [N]."""
        return self.on_face + self.shaft_shear


@dataclass(frozen=True, kw_only=True, eq=False)
class PenetrometerContact(SurfaceContact):
    """Contact of the soil with a penetrometer to which a grid is fitted, and the forces on it.

    The normal of a node is that of its consistent area vector, the integral of N n over the
    surface. With it the net flow of soil through the surface is 0 (Engelman, Sani & Gresho 1982,
    Int. J. Numer. Meth. Fluids 2:225-238). The normal at the shoulder matters: at 3 cells per
    radius a smooth cone has Nc 10.61 with this one, 10.84 with that of the face, 9.99 with that of
    the shaft.
    """

    face_areas: Floats  # integrals of N r along the face for each node [m2], shape [node_count]
    shaft_areas: Floats  # the same along the shaft [m2], shape [node_count]
    face_adhesion: float  # adhesion of the cone's face [Pa], >= 0
    shaft_adhesion: float  # adhesion of the shaft [Pa], >= 0
    strength: float  # shear strength of the soil, which bounds friction [Pa], > 0
    half_angle: float  # half the angle of the cone [rad]

    @classmethod
    def of(
        cls,
        penetrometer: Penetrometer,
        grid: Grid,
        *,
        face_adhesion: float,
        shaft_adhesion: float = 0.0,
        friction: float = 0.0,
        strength: float = math.inf,
        in_situ_stress: float,
        speed: float = 0.0,
    ) -> Self:
        """Contact on all nodes of the surface that the grid is fitted to, from the tip upward."""
        tip = int(np.flatnonzero(grid.surface_radius == 0.0)[-1])
        rows = np.arange(tip, grid.row_count + 1, dtype=np.int32)
        nodes = grid.node(0, rows)
        radius, height = grid.surface_radius[rows], grid.rows[rows]
        length = np.hypot(np.diff(radius), np.diff(height))
        on_face = np.diff(radius) > 0.0
        face = nodal_areas(radius, np.where(on_face, length, 0.0))
        shaft = nodal_areas(radius, np.where(on_face, 0.0, length))
        half = 0.5 * penetrometer.apex_angle
        vectors = np.outer(face, [-np.cos(half), np.sin(half)]) + np.outer(shaft, [-1.0, 0.0])
        # Soil on the axis moves along it alone, so the normal of the tip is vertical.
        vectors[grid.node_positions[nodes, 0] == 0.0, 0] = 0.0
        normal_areas = np.linalg.norm(vectors, axis=1)
        return cls(
            nodes=nodes,
            normals=vectors / normal_areas[:, None],
            normal_areas=normal_areas,
            adhesion_forces=face_adhesion * face + shaft_adhesion * shaft,
            friction=friction,
            strength_forces=None if math.isinf(strength) else strength * (face + shaft),
            in_situ_stress=in_situ_stress,
            speed=speed,
            face_areas=face,
            shaft_areas=shaft,
            face_adhesion=face_adhesion,
            shaft_adhesion=shaft_adhesion,
            strength=strength,
            half_angle=half,
        )

    def forces(self, nodal: Floats) -> PenetrometerForces:
        """Forces on face and shaft, from the normal and tangential nodal forces [N], [n, 2].

        The shoulder belongs to both. Its normal traction acts on both areas; its shear force is
        divided in proportion to their largest shear forces. Soil at the tip cannot slip along the
        face, so its shear over the largest possible one is assumed to be that of the next node.
        """
        normal, shear = nodal[:, 0], nodal[:, 1]
        limits, on_face = self._shear_limits(normal), self.shear_on_face(nodal)
        face_shear = float(on_face.sum())
        tip_shear = float(limits[0, 0] * on_face[1] / limits[0, 1]) if limits[0, 1] > 0.0 else 0.0
        upward_from_tip = tip_shear * math.cos(self.half_angle)
        # The part of a node's normal force that acts on the face pushes upward.
        on_face_part = float(normal @ (self.face_areas / self.normal_areas))
        return PenetrometerForces(
            face_normal=on_face_part * math.sin(self.half_angle) - upward_from_tip,
            face_shear=face_shear * math.cos(self.half_angle) + upward_from_tip,
            shaft_shear=float(shear.sum()) - face_shear,
            contact_share=self.share_in_touch(normal),
        )

    def shear_on_face(self, nodal: Floats) -> Floats:
        """The face's part of the shear forces at the nodes [N], shape [node_count]."""
        limits = self._shear_limits(nodal[:, 0])
        of_face, of_both = limits[0], limits.sum(axis=0)
        share = np.divide(of_face, of_both, out=np.zeros_like(of_face), where=of_face > 0.0)
        on_face: Floats = nodal[:, 1] * share
        return on_face

    def shaft_shear_stress(self, nodal: Floats) -> Floats:
        """Shear stress on the shaft at its nodes, from below, 0 on the face [Pa], [node_count]."""
        shear = nodal[:, 1]
        on_shaft = shear - self.shear_on_face(nodal)
        return np.divide(
            on_shaft, self.shaft_areas, out=np.zeros_like(shear), where=self.shaft_areas > 0.0
        )

    def _shear_limits(self, normal: Floats) -> Floats:
        """Largest shear force on face and shaft of each node, from its normal force [N], [2, n].

        Strength and adhesion are those at the start; only the ratios at shoulder and tip are used.
        """
        rubbing = self.friction * (normal / self.normal_areas + self.in_situ_stress)
        on_face = np.minimum(self.face_adhesion + rubbing, self.strength) * self.face_areas
        on_shaft = np.minimum(self.shaft_adhesion + rubbing, self.strength) * self.shaft_areas
        return np.stack([on_face, on_shaft])
