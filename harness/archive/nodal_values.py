"""Quantities of material points at the nodes of their grid, from the snapshots of a case."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from mpm_warp.grid.fitted import Floats, bilinear


class NodalValues:
    """Quantities of the material points of one snapshot, averaged to the nodes of their grid.

        f_i = sum over points N_i f / sum over points N_i        N_i the shape function of node i

    A section of nodal values covers all soil up to the surface and the axis, where points leave
    gaps. Like the simulation, it resolves nothing smaller than a cell. The positions of the nodes
    are `r` and `z` [m], shape [row, column]. The snapshot has no dim `penetration`.
    """

    def __init__(self, snapshot: xr.Dataset) -> None:
        self.r, self.z, r, z = (
            snapshot[name].values.astype(float)
            for name in ("node_r", "node_z", "point_r", "point_z")
        )
        self._present = np.isfinite(r)
        r, z = r[self._present], z[self._present]
        rows, surface, outer = self.z[:, 0], self.r[:, 0], self.r[0, -1]
        inner = np.interp(z, rows, surface)
        row, eta = _interval(rows, z)
        columns = (self.r[0] - surface[0]) / (outer - surface[0])
        column, xi = _interval(columns, (r - inner) / (outer - inner))
        first = row * self.r.shape[1] + column
        upper = first + self.r.shape[1]
        # The four nodes around each point, and their shape functions there: [4, point_count].
        self._nodes = np.stack([first, first + 1, upper, upper + 1])
        self._weights = bilinear(xi, eta)[0]

    def of(self, values: Floats) -> Floats:
        """Values of the points at the nodes, [row, column]; NaN where no point is near."""
        with np.errstate(invalid="ignore"):
            return self._sums(values[self._present]) / self._sums(1.0)

    def _sums(self, values: Floats | float) -> Floats:
        weighted = (self._weights * values).ravel()
        sums = np.bincount(self._nodes.ravel(), weighted, self.r.size).astype(float)
        return sums.reshape(self.r.shape)


def _interval(edges: Floats, values: Floats) -> tuple[NDArray[np.integer], Floats]:
    """For each value its interval between ascending edges, and its position there, 0 to 1."""
    place = np.interp(values, edges, np.arange(len(edges)))
    interval = np.minimum(place.astype(int), len(edges) - 2)
    return interval, place - interval
