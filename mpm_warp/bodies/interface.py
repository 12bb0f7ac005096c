"""A straight interface under any angle to the grid, and bodies laid along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mpm_warp.bodies.body import Body
from mpm_warp.bodies.grid import UniformGrid
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.linear_elastic import LinearElastic

MARGIN = 2
"""Empty cells around the bodies, at least."""


@dataclass(frozen=True, kw_only=True)
class InterfaceFrame:
    """Coordinates along an interface and out of it.

    Attributes:
        angle: from the first axis of the grid to the interface [rad]; only used in plane strain.
        interface_radius: radius of an interface that is a cylinder around the axis [m], > 0; it
            runs along z, and its outward side is the inner one. None in plane strain.
    """

    angle: float
    interface_radius: float | None = None

    @property
    def along(self) -> Floats:
        """Unit vector along the interface."""
        if self.interface_radius is not None:
            return np.array([0.0, 1.0])
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    @property
    def outward(self) -> Floats:
        """Unit vector normal to the interface."""
        return np.array([-self.along[1], self.along[0]])

    def height(self, position: Floats) -> Floats:
        """Distance of points from the interface, outward positive [m], shape [point_count]."""
        heights: Floats = (position - self._origin) @ self.outward
        return heights

    def body(
        self,
        extent: tuple[float, float],
        heights: tuple[float, float],
        spacing: float,
        material: LinearElastic,
    ) -> Body:
        """A rectangle full of particles.

        Args:
            extent: least and greatest coordinate along the interface [m].
            heights: least and greatest distance from the interface, outward positive [m].
            spacing: distance of the particles [m]; the rectangle gets a whole number of them.
            material: elastic constants and density.
        """
        across, up = (
            low + spacing * (np.arange(round((high - low) / spacing)) + 0.5)
            for low, high in (extent, heights)
        )
        x, y = (axis.ravel() for axis in np.meshgrid(across, up))
        position = self._origin + np.outer(x, self.along) + np.outer(y, self.outward)
        radius = position[:, 0] if self.interface_radius is not None else np.ones(len(position))
        return Body(
            position=position, volume=spacing**2 * radius, spacing=spacing, material=material
        )

    def grid_around(
        self, bodies: Sequence[Body], *, travel: float, cell_size: float, offset: float
    ) -> UniformGrid:
        """A grid that holds the bodies, also when the first has travelled along the interface.

        Args:
            bodies: one or more.
            travel: distance that the first body will travel [m].
            cell_size: side of a cell [m].
            offset: distance of the nodes from the origin of the coordinates, over cell size,
                0 to 1.
        """
        travelled = bodies[0].position + travel * self.along
        occupied = np.concatenate([travelled, *(body.position for body in bodies)]) / cell_size
        first = np.floor(occupied.min(axis=0)) - MARGIN - offset
        counts = np.ceil(occupied.max(axis=0) - first).astype(int) + MARGIN
        lower = cell_size * first
        return UniformGrid(
            lower=(float(lower[0]), float(lower[1])),
            cell_size=cell_size,
            cell_counts=(int(counts[0]), int(counts[1])),
            axisymmetric=self.interface_radius is not None,
        )

    @property
    def _origin(self) -> Floats:
        return np.array([self.interface_radius or 0.0, 0.0])
