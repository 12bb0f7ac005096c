"""What material points carry, averaged to the nodes of their grid, as a section is drawn.

    f_i = sum over points N_i f / sum over points N_i        N_i the shape function of node i

A section of nodal values covers all soil, up to the surface and to the axis, where points leave
gaps; it shows nothing smaller than a cell, as the simulation does.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Floats = NDArray[np.floating]


class NodalValues:
    """Averages over the points of one snapshot.

    Args:
        snapshot: one of the snapshots of a case: without the dim `penetration`.

    Attributes:
        r, z: positions of the nodes [m], shape [row, column].
    """

    def __init__(self, snapshot: xr.Dataset) -> None:
        self.r = snapshot["node_r"].values.astype(float)
        self.z = snapshot["node_z"].values.astype(float)
        r, z = (snapshot[name].values.astype(float) for name in ("point_r", "point_z"))
        self._present = np.isfinite(r)
        self._nodes, self._weights = self._shape_functions(r[self._present], z[self._present])
        self._sum = self._added(np.ones(int(self._present.sum())))

    def of(self, values: Floats) -> Floats:
        """Values of the points at the nodes, [row, column]; not a number where no point is near.

        Args:
            values: in each slot, shape [point].
        """
        with np.errstate(invalid="ignore"):
            averages: Floats = self._added(values[self._present]) / self._sum
        return averages

    def _added(self, values: Floats) -> Floats:
        weighted = (self._weights * values).ravel()
        sums = np.bincount(self._nodes.ravel(), weighted, self.r.size)
        return sums.reshape(self.r.shape).astype(np.float64, copy=False)

    def _shape_functions(self, r: Floats, z: Floats) -> tuple[NDArray[np.integer], Floats]:
        """The four nodes around each point, and their shape functions there: [4, point_count]."""
        rows, surface, outer = self.z[:, 0], self.r[:, 0], self.r[0, -1]
        columns = (self.r[0] - surface[0]) / (outer - surface[0])
        row, eta = _interval(rows, z)
        inner = surface[row] + eta * (surface[row + 1] - surface[row])
        column, xi = _interval(columns, (r - inner) / (outer - inner))
        first = row * self.r.shape[1] + column
        upper = first + self.r.shape[1]
        nodes = np.stack([first, first + 1, upper, upper + 1])
        weights = [(1 - xi) * (1 - eta), xi * (1 - eta), (1 - xi) * eta, xi * eta]
        return nodes, np.stack(weights)


def _interval(edges: Floats, values: Floats) -> tuple[NDArray[np.integer], Floats]:
    """In which interval between rising edges each value is, and how far in it, 0 to 1."""
    interval = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    within: Floats = (values - edges[interval]) / np.diff(edges)[interval]
    return interval, np.clip(within, 0.0, 1.0)
