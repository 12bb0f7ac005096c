"""Flow that changes volume alike all over a cell, as the cell's one strain says.

The bilinear velocity between the nodes of a cell does so only in the mean: here it gathers
particles, there it parts them. Whatever soil stays for long where it gathers, beside a rough wall
say, piles up without end. So particles take a part in their motion that makes it even, which
vanishes on the edges of the cell that it would cross: conservative velocity interpolation (Meyer &
Jenny 2004, PAMM 4:466-467), here about an axis.

Symbols: xi, eta natural coordinates of the cell, u_ij velocity (r, z) of its nodes, d change over
the step. At half the height, r0 and r1 radii of the left and right edge, r their mean, c centroid
in xi, w width; h height, l lean of the edges: the rise of their radius over the height.

    d r = xi (1 - xi) (P + xi Q) + eta (1 - eta) S l / h
    d z = eta (1 - eta) S

    P     = w (c T / h + (r0 e1 - r1 e0) / (2 r r0))            T = u_00 - u_10 - u_01 + u_11, its z
    P + Q = w ((1 - c) T / h + (r0 e1 - r1 e0) / (2 r r1))      e_i = mean of u_i0 and u_i1, its r
    S     = h (C - l T / h) / (2 w)                             C = the r of what T is the z of
            + h ((a_0 + a_1) / 2 - (e0 + e1) l / (2 r)) / (2 r) a_i = u_i1 - u_i0, its r

In an upright cell all heights, and along their length both edges, have the divergence of the cell
exactly; in between it is off by about w / r of what it was, as where edges lean. In a cell on the
axis r0 and e0 are 0, P = w T / (3 h), Q = 0, and the divergence is the same everywhere.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@functools.cache
def make_even_flow(precision: Precision) -> Any:
    """The function (motion of the four nodes, weights of the cell) -> (P, Q, S l / h, S).

    The weights are those of `mpm_warp.parts.even_flow`; results are per time.
    """
    vec4, vec10 = precision.vec4, precision.vec10

    @wp.func
    def even_flow(u_00: vec4, u_10: vec4, u_01: vec4, u_11: vec4, weight: vec10) -> vec4:
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

    return even_flow
