"""Forces on nodes: gravity, given loads, damping.

v <- v - dt g e_z           g acceleration of gravity
v <- v + dt f / m           f given force, m mass of the node
v <- v / (1 + dt c)         c rate of damping, for states of rest
"""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.arguments import POSITIVE, check_array, check_nodes, checked
from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision
from mpm_warp.scene import Part, Scene


@dataclass(frozen=True)
class Gravity(Part):
    """Uniform gravity, downward.

    Attributes:
        acceleration: g [m/s2], > 0.
    """

    acceleration: float = checked(POSITIVE, unit="m/s2")

    def add_forces(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over all nodes."""
        plan.add_launch(
            _make_gravity(plan.precision),
            scene.grid.node_count,
            change=self.acceleration * plan.time_step,
        )


@functools.cache
def _make_gravity(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4
    zero = wp.constant(real(0.0))

    @wp.kernel(module=f"mpm_warp.gravity.{precision.numpy_name}", enable_backward=False)
    def gravity(
        offset: int,
        change: real,
        node_mass: wp.array(dtype=real),
        node_velocities: wp.array(dtype=vec4),
    ):
        node = offset + wp.tid()
        if node_mass[node] > zero:
            node_velocities[node] -= vec4(zero, change, zero, zero)

    return gravity


@dataclass(frozen=True, kw_only=True, eq=False)
class NodalLoad(Part):
    """Constant forces on nodes, there from the first step on.

    Attributes:
        nodes: flat indices, each once, shape [node_count].
        forces: (r, z) per radian, or in plane strain per thickness [N], shape [node_count, 2].
    """

    nodes: Integers
    forces: Floats

    def __post_init__(self) -> None:
        check_array("NodalLoad: forces", self.forces, (np.size(self.nodes), 2))

    def check(self, scene: Scene) -> None:
        """Check that the grid has the nodes."""
        check_nodes("NodalLoad: nodes", self.nodes, scene.grid.node_count)

    def add_forces(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over the loaded nodes."""
        plan.add_array("load.nodes", "int", self.nodes, (scene.grid.node_count,))
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


@dataclass(frozen=True)
class Damping(Part):
    """Drag in proportion to momentum, implicit in time.

    Attributes:
        rate: at which all motion dies out, force over momentum c [1/s], > 0.
    """

    rate: float = checked(POSITIVE, unit="1/s")

    def add_forces(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over all nodes."""
        plan.add_launch(
            _make_damping(plan.precision), scene.grid.node_count, drag=self.rate * plan.time_step
        )


@functools.cache
def _make_damping(precision: Precision) -> Any:
    real, vec4 = precision.real, precision.vec4
    one = wp.constant(real(1.0))

    @wp.kernel(module=f"mpm_warp.damping.{precision.numpy_name}", enable_backward=False)
    def damping(offset: int, drag: real, node_velocities: wp.array(dtype=vec4)):
        node = offset + wp.tid()
        v = node_velocities[node]
        node_velocities[node] = vec4(v[0] / (one + drag), v[1] / (one + drag), v[2], v[3])

    return damping
