"""The position of a particle in its cell: natural coordinates, on a fitted or a polar grid.

Symbols: g column coordinate (0 on the surface, 1 at the fitted radius, beyond it radius over fitted
radius), s radius of the surface, 0 beyond the fitted radius, D difference across the cell;
column[i] = (g, Dg, 1/Dg), row[j] = (z, Dz, 1/Dz, s, Ds).
"""

import functools
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.kernel_types import one, real, vec2, vec3, vec4, vec5, zero


@dataclass(frozen=True)
class Location:
    """Device functions that place a particle in its cell."""

    natural: Any  # (position, column, row, fitted radius) -> (xi, eta)
    settle: Any  # (position, cell, columns, rows, fitted radius, cell counts) -> cell after a move
    outside_surface: Any  # (position, row) -> position, moved onto the surface if it was inside


@wp.func
def between_nodes(of_nodes: wp.array[vec4], node: int, stride: int, xi: real, eta: real):
    """Bilinear interpolation in the cell whose first node is `node`; `stride` nodes in a row."""
    upper = node + stride
    left = of_nodes[node] + eta * (of_nodes[upper] - of_nodes[node])
    right = of_nodes[node + 1] + eta * (of_nodes[upper + 1] - of_nodes[node + 1])
    return left + xi * (right - left)


@functools.cache
def make_location(polar: bool) -> Location:
    """Location functions of a polar grid or of one with horizontal rows."""

    @wp.func
    def on_grid(x: vec2) -> vec2:
        if wp.static(polar):
            return vec2(wp.length(x), wp.atan2(x[0], x[1]))
        return x

    @wp.func
    def natural(x: vec2, column: vec3, row: vec5, fitted_radius: real) -> vec2:
        q = on_grid(x)
        eta = wp.clamp((q[1] - row[0]) * row[2], zero, one)
        surface = wp.where(q[0] < fitted_radius, row[3] + eta * row[4], zero)
        span = fitted_radius - surface
        g = (q[0] - surface) / span
        xi = wp.clamp((g - column[0]) * column[2], zero, one)
        return vec2(xi, eta)

    @wp.func
    def settle(
        x: vec2,
        cell: wp.vec2i,
        columns: wp.array[vec3],
        rows: wp.array[vec5],
        fitted_radius: real,
        cell_counts: wp.vec2i,
    ) -> wp.vec2i:
        # At most to a neighbour: so no position leads to an index outside the grid.
        q = on_grid(x)
        i, j = cell[0], cell[1]
        row = rows[j]
        eta = (q[1] - row[0]) * row[2]
        if eta >= one:
            j = wp.min(j + 1, cell_counts[1] - 1)
        elif eta < zero:
            j = wp.max(j - 1, 0)
        row = rows[j]
        surface = row[3] + wp.clamp((q[1] - row[0]) * row[2], zero, one) * row[4]
        surface = wp.where(q[0] < fitted_radius, surface, zero)
        span = fitted_radius - surface
        column = columns[i]
        if q[0] - surface >= (column[0] + column[1]) * span:
            i = wp.min(i + 1, cell_counts[0] - 1)
        elif q[0] - surface < column[0] * span:
            i = wp.max(i - 1, 0)
        return wp.vec2i(i, j)

    @wp.func
    def outside_surface(x: vec2, row: vec5) -> vec2:
        if wp.static(polar):
            return wp.max(row[3] / wp.length(x), one) * x
        surface = row[3] + wp.clamp((x[1] - row[0]) * row[2], zero, one) * row[4]
        return vec2(wp.max(x[0], surface), x[1])

    return Location(natural, settle, outside_surface)
