"""The geometry of cells that `mpm_warp.parts.even_flow_kernel` needs, worked out once."""

from __future__ import annotations

import numpy as np

from mpm_warp.grid.fitted import Floats, Grid


def even_flow_weights(grid: Grid) -> Floats:
    """Factors of sums and differences of the velocities of the nodes of each cell.

    Args:
        grid: axisymmetric, with horizontal rows.

    Returns:
        Ten dimensionless numbers a cell, in the order in which the kernel takes them; shape
        [cell_count, 10].
    """
    radius, height = np.moveaxis(grid.node_positions[grid.cell_nodes], -1, 0)
    r0, r1 = 0.5 * (radius[:, 0] + radius[:, 2]), 0.5 * (radius[:, 1] + radius[:, 3])
    r, w, h = 0.5 * (r0 + r1), r1 - r0, height[:, 2] - height[:, 0]
    lean = 0.5 * (radius[:, 2] - radius[:, 0] + radius[:, 3] - radius[:, 1])
    on_axis = r0 == 0.0
    centroid = (0.5 * r0 + w / 3.0) / r
    at_left = np.where(on_axis, 1.0 / 3.0, centroid)
    hoop = np.where(on_axis, 0.0, 0.25 * w / r)
    return np.stack(
        [
            at_left * w / h,
            (1.0 - centroid - at_left) * w / h,
            hoop,
            np.divide(hoop * w, r0, out=np.zeros_like(r0), where=~on_axis),
            -hoop * w / r1,
            0.5 * h / w,
            0.25 * h / r,
            -0.125 * h * lean / r**2,
            -0.5 * lean / w,
            lean / h,
        ],
        axis=-1,
    )
