"""Edges of a grid that are held, as most scenes of these tests have them."""

import numpy as np

from mpm_warp.grid.fitted import Grid
from mpm_warp.parts.boundaries import Fixed


def axis_and_ends(grid: Grid) -> Fixed:
    """No radial velocity on the axis, none at all at the bottom, no vertical one at the top."""
    radial = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
    radial[grid.surface_radius == 0.0, 0] = True
    radial[0] = True
    vertical = np.zeros_like(radial)
    vertical[[0, -1]] = True
    return Fixed.where(radial=radial, vertical=vertical)
