"""Conditions at the edges of a grid: held nodes, radial motion, an elastic far field.

Held nodes rest relative to undisturbed soil; free is 0 or 1 for each component. Radial motion is
along the ray n of a node. In soil that softens it keeps the flow radial: without it the smallest
disturbance would localise the strain in bands (Rudnicki & Rice 1975, J. Mech. Phys. Solids
23:371-394). The far field has springs k and dashpots c, per radian; w is the radial displacement of
a node. The dashpots are implicit:

    v <- free v                                                 held nodes
    v <- (v . n) n                                              radial motion
    m dv/dt = -k w - c v,    dw/dt = v_r                        far field
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.errors import SceneError
from mpm_warp.fields.checks import check_known, check_nodes
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats, Grid, Integers, nodal_areas
from mpm_warp.kernel_types import kernel, one, real, vec2, vec4, zero
from mpm_warp.materials.material import Material
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.scene import Part, Scene, refuse_together

Booleans = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True, eq=False)
class Fixed(Part):
    """Nodes that rest relative to undisturbed soil, in r, z or both.

    Attributes:
        nodes: flat indices, each once, shape [node_count].

    Example:
        >>> grid = GravityColumn(cell_count=4).build().grid
        >>> Fixed.on(grid, radial=["everywhere"], vertical=["bottom"]).nodes.size
        10
    """

    nodes: Integers
    free: Floats = parameter(
        meaning="1 where the velocity component is free, 0 where it is held",
        shape=("nodes", 2),
        minimum=0,
        maximum=1,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        between = self.free[(self.free != 0.0) & (self.free != 1.0)]
        if between.size:
            raise SceneError(f"Fixed: free = {between[0]:g} must be 0 or 1")

    def check(self, scene: Scene) -> None:
        """Check that the grid has the nodes."""
        check_nodes("Fixed: nodes", self.nodes, scene.grid.node_count)

    @classmethod
    def on(cls, grid: Grid, *, radial: Sequence[str] = (), vertical: Sequence[str] = ()) -> Self:
        """Nodes whose radial or vertical velocity is held along lines of a grid.

        Lines are "bottom", "top", "side", "axis", as far as there is soil on it, and "everywhere".
        """
        lines: dict[str, Any] = {
            "bottom": np.s_[0],
            "top": np.s_[-1],
            "side": np.s_[:, -1],
            "axis": (grid.surface_radius == 0.0, 0),
            "everywhere": np.s_[:],
        }
        held = np.zeros((2, grid.row_count + 1, grid.column_count + 1), dtype=bool)
        for component, names in zip(held, (radial, vertical), strict=True):
            for name in names:
                check_known("Fixed: line", name, lines)
                component[lines[name]] = True
        return cls.where(radial=held[0], vertical=held[1])

    @classmethod
    def where(cls, *, radial: Booleans, vertical: Booleans) -> Self:
        """Nodes held where masks of shape [row_count + 1, column_count + 1] are true."""
        free = np.where(np.stack([radial, vertical], axis=-1), 0.0, 1.0).reshape(-1, 2)
        nodes = np.flatnonzero(free.min(axis=-1) == 0.0)
        return cls(nodes=nodes, free=free[nodes])

    def add_boundary(self, plan: Plan, scene: Scene) -> None:
        """Add the launch over the held nodes."""
        plan.add_array("fixed.nodes", "int", self.nodes, (scene.grid.node_count,))
        plan.add_array("fixed.free", "vec2", self.free)
        plan.add_launch(fixed, len(self.nodes))


@kernel
def fixed(
    offset: int,
    fixed_nodes: wp.array[int],
    fixed_free: wp.array[vec2],
    node_velocities: wp.array[vec4],
):
    """Launched over the held nodes."""
    k = offset + wp.tid()
    node, free = fixed_nodes[k], fixed_free[k]
    v = node_velocities[node]
    node_velocities[node] = vec4(free[0] * v[0], free[1] * v[1], v[2], v[3])


@dataclass(frozen=True, kw_only=True)
class RadialMotion(Part):
    """The nodes of a polar grid move only along their rays.

    Example:
        >>> cavity = CavitySphere(remoulded_strength_ratio=0.5, ductility=10)
        >>> cavity.build().find(RadialMotion)
        RadialMotion()
    """

    def check(self, scene: Scene) -> None:
        """Check that the grid is polar."""
        if not scene.grid.polar:
            raise SceneError("radial motion: the grid is a Grid, must be a PolarGrid")

    def add_boundary(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over nodes."""
        plan.add_array("ray.direction", "vec2", scene.grid.surface_normals)
        plan.add_launch(radial_motion, scene.grid.node_count)


