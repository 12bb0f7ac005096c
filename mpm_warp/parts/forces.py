"""Forces on nodes: gravity, given loads, damping.

v <- v - dt g e_z           g acceleration of gravity
v <- v + dt f / m           f given force, m mass of the node
v <- v / (1 + dt c)         c rate of damping, for states of rest
"""

from dataclasses import dataclass

import warp as wp

from mpm_warp.fields.checks import check_nodes
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.kernel_types import kernel, one, real, vec2, vec4, zero
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Part, Scene


@dataclass(frozen=True)
class Gravity(Part):
    """Uniform gravity, downward.

    Example:
        >>> Gravity(9.81)
        Gravity(acceleration=9.81)
    """

    acceleration: float = parameter(meaning="acceleration g", unit="m/s2", above=0)

    def add_forces(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over all nodes."""
        plan.add_launch(gravity, scene.grid.node_count, change=self.acceleration * plan.time_step)


@kernel
def gravity(offset: int, change: real, node_mass: wp.array[real], node_velocities: wp.array[vec4]):
    """Launched over nodes; a node without soil is left out."""
    node = offset + wp.tid()
    if node_mass[node] > zero:
        node_velocities[node] -= vec4(zero, change, zero, zero)


@dataclass(frozen=True, kw_only=True, eq=False)
class NodalLoad(Part):
    """Constant forces on nodes from the first step on.

    Attributes:
        nodes: flat indices, each once, shape [node_count].

    Example:
        >>> load = NodalLoad(nodes=np.array([3]), forces=np.array([[0.0, -100.0]]))  # [N]
        >>> GravityColumn().build().with_parts(load).find(NodalLoad) is load
        True
    """

    nodes: Integers
    forces: Floats = parameter(
        meaning="forces (r, z) per radian, or in plane strain per thickness",
        unit="N",
        shape=("nodes", 2),
    )

    def check(self, scene: Scene) -> None:
        """Check that the grid has the nodes."""
        check_nodes("NodalLoad: nodes", self.nodes, scene.grid.node_count)

    def add_forces(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over the loaded nodes."""
        plan.add_array("load.nodes", "int", self.nodes, (scene.grid.node_count,))
        plan.add_array("load.forces", "vec2", self.forces)
        plan.add_launch(nodal_load, len(self.nodes))


@kernel
def nodal_load(
    load_nodes: wp.array[int],
    load_forces: wp.array[vec2],
    node_mass: wp.array[real],
    time_step: real,
    node_velocities: wp.array[vec4],
):
    """Launched over the loaded nodes."""
    k = wp.tid()
    node = load_nodes[k]
    if node_mass[node] <= zero:
        return
    change = (time_step / node_mass[node]) * load_forces[k]
    node_velocities[node] += vec4(change[0], change[1], zero, zero)


@dataclass(frozen=True)
class Damping(Part):
    """Drag in proportion to momentum, implicit in time.

    Example:
        >>> Damping(rate=140.0)
        Damping(rate=140.0)
    """

    rate: float = parameter(meaning="c, force over momentum", unit="1/s", above=0)

    def add_forces(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over all nodes."""
        plan.add_launch(damping, scene.grid.node_count, drag=self.rate * plan.time_step)


@kernel
def damping(offset: int, drag: real, node_velocities: wp.array[vec4]):
    """Launched over nodes."""
    node = offset + wp.tid()
    v = node_velocities[node]
    node_velocities[node] = vec4(v[0] / (one + drag), v[1] / (one + drag), v[2], v[3])
