"""Free surfaces: the stress of a partly filled cell acts in proportion to its filling.

The surface of the ground moves up through a window that moves down, and leaves it at the top. Cells
are partly filled only near the surface. There

- the stress acts in proportion to the filling (`mpm_warp.step.cells`), and what the least mass of a
  node keeps does not press on a body there (`mpm_warp.parts.contact`),
- a material point takes a share a of its velocity from the grid in every step, the PIC fraction of
  Zhu & Bridson (2005, ACM Trans. Graph. 24:965-972): v_p <- v_p + N (v - u) + a (N u - v_p). This
  removes the energy that the transfers add where points enter empty cells. It acts as a shear
  viscosity of the order a rho h^2 / (8 dt), where h is the width of a cell: less in finer cells.

Deeper cells have the mass-matrix correction instead, and their full stress if they are at least
half full. With the reduction that holds near the surface, the scatter of points would make the soil
some 4 % weaker. Without any, soil beside a hole at the shaft would be thrown about.

The soil is weightless, so the exact position of the surface in the layer near it does not matter.
"""

from dataclasses import dataclass

import numpy as np

from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.window import Window
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.scene import Part, Scene

DEEP_FILLING = 0.5
"""Filled share of a cell from which, far below the surface, its full stress acts."""


@dataclass(frozen=True)
class FreeSurface(Part):
    """A free surface at rest; stress acts in proportion to the filling of cells.

    No cell has a mass-matrix correction, which is derived for full cells.

    Example:
        >>> StruckColumn().build().find(FreeSurface)
        FreeSurface()
    """

    cell_bytes = 24.0

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Add the arrays of `_of_cells`; "cell.full_mass" is the mass of full stress [kg]."""
        for name, values in self._of_cells(scene, 0.0).items():
            plan.add_array(name, "real", values)

    def _of_cells(self, scene: Scene, travel: float) -> dict[str, Floats]:
        return {"cell.full_mass": scene.material.density * scene.grid.cell_volumes}


@dataclass(frozen=True, kw_only=True)
class PassingSurface(FreeSurface):
    """A free surface that the soil carries up through the window.

    Example:
        >>> PassingSurface(level=1.0, layer=0.1, pic_fraction=0.05)
        PassingSurface(level=1.0, layer=0.1, pic_fraction=0.05)
    """

    needs = (Window,)
    level: float = parameter(
        meaning="height of the undisturbed surface in the grid at the start", unit="m"
    )
    # everything above the level is near too, because soil heaves there
    layer: float = parameter(
        meaning="thickness of the layer below the level that counts as near", unit="m", above=0
    )
    pic_fraction: float = parameter(meaning="a near the surface", above=0, maximum=1)

    def follow(self, run: Run, scene: Scene, travel: float, *, by_a_row: bool) -> None:
        """Update which cells are near the surface."""
        for name, values in self._of_cells(scene, travel).items():
            run.assign(name, values)

    def _of_cells(self, scene: Scene, travel: float) -> dict[str, Floats]:
        """PIC fraction, and mass of full stress per radian [kg], of all cells."""
        grid = scene.grid
        near_rows = grid.rows[1:] > self.level + travel - self.layer
        is_near = np.repeat(near_rows, grid.column_count)
        full = scene.material.density * grid.cell_volumes
        return {
            "cell.pic_fraction": np.where(is_near, self.pic_fraction, 0.0),
            "cell.full_mass": np.where(is_near, full, DEEP_FILLING * full),
        }
