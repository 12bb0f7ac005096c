"""Flow that changes volume alike all over a cell, as the cell's one strain says.

The bilinear velocity between the nodes of a cell does so only in the mean: here it gathers
particles, there it parts them. Whatever soil stays for long where it gathers, beside a rough wall
say, piles up without end. So particles take a part in their motion that makes it even, which
vanishes on the edges of the cell that it would cross: conservative velocity interpolation (Meyer &
Jenny 2004, PAMM 4:466-467), here about an axis.

Symbols: xi, eta natural coordinates; at half the height of a cell r0 and r1 radii of its left and
right edge, r their mean, e0 and e1 radial velocities there, c centroid in xi; w width, h height,
l rise of the edges' radius across the cell, v_ri that of the radial velocity along edge i;
C = v_00 - v_10 - v_01 + v_11 over the nodes (xi, eta).

    dxi/dt  = xi (1 - xi) (X_0 + xi (X_1 - X_0))
    deta/dt = eta (1 - eta) Y

    X_0 = c C_z / h       + (r0 e1 - r1 e0) / (2 r r0)
    X_1 = (1 - c) C_z / h + (r0 e1 - r1 e0) / (2 r r1)
    Y   = (C_r - l C_z / h) / (2 w) + ((v_r0 + v_r1) / 2 - (e0 + e1) l / (2 r)) / (2 r)

In an upright cell all heights, and along their length both edges, have the divergence of the cell
exactly; in between it is off by about w / r of what it was, as where edges lean. In a cell on the
axis r0 and e0 are 0, X = C_z / (3 h) all over, and the divergence is the same everywhere.
"""

from __future__ import annotations

import numpy as np

from mpm_warp.grids import Floats, Grid


def even_flow_weights(grid: Grid) -> Floats:
    """What (X_0, X_1 - X_0, Y) of each cell owe to the velocities of its nodes.

    Args:
        grid: axisymmetric, with horizontal rows.

    Returns:
        Weights [1/m] of the radial velocities of the four nodes in the order of
        `Grid.cell_nodes`, then that of C_z; shape [cell_count, 5, 3].
    """
    assert not grid.polar, "flow is made even in horizontal rows"
    assert not grid.planar, "flow is made even about an axis"
    radius, height = np.moveaxis(grid.node_positions[grid.cell_nodes], -1, 0)
    left, right = 0.5 * (radius[:, 0] + radius[:, 2]), 0.5 * (radius[:, 1] + radius[:, 3])
    middle, width, tall = 0.5 * (left + right), right - left, height[:, 2] - height[:, 0]
    rise = 0.5 * (radius[:, 2] - radius[:, 0] + radius[:, 3] - radius[:, 1])
    centroid = (0.5 * left + width / 3.0) / middle
    on_axis = left == 0.0

    first, last, along = np.zeros((3, grid.cell_count, 5))
    first[:, 4] = np.where(on_axis, 1.0 / 3.0, centroid) / tall
    last[:, 4] = (1.0 - centroid) / tall
    for side, weight in enumerate((-right, left)):
        by_left = np.divide(weight, 4.0 * middle * left, out=np.zeros_like(left), where=~on_axis)
        by_right = np.where(on_axis, 0.0, weight / (4.0 * middle * right))
        first[:, [side, side + 2]] = by_left[:, None]
        last[:, [side, side + 2]] = by_right[:, None]
    for node, (sign_xi, sign_eta) in enumerate(((-1, -1), (1, -1), (-1, 1), (1, 1))):
        twist = sign_xi * sign_eta / width
        hoop = 0.5 * sign_eta / middle - 0.25 * rise / middle**2
        along[:, node] = 0.5 * (twist + hoop)
    along[:, 4] = -0.5 * rise / (tall * width)
    return np.stack([first, last - first, along], axis=-1)
