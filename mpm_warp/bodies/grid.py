"""A uniform grid of square cells and the quadratic B-splines on it: nine nodes for each particle.

Symbols: h cell size, X_0 lowest of the three nodes along an axis, f = (x - X_0) / h, between 0.5
and 1.5.

    N = (3/2 - f)^2 / 2,    3/4 - (f - 1)^2,    (f - 1/2)^2 / 2
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.arguments import (
    FINITE,
    NOT_NEGATIVE,
    POSITIVE,
    Range,
    check_kind,
    check_number,
    check_whole,
)
from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import half, one, real, two, vec2, vec3

low, high = wp.constant(real(0.75)), wp.constant(real(1.5))


@dataclass(frozen=True, kw_only=True)
class UniformGrid:
    """A grid of square cells."""

    lower: tuple[float, float]  # corner of the lowest coordinates, (x, y) or (r, z) [m]; r >= 0
    cell_size: float  # side of a cell [m], > 0
    cell_counts: tuple[int, int]  # cells along both axes, >= 3 each
    axisymmetric: bool = False  # whether the axes are (r, z), else plane strain in (x, y)

    def __post_init__(self) -> None:
        check_number("grid: cell_size", self.cell_size, POSITIVE, unit="m")
        check_kind("grid: axisymmetric", self.axisymmetric, bool)
        for name in ("lower", "cell_counts"):
            if np.shape(getattr(self, name)) != (2,):
                raise SceneError(f"grid: {name} = {getattr(self, name)!r} must be two numbers")
        for count in self.cell_counts:
            check_whole("grid: cell_counts: one", count, Range(minimum=3))
        r, z = self.lower
        check_number("grid: lower r", r, NOT_NEGATIVE if self.axisymmetric else FINITE, unit="m")
        check_number("grid: lower z", z, unit="m")

    @property
    def node_counts(self) -> tuple[int, int]:
        """Nodes along both axes."""
        return self.cell_counts[0] + 1, self.cell_counts[1] + 1

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return self.node_counts[0] * self.node_counts[1]

    @property
    def particle_bounds(self) -> tuple[Floats, Floats]:
        """Lowest and highest coordinates at which all nodes of a quadratic B-spline exist [m]."""
        lower = np.asarray(self.lower) + 0.5 * self.cell_size
        return lower, lower + self.cell_size * (np.asarray(self.cell_counts) - 1.0)

    @property
    def kernel_arguments(self) -> dict[str, Any]:
        """The grid as kernels take it: lowest corner, cell size h, nodes along both axes."""
        return {
            "lower": vec2(*self.lower),
            "h": self.cell_size,
            "node_counts": wp.vec2i(*self.node_counts),
        }


@wp.func
def first_node(where: real, node_count: int) -> int:
    """Lowest of the three nodes of a place, over h from the lowest of all; the others exist too."""
    return wp.clamp(int(wp.floor(where - half)), 0, node_count - 3)


@wp.func
def spline(where: real, h: real, node_count: int):
    """Lowest of the three nodes of a place, and of the three N, dN/dx [1/m] and X - x [m].

    f is limited to its range: a particle that has left the grid stays finite until the watch finds
    it.
    """
    first = first_node(where, node_count)
    f = wp.clamp(where - real(first), half, high)
    weights = vec3(
        half * (high - f) * (high - f),
        low - (f - one) * (f - one),
        half * (f - half) * (f - half),
    )
    slopes = vec3(f - high, two * (one - f), f - half)
    offsets = vec3(-f, one - f, two - f)
    return first, weights, slopes / h, h * offsets
