"""Constant forces on nodes: v <- v + dt f / m, with f the force and m the mass of a node."""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.arguments import check_array, check_nodes
from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.parts.part import Setting
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision


@dataclass(frozen=True, kw_only=True, eq=False)
class NodalLoad:
    """Constant forces on nodes, there from the first step on.

    Attributes:
        nodes: flat indices, each once, shape [node_count].
        forces: (r, z) per radian, or in plane strain per thickness [N], shape [node_count, 2].

    Raises:
        SceneError: a value is not allowed.
    """

    nodes: Integers
    forces: Floats

    def __post_init__(self) -> None:
        check_array("load: forces", self.forces, (np.size(self.nodes), 2))

    def check(self, setting: Setting) -> None:
        """Check that the grid has the nodes."""
        check_nodes("load: nodes", self.nodes, setting.grid.node_count)

    def add_to(self, plan: Plan, setting: Setting) -> None:
        """Add the launch, over the loaded nodes."""
        plan.add_array("load.nodes", "int", self.nodes, (setting.grid.node_count,))
        plan.add_array("load.forces", "vec2", self.forces)
        plan.add_launch(_make_nodal_load(plan.precision), len(self.nodes))


@functools.cache
def _make_nodal_load(precision: Precision) -> Any:
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    zero = wp.constant(real(0.0))

    @wp.kernel(module=f"mpm_warp.nodal_load.{precision.numpy_name}", enable_backward=False)
    def nodal_load(
        load_nodes: wp.array(dtype=int),
        load_forces: wp.array(dtype=vec2),
        node_mass: wp.array(dtype=real),
        time_step: real,
        node_velocities: wp.array(dtype=vec4),
    ):
        k = wp.tid()
        node = load_nodes[k]
        if node_mass[node] <= zero:
            return
        change = (time_step / node_mass[node]) * load_forces[k]
        node_velocities[node] += vec4(change[0], change[1], zero, zero)

    return nodal_load
