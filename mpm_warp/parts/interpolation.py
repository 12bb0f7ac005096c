"""Conservative velocity interpolation: a flow whose divergence is uniform in a cell.

A cell has one strain. The bilinear velocity between its nodes has this divergence only in the mean:
in some parts of the cell particles gather, in others they separate. Soil that stays long where
particles gather, such as beside a rough wall, piles up without end. So particles also move with a
flow within the cell that corrects the divergence and does not cross its edges (Meyer & Jenny 2004,
PAMM 4:466-467), here in axisymmetry and in plane strain.

Symbols: xi, eta natural coordinates of the cell, u_ij velocity (r, z) of its nodes, d change over
the step, h height, l increase of the radius of the edges over the height; at half the height, r0
and r1 radii of the left and right edge, r their mean, c centroid in xi, w width.

    d r = xi (1 - xi) (P + xi Q) + eta (1 - eta) S l / h
    d z = eta (1 - eta) S

    P     = w (c T / h + (r0 e1 - r1 e0) / (2 r r0))            T = u_00 - u_10 - u_01 + u_11, its z
    P + Q = w ((1 - c) T / h + (r0 e1 - r1 e0) / (2 r r1))      e_i = mean of u_i0 and u_i1, its r
    S     = h (C - l T / h) / (2 w)                             C = the same sum as T, its r
            + h ((a_0 + a_1) / 2 - (e0 + e1) l / (2 r)) / (2 r) a_i = u_i1 - u_i0, its r

In an upright cell the mean divergence at each height, and that along both edges, is exactly that of
the cell. In between, and where edges lean, about w / r of the former error is left. In a cell on
the axis r0 and e0 are 0, P = w T / (3 h), Q = 0, and the divergence is the same everywhere. The
same holds for upright cells in plane strain, where 1 / r is 0: c = 1/2, P = w T / (2 h), Q = 0.
"""

import numpy as np
import warp as wp

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.kernel_types import one, real, vec2, vec4, vec10
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Part, Scene, refuse_together


class ConservativeInterpolation(Part):
    """Particles follow a flow with a uniform divergence in each cell.

    For soil that flows along a wall for long. The grid has horizontal rows.

    Example:
        >>> ConePenetration().build().find(ConservativeInterpolation) is not None
        True
    """

    cell_bytes = 112.0

    def check(self, scene: Scene) -> None:
        """Check that the grid has horizontal rows."""
        refuse_together("ConservativeInterpolation", scene.grid.polar, "a grid of rays")

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Add the weights of the cells."""
        plan.add_array("cell.interpolation_weights", "vec10", interpolation_weights(scene.grid))


def interpolation_weights(grid: Grid) -> Floats:
    """Ten dimensionless weights of `conservative_flow` for each cell, shape [cell_count, 10]."""
    radius, height = np.moveaxis(grid.node_positions[grid.cell_nodes], -1, 0)
    r0, r1 = 0.5 * (radius[:, 0] + radius[:, 2]), 0.5 * (radius[:, 1] + radius[:, 3])
    r, w, h = 0.5 * (r0 + r1), r1 - r0, height[:, 2] - height[:, 0]
    lean = 0.5 * (radius[:, 2] - radius[:, 0] + radius[:, 3] - radius[:, 1])
    on_axis = r0 == 0.0
    centroid = (0.5 * r0 + w / 3.0) / r
    at_left = np.where(on_axis, 1.0 / 3.0, centroid)
    hoop = np.where(on_axis, 0.0, 0.25 * w / r)
    if grid.planar:
        none = np.zeros_like(w)
        upright = [0.5 * w / h, none, none, none, none, 0.5 * h / w, none, none]
        return np.stack([*upright, -0.5 * lean / w, lean / h], axis=-1)
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


@wp.func
def conservative_flow(u_00: vec4, u_10: vec4, u_01: vec4, u_11: vec4, weight: vec10) -> vec4:
    """(P, Q, S l / h, S) of a cell per time."""
    T = (u_00[1] - u_10[1]) - (u_01[1] - u_11[1])
    left, right = u_00[0] + u_01[0], u_10[0] + u_11[0]
    a_0, a_1 = u_01[0] - u_00[0], u_11[0] - u_10[0]
    P = weight[0] * T + weight[2] * (right - left) - weight[3] * left
    Q = weight[1] * T + weight[3] * left + weight[4] * right
    S = (
        weight[5] * (a_1 - a_0)
        + weight[6] * (a_0 + a_1)
        + weight[7] * (left + right)
        + weight[8] * T
    )
    return vec4(P, Q, weight[9] * S, S)


@wp.func
def flow_displacement(flow: vec4, xi: real, eta: real) -> vec2:
    """(d r, d z) at a place in the cell, from `conservative_flow` times the time step."""
    upright = eta * (one - eta)
    across = xi * (one - xi) * (flow[0] + xi * flow[1])
    return vec2(across + upright * flow[2], upright * flow[3])
