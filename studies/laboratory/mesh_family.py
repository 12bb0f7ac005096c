"""Cone factors on a second family of meshes, with columns of nodes that are partly upright.

By default the columns follow the cone up to the edge of the grid. Here they follow it up to a
number of radii and are upright beyond, so the cells have other shapes but the same widths. A limit
of fine meshes that is the same in both families does not come from the shape of the cells.

``mesh_family IR ADHESION RADII...`` runs 4, 5, 7 and 10 rows beside the face on a
mesh that is upright beyond each of the radii. It prints the cone factors as simulated, and the
limit N0 of the law of the mesh, N = N0 + B h + Q h^1.7 + C g^1.5 h^1.3, where each family has its
own B.
"""

import math
import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mpm_warp import ConePenetration, Grid, parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.uncertainty.laws import (
    EFFECTS,
    GROWTH_OF_MESHES,
    curvature_error,
    growth_measure,
)

ROWS = (4, 5, 7, 10)


@dataclass(frozen=True, kw_only=True, init=False)
class UprightCone(ConePenetration):
    """A cone test whose columns of nodes are upright from about `upright` cone radii on."""

    upright: float = parameter(
        1000.0, "radius from which on the columns are upright, over cone radius", above=1
    )

    @property
    def _grid(self) -> Grid:
        grid = super()._grid
        radii = grid.columns * (grid.fitted_radius - self.cone.cone_radius) + self.cone.cone_radius
        last = int(np.abs(radii - self.upright * self.cone.cone_radius).argmin())
        fitted = float(radii[last])
        columns = (radii - self.cone.cone_radius) / (fitted - self.cone.cone_radius)
        columns[last:] = radii[last:] / fitted
        return replace(grid, columns=columns, fitted_radius=fitted)


def factor(rows: int, upright: float, **clay: Any) -> float:
    """The cone factor as simulated on a mesh of so many rows beside the face."""
    test = UprightCone(
        cells_per_radius=rows / math.sqrt(3.0),
        cell_growth=GROWTH_OF_MESHES,
        upright=upright,
        **clay,
    )
    return float(test.run().cone_factor_simulated)


def limit(factors: Floats, **clay: float) -> tuple[float, float, float]:
    """N0 and B by least squares, and the largest residual; factors of `ROWS`, shape [4]."""
    size = math.sqrt(3.0) / np.array(ROWS)
    known = np.array(
        [
            curvature_error(cell_size=it, **clay)
            + EFFECTS["growth"].size * growth_measure(it, GROWTH_OF_MESHES)
            for it in size
        ]
    )
    slope, at_zero = np.polyfit(size, factors - known, 1)
    residual = np.abs(factors - known - at_zero - slope * size).max()
    return float(at_zero), float(slope), float(residual)


if __name__ == "__main__":
    index, adhesion, *radii = map(float, sys.argv[1:])
    clay = {"rigidity_index": index, "adhesion_factor": adhesion}
    for upright in (1000.0, *radii):
        found = [factor(rows, upright, **clay) for rows in ROWS]
        at_zero, slope, residual = limit(np.array(found), **clay)
        shown = "  ".join(f"{it:.3f}" for it in found)
        print(f"upright beyond {upright:4g}: {shown}  N0 {at_zero:.3f}  B {slope:.2f}", end="  ")
        print(f"largest residual {residual:.3f}", flush=True)
