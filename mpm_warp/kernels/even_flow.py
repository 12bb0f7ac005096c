"""Flow that changes volume alike all over a cell, as the cell's one strain says.

The bilinear velocity between the nodes of a cell does so only in the mean: here it gathers
particles, there it parts them. Whatever soil stays for long where it gathers, beside a rough wall
say, piles up without end. So particles take a part in their motion that makes it even, which
vanishes on the edges of the cell that it would cross: conservative velocity interpolation (Meyer &
Jenny 2004, PAMM 4:466-467), here about an axis.

Symbols: xi, eta natural coordinates; at half the height of a cell r0 and r1 radii of its left and
right edge, r their mean, e0 and e1 radial velocities there, c centroid in xi; w width, h height;
l lean of the edges, the rise of their radius over the height, and v_ri that of the radial velocity
along edge i; C = v_00 - v_10 - v_01 + v_11 over the nodes (xi, eta).

    dxi/dt  = xi (1 - xi) (X_0 + xi (X_1 - X_0))
    deta/dt = eta (1 - eta) Y

    X_0 = c C_z / h       + (r0 e1 - r1 e0) / (2 r r0)
    X_1 = (1 - c) C_z / h + (r0 e1 - r1 e0) / (2 r r1)
    Y   = (C_r - l C_z / h) / (2 w) + ((v_r0 + v_r1) / 2 - (e0 + e1) l / (2 r)) / (2 r)

In an upright cell all heights, and along their length both edges, have the divergence of the cell
exactly; in between it is off by about w / r of what it was, as where edges lean. In a cell on the
axis r0 and e0 are 0, X = C_z / (3 h) all over, and the divergence is the same everywhere.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.kernels.precision import Precision


@functools.cache
def make_even_flow(precision: Precision) -> Any:
    """The function (motion of the four nodes, column, row, outer radius) -> (X_0, X_1 - X_0, Y).

    Columns and rows are those of `mpm_warp.kernels.location`, of a grid with horizontal rows about
    an axis.
    """
    real, vec3, vec4, vec5 = precision.real, precision.vec3, precision.vec4, precision.vec5
    zero, half, one, third = (wp.constant(real(x)) for x in (0.0, 0.5, 1.0, 1.0 / 3.0))

    @wp.func
    def even_flow(
        v_00: vec4, v_10: vec4, v_01: vec4, v_11: vec4, column: vec3, row: vec5, outer_radius: real
    ) -> vec3:
        surface = row[3] + half * row[4]
        span = outer_radius - surface
        w = span * column[1]
        r0 = surface + span * column[0]
        r1 = r0 + w
        r = r0 + half * w
        lean = row[4] * (one - column[0] - half * column[1])
        # Divisions cost most: one for both of these, one for both of those below.
        per_r_w = one / (r * w)
        per_r, per_w = w * per_r_w, r * per_r_w

        C_r = v_00[0] - v_10[0] - v_01[0] + v_11[0]
        C_z_per_h = row[2] * (v_00[1] - v_10[1] - v_01[1] + v_11[1])
        e0 = half * (v_00[0] + v_01[0])
        e1 = half * (v_10[0] + v_11[0])
        rise = half * (v_01[0] - v_00[0] + v_11[0] - v_10[0])
        twist = per_w * (C_r - lean * C_z_per_h)
        Y = half * (twist + per_r * (rise - half * per_r * lean * (e0 + e1)))
        if r0 <= zero:
            return vec3(third * C_z_per_h, zero, Y)
        c = per_r * (half * r0 + third * w)
        hoop = half * per_r * (r0 * e1 - r1 * e0) / (r0 * r1)
        X_0 = c * C_z_per_h + r1 * hoop
        X_1 = (one - c) * C_z_per_h + r0 * hoop
        return vec3(X_0, X_1 - X_0, Y)

    return even_flow
