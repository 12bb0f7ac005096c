"""The penetrometer on a plain grid, its surface a row of points: to hold the fitted grid against.

Grid and penetrometer move together here too, so that cut cells, contact nodes, their normals and
areas are found once. What differs is where the nodes are: beside the surface, not on it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats, Grid, Integers, bilinear, graded
from mpm_warp.penetrometer import Penetrometer, PenetrometerSurface

POINTS_PER_CELL = 32
"""Quadrature points along each side of a cut cell, and of surface along a cell."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ImmersedGrid(Grid):
    """A rectilinear grid, part of whose cells a penetrometer cuts or fills.

    Integrals over a cell are those over its open part. A cell without one keeps its volume, so
    that it has a strain rate, of zero.

    Attributes:
        penetrometer: what is in the soil's place.
    """

    penetrometer: Penetrometer

    @classmethod
    def around(
        cls,
        penetrometer: Penetrometer,
        *,
        cell_size: float,
        cell_growth: float,
        outer_radius: float,
        depth_below: float,
        height_above: float,
    ) -> ImmersedGrid:
        """A grid of square cells at the penetrometer, whose tip and shaft stand amid cells.

        Args:
            penetrometer: see the class.
            cell_size: side of the cells at the penetrometer [m], about.
            cell_growth: growth of the cells' width per distance from the shaft, dimensionless.
            outer_radius: where the grid ends [m].
            depth_below: extent of the grid below the tip [m].
            height_above: extent of the grid above the shoulder [m], >= 0.
        """
        radius = penetrometer.radius
        inner_count = max(1, round(radius / cell_size))
        size = radius / (inner_count + 0.5)
        inner = size * np.arange(inner_count + 2)
        growth = 1.0 + cell_growth * size / radius
        outer = inner[-1] + graded(size, outer_radius - inner[-1], growth)
        below = round(depth_below / size)
        above = round((penetrometer.cone_height + height_above) / size)
        return cls(
            columns=np.concatenate([inner[:-1], outer]) / outer_radius,
            rows=size * (np.arange(-below, above + 1) - 0.5),
            surface_radius=np.zeros(below + above + 1),
            outer_radius=outer_radius,
            penetrometer=penetrometer,
        )

    def holds_soil(self, position: Floats) -> NDArray[np.bool_]:
        """See `Grid`."""
        outside: NDArray[np.bool_] = position[:, 0] > self.penetrometer.surface_radius(
            position[:, 1]
        )
        return outside

    @cached_property
    def gradient_integrals(self) -> Floats:
        """See `Grid`."""
        integrals = super().gradient_integrals.copy()
        integrals[self._cut] = self._open_parts[0]
        return integrals

    @cached_property
    def cell_volumes(self) -> Floats:
        """See `Grid`."""
        volumes = super().cell_volumes.copy()
        volumes[self._cut] = self._open_parts[1]
        return volumes

    @cached_property
    def cell_lengths(self) -> Floats:
        """See `Grid`; a cell without soil carries no wave."""
        lengths = super().cell_lengths
        lengths[np.isinf(lengths)] = lengths[np.isfinite(lengths)].max()
        return lengths

    @cached_property
    def _cut(self) -> Integers:
        """The cells that are not all soil: those whose upper left corner is in the penetrometer."""
        corner = self.node_positions[self.cell_nodes[:, 2]]
        return np.flatnonzero(corner[:, 0] < self.penetrometer.surface_radius(corner[:, 1]))

    @cached_property
    def _open_parts(self) -> tuple[Floats, Floats]:
        """Gradient integrals of the cut cells' open parts, and volumes: of all where none is."""
        middles = (np.arange(POINTS_PER_CELL) + 0.5) / POINTS_PER_CELL
        xi, eta = (g.ravel() for g in np.meshgrid(middles, middles))
        shape, d_xi, d_eta = bilinear(xi, eta)  # each [4 nodes, points]
        row, column = np.divmod(self._cut, self.column_count)
        place = self.place(column[:, None], row[:, None], xi, eta)
        is_open = self.holds_soil(place.reshape(-1, 2)).reshape(place.shape[:2])[:, None, :]
        width = self.outer_radius * np.diff(self.columns)[column][:, None, None]
        height = np.diff(self.rows)[row][:, None, None]
        r = place[:, None, :, 0]
        whole = np.broadcast_to(width * height / len(xi), r.shape)
        weight = is_open * whole
        parts = (d_xi / width * r, d_eta / height * r, shape)
        integrals = np.stack([np.sum(part * weight, axis=-1) for part in parts], axis=-1)
        counted = np.where(is_open.any(axis=-1, keepdims=True), weight, whole)
        return integrals, np.sum(r * counted, axis=(1, 2))


@dataclass(frozen=True, kw_only=True, eq=False)
class SampledSurface(PenetrometerSurface):
    """The surface as points, each of which acts on the nodes of its cell.

    The integral of N n over the surface gives a node its normal and its area, as in a fitted grid;
    but the nodes are those on either side of it, up to a cell away.
    """

    @property
    def nodes(self) -> Integers:
        """See `PenetrometerSurface`."""
        return self._samples[0]

    @cached_property
    def areas(self) -> tuple[Floats, Floats]:
        """See `PenetrometerSurface`."""
        return self._samples[1:]

    @cached_property
    def _samples(self) -> tuple[Integers, Floats, Floats]:
        tip, top = 0.0, float(self.grid.rows[-1])
        shoulder = self.penetrometer.cone_height
        face = self._sum((0.0, tip), (self.penetrometer.radius, shoulder))
        shaft = self._sum((self.penetrometer.radius, shoulder), (self.penetrometer.radius, top))
        nodes = np.flatnonzero(face + shaft > 0.0).astype(np.int32)
        return nodes, face[nodes], shaft[nodes]

    def _sum(self, first: tuple[float, float], last: tuple[float, float]) -> Floats:
        """Integrals of N r along a straight line for all nodes of the grid [m2]."""
        grid, length = self.grid, float(np.hypot(last[0] - first[0], last[1] - first[1]))
        count = max(1, round(POINTS_PER_CELL * length / float(np.diff(grid.rows).min())))
        along = (np.arange(count) + 0.5) / count
        radius = first[0] + along * (last[0] - first[0])
        height = first[1] + along * (last[1] - first[1])
        edges = grid.outer_radius * grid.columns
        column = np.searchsorted(edges, radius) - 1
        row = np.searchsorted(grid.rows, height) - 1
        xi = (radius - edges[column]) / np.diff(edges)[column]
        eta = (height - grid.rows[row]) / np.diff(grid.rows)[row]
        shape, _, _ = bilinear(xi, eta)
        nodes = grid.cell_nodes[row * grid.column_count + column]
        inside = shape.T * (1.0 - grid.holds_soil(grid.node_positions)[nodes])
        share = inside / inside.sum(axis=1, keepdims=True)
        areas = np.zeros(grid.node_count)
        np.add.at(areas, nodes, share * (radius * length / count)[:, None])
        return areas
