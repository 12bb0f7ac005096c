"""Quadratic B-splines on a uniform grid: nine nodes for each particle.

Symbols: h cell size, X_0 lowest node of the nine, f = (x - X_0) / h from 0.5 to 1.5 on each axis.

    N = (3/2 - f)^2 / 2,    3/4 - (f - 1)^2,    (f - 1/2)^2 / 2
"""

import functools
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@dataclass(frozen=True)
class Splines:
    """Device functions along one axis.

    Attributes:
        first_node: (x / h from the lowest node of the grid, nodes) -> lowest of the three nodes;
            three nodes exist from there on, whatever x is.
        place: (x / h from the lowest node of the grid, first node) -> f; of a particle that has
            left the grid that at its edge, so that it stays finite until the watch finds it.
        weights: f -> N of the three nodes.
        slopes: f -> h dN/dx of the three nodes.
        offsets: f -> (X - x) / h of the three nodes.
    """

    first_node: Any
    place: Any
    weights: Any
    slopes: Any
    offsets: Any


@functools.cache
def make_splines(precision: Precision) -> Splines:
    """Spline functions in one precision."""
    real, vec3 = precision.real, precision.vec3
    half, one, two = (wp.constant(real(x)) for x in (0.5, 1.0, 2.0))
    low, high = wp.constant(real(0.75)), wp.constant(real(1.5))

    @wp.func
    def first_node(x: real, node_count: int) -> int:
        return wp.clamp(int(wp.floor(x - half)), 0, node_count - 3)

    @wp.func
    def place(x: real, first: int) -> real:
        return wp.clamp(x - real(first), half, high)

    @wp.func
    def weights(f: real) -> vec3:
        return vec3(
            half * (high - f) * (high - f),
            low - (f - one) * (f - one),
            half * (f - half) * (f - half),
        )

    @wp.func
    def slopes(f: real) -> vec3:
        return vec3(f - high, two * (one - f), f - half)

    @wp.func
    def offsets(f: real) -> vec3:
        return vec3(-f, one - f, two - f)

    return Splines(first_node, place, weights, slopes, offsets)