@kernel
def radial_motion(
    offset: int, column_count: int, ray_direction: wp.array[vec2], node_velocities: wp.array[vec4]
):
    """Launched over nodes."""
    k = offset + wp.tid()
    n = ray_direction[k / (column_count + 1)]
    v = node_velocities[k]
    along = wp.dot(vec2(v[0], v[1]), n)
    node_velocities[k] = vec4(along * n[0], along * n[1], v[2], v[3])


QUIET_SPEED_RATIO = 3.3
"""Speed of pressure waves over that of shear waves at a Poisson's ratio of 0.45."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FarField(Part):
    """The infinite elastic medium beyond the outer radius of the grid.

    It is a spring of 2 G / r per area (the elastic cavity, u = p r / 2 G) and the quiet dashpots
    rho c of Lysmer & Kuhlemeyer (1969, J. Eng. Mech. Div. 95(4):859-877) for waves. Dashpots also
    resist steady flow, in proportion to c. So the speed of pressure waves is limited to
    `QUIET_SPEED_RATIO` times that of shear waves. In nearly incompressible clay it is higher, and
    part of these waves is reflected.

    Attributes:
        nodes: flat indices of the nodes on the side, upward, shape [node_count].

    Example:
        >>> CavityCylinder().build().find(FarField).nodes.size
        2
    """

    nodes: Integers
    spring: Floats = parameter(
        meaning="stiffness of each node per radian", unit="N/m", shape=("nodes",), minimum=0
    )
    dashpot: Floats = parameter(
        meaning="viscosity of each node along r and z per radian",
        unit="N s/m",
        shape=("nodes", 2),
        minimum=0,
    )

    def check(self, scene: Scene) -> None:
        """Check that the grid has the nodes, and that the soil is uniform."""
        check_nodes("FarField: nodes", self.nodes, scene.grid.node_count)
        refuse_together(
            "FarField",
            scene.material.variation is not None,
            "a material that varies; around a window give it a SurroundingGround",
        )

    @classmethod
    def around(cls, grid: Grid, material: Material) -> Self:
        """The medium around the outer side of a grid, an upright cylinder.

        Raises:
            SceneError: the grid is polar or in plane strain.
        """
        refuse_together("FarField.around", grid.polar, "a grid of rays")
        refuse_together("FarField.around", grid.planar, "plane strain")
        area = grid.outer_radius * nodal_areas(np.ones_like(grid.rows), np.diff(grid.rows))
        shear_speed = material.shear_wave_speed
        quiet_speed = min(material.pressure_wave_speed, QUIET_SPEED_RATIO * shear_speed)
        speeds = np.array([quiet_speed, shear_speed])
        return cls(
            nodes=grid.node(grid.column_count, np.arange(grid.row_count + 1)),
            spring=2.0 * material.ground_shear_modulus / grid.outer_radius * area,
            dashpot=material.density * area[:, None] * speeds,
        )

    def add_boundary(self, plan: Plan, scene: Scene) -> None:
        """Add the launch, over the nodes of the side."""
        plan.add_array("far_field.nodes", "int", self.nodes, (scene.grid.node_count,))
        plan.add_array("far_field.spring", "real", self.spring)
        plan.add_array("far_field.dashpot", "vec2", self.dashpot)
        plan.add_zeros("far_field.displacement", "real", len(self.nodes))
        plan.add_launch(far_field, len(self.nodes))

    def follow(self, run: Run, scene: Scene, travel: float, *, by_a_row: bool) -> None:
        """Move the springs up with the soil beside them; a new spring has no force."""
        if by_a_row:
            raise_springs(run, lowest=0.0)


def raise_springs(run: Run, *, lowest: Floats | float) -> None:
    """Move the springs up by a row; the new lowest one has the displacement `lowest` [m]."""
    springs = np.roll(run.array("far_field.displacement"), 1, axis=0)
    springs[0] = lowest
    run.assign("far_field.displacement", springs)


@kernel
def far_field(
    offset: int,
    far_field_nodes: wp.array[int],
    far_field_spring: wp.array[real],
    far_field_dashpot: wp.array[vec2],
    node_mass: wp.array[real],
    time_step: real,
    far_field_displacement: wp.array[real],
    node_velocities: wp.array[vec4],
):
    """Launched over the nodes of the side."""
    k = offset + wp.tid()
    node = far_field_nodes[k]
    if node_mass[node] <= zero:
        return
    v, c, w = node_velocities[node], far_field_dashpot[k], far_field_displacement[k]
    rate = time_step / node_mass[node]
    v_r = (v[0] - rate * far_field_spring[k] * w) / (one + rate * c[0])
    v_z = v[1] / (one + rate * c[1])
    far_field_displacement[k] = w + time_step * v_r
    node_velocities[node] = vec4(v_r, v_z, v[2], v[3])
