"""A ball or a T-bar that goes down: its outline, the grid fitted to it, its contact."""

from dataclasses import dataclass

import numpy as np

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.parts.contact import SurfaceContact, nodal_areas

FITTED = 3.0
"""Radius up to which the columns of nodes follow the surface, about, over that of the body: the
mechanism reaches to about three."""
POLE_ROW = 0.5
"""Height of the rows beside the poles, over those away from the body: in a row as high as those, a
pole would have one long chord, and an error that falls as the height only."""


@dataclass(frozen=True, kw_only=True)
class RoundBody:
    """A ball below a thin smooth shaft, or a cylinder in plane strain, its centre at z = 0."""

    radius: float  # R [m], > 0
    shaft_radius: float = 0.0  # radius of the shaft above [m], 0 <= radius < R; 0: there is none
    planar: bool = False  # whether it is a cylinder in plane strain; otherwise it is a ball

    def surface_radius(self, height: Floats) -> Floats:
        """Distance of the surface from the line of travel at heights [m]; 0 where soil is on it."""
        body = np.sqrt(np.clip(self.radius**2 - height**2, 0.0, None))
        return np.maximum(body, np.where(height > 0.0, self.shaft_radius, 0.0))

    def fitted_grid(self, *, cells_per_radius: int, columns: Floats, extent: int) -> Grid:
        """A grid whose rows meet both poles and whose first column follows the surface.

        Columns far from the body are upright, so that the cells near it are the same however large
        the grid is. They are at distances from the widest place, from 0, rising [m]. The extent is
        that below and above the centre, over the radius, >= 2.
        """
        size = self.radius / cells_per_radius
        beside = np.linspace(0.0, self.radius - POLE_ROW * size, cells_per_radius + 1)
        beyond = self.radius + size * np.arange((extent - 1) * cells_per_radius + 1)
        above = np.append(beside, beyond)
        rows = np.append(-above[:0:-1], above)
        last_fitted = int(np.argmin(np.abs(columns - (FITTED - 1.0) * self.radius)))
        fitted, upright = np.split(columns, [last_fitted + 1])
        fitted_radius = self.radius + float(fitted[-1])
        return Grid(
            columns=np.append(fitted / fitted[-1], (self.radius + upright) / fitted_radius),
            rows=rows,
            surface_radius=self.surface_radius(rows),
            fitted_radius=fitted_radius,
            planar=self.planar,
        )

    def contact(self, grid: Grid, *, adhesion: float, in_situ_stress: float) -> SurfaceContact:
        """Contact on all nodes of the surface, from the lower pole upward; the shaft is smooth.

        Normals are those of the consistent area vectors, so that on the whole no soil flows
        through. The line of travel and the surface together hold the soil at a pole, which the flow
        leaves with few material points: its node is one of those on the axis. The grid is fitted to
        the body; adhesion, of ball or bar, and in-situ stress are in Pa, >= 0.
        """
        beside = np.flatnonzero(grid.surface_radius > 0.0)
        upper_end = min(beside[-1] + 1, grid.row_count)
        rows = np.arange(beside[0] - 1, upper_end + 1, dtype=np.int32)
        nodes = grid.node(0, rows)
        radius, height = grid.surface_radius[rows], grid.rows[rows]
        weight = grid.weight(radius)
        rise, lean = np.diff(height), np.diff(radius)
        vectors = np.stack([-nodal_areas(weight, rise), nodal_areas(weight, lean)], axis=-1)
        on_axis = np.flatnonzero(radius == 0.0)
        vectors[on_axis, 0] = 0.0
        normal_areas = np.linalg.norm(vectors, axis=1)
        of_body = np.where(lean != 0.0, np.hypot(lean, rise), 0.0)
        return SurfaceContact(
            nodes=nodes,
            normals=vectors / normal_areas[:, None],
            normal_areas=normal_areas,
            adhesion_forces=adhesion * nodal_areas(weight, of_body),
            friction=0.0,
            in_situ_stress=in_situ_stress,
            on_axis=on_axis,
        )


def upward_force(contact: SurfaceContact, nodal: Floats) -> float:
    """The force of the soil on a body along the line of travel, upward positive [N].

    It is that on half a cylinder of unit length, or on a radian of a ball, of normal and tangential
    forces from the soil at the nodes [N], shape [node_count, 2].
    """
    normals = contact.normals
    return float(np.sum(nodal[:, 0] * normals[:, 1] - nodal[:, 1] * normals[:, 0]))
