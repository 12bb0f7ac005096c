"""The layer of soil beside the shaft, where u2 is measured, on cells as fine as 40 to 112 rows.

Soil that has gone round the shoulder has another radial deviator than the soil beside it, in a
layer thinner than the cells of a usual run. Here all rows have the given fineness, but only the
columns at the shaft: each is 1.15 times as wide as the previous one. A penetration of 11 radii
suffices: farther on the layer is the same. It is not in a smaller window.

``shaft_layer IR ADHESION ROWS...`` prints for each number of rows beside the face
the mean deviator over su at the height of the filter, within 0.06 radii of the shaft and cell by
cell. 28 rows take a minute at Ir 100, 80 rows twelve, 112 twenty-five.
"""

import math
import sys
from dataclasses import dataclass

import numpy as np

from mpm_warp import ConePenetration, Grid, Simulation
from mpm_warp.grid.fitted import Floats, growing
from mpm_warp.scenes.cone.pore_pressure import FILTER_HEIGHT, SHOULDER_FILTER

GROWTH = 1.15
NEAR, SHOWN = 0.06, 9
"""Distance from the shaft over which u2 is the mean, over the radius; number of cells printed."""
BETWEEN, SAMPLES = 0.5, 9
"""Penetration between two samples, over the radius, and number of samples at the end."""


@dataclass(frozen=True, kw_only=True, init=False)
class FineAtTheShaft(ConePenetration):
    """A cone test whose columns grow by a fixed ratio."""

    @property
    def _grid(self) -> Grid:
        penetrometer, radius = self.cone.penetrometer, self.cone.cone_radius
        return penetrometer.fitted_grid(
            cell_size=self.cell_size,
            columns=growing(self.cell_size, (self.domain.domain_radius - 1.0) * radius, GROWTH),
            depth_below=self.domain_below * radius,
            height_above=self.domain_above * radius,
        )


def deviators(rigidity_index: float, adhesion_factor: float, rows: int) -> tuple[Floats, Floats]:
    """Edges of the columns over the radius, from the shaft, and their deviators over su, [n]."""
    wave = 1.0 / math.sqrt(rigidity_index)
    test = FineAtTheShaft(
        rigidity_index=rigidity_index,
        adhesion_factor=adhesion_factor,
        cells_per_radius=rows / math.sqrt(3.0),
        poissons_ratio=0.45,
        speed_ratio=0.6 * wave,
        approach_speed_ratio=0.7 * wave,
        approach=5.0,
        penetration=11.0,
        steady_tolerance=0.0,
    )
    scene, radius = test.build(), test.cone_radius
    grid, simulation = scene.grid, Simulation(scene)
    heights = 0.5 * (grid.rows[1:] + grid.rows[:-1]) - test.cone.penetrometer.cone_height
    beside_filter = np.abs(heights / radius - SHOULDER_FILTER) < 0.5 * FILTER_HEIGHT
    means = []
    for sample in range(SAMPLES):
        simulation.travel_to((test.penetration - (SAMPLES - 1 - sample) * BETWEEN) * radius)
        stress = simulation.array("cell.stress").reshape(grid.row_count, grid.column_count, 4)
        means.append(stress[beside_filter].mean(axis=0))
    stress = np.mean(means, axis=0) / test.undrained_shear_strength
    edges = grid.columns * (grid.outer_radius - radius) / radius
    return edges, stress[:, 0] - stress[:, [0, 1, 3]].mean(axis=1)


if __name__ == "__main__":
    index, adhesion, *meshes = sys.argv[1:]
    for mesh in map(int, meshes):
        edges, deviator = deviators(float(index), float(adhesion), mesh)
        share = np.diff(np.minimum(edges, NEAR)) / NEAR
        middles = 0.5 * (edges[1:] + edges[:-1])
        by_cell = zip(middles[:SHOWN], deviator[:SHOWN], strict=True)
        shown = "  ".join(f"{at:.3f}: {value:+.2f}" for at, value in by_cell)
        print(f"{mesh} rows: {share @ deviator:.2f} within {NEAR:g} radii; {shown}", flush=True)
