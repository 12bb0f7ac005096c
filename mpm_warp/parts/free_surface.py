"""Free surfaces: the stress of a partly filled cell acts in proportion to its filling.

The surface of the ground moves up through a window that goes down, and leaves it at the top. Cells
are partly filled only near it. In those

- the stress acts as far as the cell is filled (`mpm_warp.step.cells`),
- a material point takes a share a of its velocity from the grid as it is, in every step:
  v_p <- v_p + N (v - u) + a (N u - v_p), the PIC fraction of Zhu & Bridson (2005, ACM Trans. Graph.
  24:965-972). It takes away what the transfers add where points come into empty cells. It acts as a
  shear viscosity of the order a rho h^2 / (8 dt), h the width of a cell: less in finer cells.

Deeper cells have the mass-matrix correction of full cells instead, and act with all of their stress
where they are at least half full. If their stress were reduced as near the surface, the scatter of
points would make the soil some 4 % weaker. If it were never reduced, soil that separates at a hole
beside the shaft would be thrown about.

The soil is weightless, so it is enough to know that the surface is in the layer near it.
"""

from dataclasses import dataclass

import numpy as np

from mpm_warp.arguments import POSITIVE, Range, checked
from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.window import Window
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.scene import Part, Scene

DEEP_FILLING = 0.5
"""Filled share of a cell above which, far below the surface, all of its stress acts."""


@dataclass(frozen=True)
class FreeSurface(Part):
    """A surface of the soil that passes through cells; their stress acts as far as they are filled.

    No cell has a mass-matrix correction, which is that of full ones.
    """

    cell_bytes = 16.0

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Add "cell.full_mass", from which on a cell acts with all of its stress, and the like."""
        for name, values in self._of_cells(scene, 0.0).items():
            plan.add_array(name, "real", values)

    def _of_cells(self, scene: Scene, travel: float) -> dict[str, Floats]:
        return {"cell.full_mass": scene.material.density * scene.grid.cell_volumes}


@dataclass(frozen=True, kw_only=True)
class PassingSurface(FreeSurface):
    """A free surface that the soil carries up through the window.

    Attributes:
        level: height of the undisturbed surface in the grid at the start [m].
        layer: thickness of the layer below it that counts as near [m], > 0; all above the level
            counts as near too, as soil heaves there.
        pic_fraction: a in that layer and above it, dimensionless, > 0 and <= 1.
    """

    needs = (Window,)
    level: float = checked(unit="m")
    layer: float = checked(POSITIVE, unit="m")
    pic_fraction: float = checked(Range(above=0.0, maximum=1.0))

    def follow(self, run: Run, scene: Scene, travel: float, *, by_a_row: bool) -> None:
        """The cells near the surface are others, higher in the grid."""
        for name, values in self._of_cells(scene, travel).items():
            run.assign(name, values)

    def _of_cells(self, scene: Scene, travel: float) -> dict[str, Floats]:
        """PIC fraction, and mass [kg] per radian from which on a cell acts with all of its stress.

        Cells are near that reach up into the layer below the surface, or are above it.
        """
        grid = scene.grid
        near_rows = grid.rows[1:] > self.level + travel - self.layer
        is_near = np.repeat(near_rows, grid.column_count)
        full = scene.material.density * grid.cell_volumes
        return {
            "cell.pic_fraction": np.where(is_near, self.pic_fraction, 0.0),
            "cell.full_mass": np.where(is_near, full, DEEP_FILLING * full),
        }
