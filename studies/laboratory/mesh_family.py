"""Cone factors on meshes with cells of other shapes.

By default the cells at the cone are square, and the columns of nodes follow the cone up to the edge
of the grid. `WIDTH_RATIO` makes cells wider than high, and with `UPRIGHT` the columns are upright
from a number of radii on. A limit of fine meshes that all families share does not come from the
shape of the cells; `limit_of_mesh` compares it.

``mesh_family WIDTH_RATIO UPRIGHT IR ADHESION ROWS...`` prints a row of studies/mesh_error_wide.csv
for each number of rows beside the face; an `UPRIGHT` of 1000 has no upright columns. All else is as
in studies/mesh_error.toml.
"""

import math
import sys
from dataclasses import dataclass, replace

import numpy as np

from harness.study.study import load_study
from mpm_warp import ConePenetration, Grid, parameter
from mpm_warp.grid.fitted import growing


@dataclass(frozen=True, kw_only=True, init=False)
class OtherMeshCone(ConePenetration):
    """A cone test on a mesh with cells of another shape."""

    width_ratio: float = parameter(1.0, "width of the cells at the cone over their height", above=0)
    upright: float = parameter(
        1000.0, "radius from which on the columns are upright, over cone radius", above=1
    )

    @property
    def _grid(self) -> Grid:
        grid, radius = super()._grid, self.cone.cone_radius
        width = self.width_ratio * self.cell_size
        columns = growing(
            width, grid.fitted_radius - radius, 1.0 + self.cell_growth * width / radius
        )
        radii = radius + columns
        last = int(np.abs(radii - self.upright * radius).argmin())
        fitted = float(radii[last])
        shape = columns / (fitted - radius)
        shape[last:] = radii[last:] / fitted
        return replace(grid, columns=shape, fitted_radius=fitted)


def factor(rows: int, width_ratio: float, upright: float, index: float, adhesion: float) -> float:
    """The cone factor as simulated on a mesh of so many rows beside the face."""
    (case,) = load_study(
        "mesh_error",
        [
            f"rigidity_index=[{index}]",
            f"adhesion_factor=[{adhesion}]",
            f"cells_per_radius=[{rows / math.sqrt(3.0):.2f}]",
        ],
    ).cases
    shape = {"width_ratio": width_ratio, "upright": upright}
    test = OtherMeshCone.of({**case.parameters, **shape})
    return float(test.run().cone_factor_simulated)


if __name__ == "__main__":
    width_ratio, upright, index, adhesion = map(float, sys.argv[1:5])
    for rows in map(int, sys.argv[5:]):
        found = factor(rows, width_ratio, upright, index, adhesion)
        print(f"{index:g},{adhesion:g},{rows / math.sqrt(3.0):.2f},{found:.4f}", flush=True)
