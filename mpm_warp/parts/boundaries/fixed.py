"""Nodes at rest relative to undisturbed soil, in r, z or both: v <- free v, free being 0 or 1."""

import functools
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.arguments import Range, check_array, check_nodes
from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats, Grid, Integers
from mpm_warp.parts.part import Setting
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision

Booleans = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Fixed:
    """Nodes that rest relative to undisturbed soil, in r, z or both.

    Attributes:
        nodes: flat indices, each once, shape [node_count].
        free: 1 where the velocity component is free, 0 where it is held, shape [node_count, 2].

    Raises:
        SceneError: a value is not allowed.
    """

    nodes: Integers
    free: Floats

    def __post_init__(self) -> None:
        count = np.size(self.nodes)
        check_array("fixed: free", self.free, (count, 2), Range(minimum=0.0, maximum=1.0))
        between = self.free[(self.free != 0.0) & (self.free != 1.0)]
        if between.size:
            raise SceneError(f"fixed: free = {between[0]:g} must be 0 or 1")

    def check(self, setting: Setting) -> None:
        """Check that the grid has the nodes."""
        check_nodes("fixed: nodes", self.nodes, setting.grid.node_count)

    @classmethod
    def axis(cls, grid: Grid) -> Self:
        """No radial velocity on the axis."""
        radial = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
        radial[grid.surface_radius == 0.0, 0] = True
        return cls.where(radial=radial, vertical=np.zeros_like(radial))

    @classmethod
    def where(cls, *, radial: Booleans, vertical: Booleans) -> Self:
        """Nodes held where a mask says so, one mask a component.

        Args:
            radial: where the radial velocity is held, shape [row_count + 1, column_count + 1].
            vertical: the same for the vertical velocity.
        """
        free = np.where(np.stack([radial, vertical], axis=-1), 0.0, 1.0).reshape(-1, 2)
        nodes = np.flatnonzero(free.min(axis=-1) == 0.0)
        return cls(nodes=nodes, free=free[nodes])

    def add_to(self, plan: Plan, setting: Setting) -> None:
        """Add the launch, over the held nodes."""
        plan.add_array("fixed.nodes", "int", self.nodes, (setting.grid.node_count,))
        plan.add_array("fixed.free", "vec2", self.free)
        plan.add_launch(_make_fixed(plan.precision), len(self.nodes))


@functools.cache
def _make_fixed(precision: Precision) -> Any:
    vec2, vec4 = precision.vec2, precision.vec4

    @wp.kernel(module=f"mpm_warp.fixed.{precision.numpy_name}", enable_backward=False)
    def fixed(
        offset: int,
        fixed_nodes: wp.array(dtype=int),
        fixed_free: wp.array(dtype=vec2),
        node_velocities: wp.array(dtype=vec4),
    ):
        k = offset + wp.tid()
        node, free = fixed_nodes[k], fixed_free[k]
        v = node_velocities[node]
        node_velocities[node] = vec4(free[0] * v[0], free[1] * v[1], v[2], v[3])

    return fixed
