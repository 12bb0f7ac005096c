"""Soil that encloses every cell: a cell that has no points for a moment is not a hole.

Behind a body in flowing soil points separate, and at times a cell has none. If the cell kept its
last stress, it would push or pull the soil around it by a constant force. Points never return to a
cell that pushes, so the work of this force would grow without end. Symbols: sigma stress of the
cell, K bulk modulus, e strain of a step.

    sigma <- (tr sigma / 3 + K tr e) 1          of a cell without points

Such a cell acts like a drop of liquid: it resists a change of volume as the soil does, but no
shear. A node of a surface without soil in any of its cells moves along its normal with the body.
Otherwise the volume of these cells would change at the full speed of the body.
"""

import numpy as np

from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Part, Scene, refuse_together


class EnclosedSoil(Part):
    """Soil is all around every cell: there is no free surface and no gap.

    Example:
        >>> BallPenetration().build().find(EnclosedSoil) is not None
        True
    """

    cell_bytes = 8.0

    def check(self, scene: Scene) -> None:
        """Check that there is no free surface."""
        refuse_together("EnclosedSoil", scene.find(FreeSurface) is not None, "a free surface")

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Add "cell.enclosed_modulus", K by the speed of pressure waves [Pa]."""
        soil = scene.material
        of_waves = soil.density * soil.pressure_wave_speed**2
        K = of_waves - 4.0 / 3.0 * soil.ground_shear_modulus
        plan.add_array("cell.enclosed_modulus", "real", np.full(scene.grid.cell_count, K))
