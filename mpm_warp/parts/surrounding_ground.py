"""The elastic ground around a travelling window, displaced by the body in the window.

The body displaces the volume pi R^2 per unit of its travel, where R is the radius of the shaft
behind it. From afar it is a point source. With x = (r, z) relative to the source, z upward,
d = |x|, and V the speed of the body, incompressible elastic ground has the velocity

    v = V R^2 / 4 x / d^3                                          velocity

This field is harmonic, so the mean stress does not change. While the source comes from infinitely
far above, the ground gets the stress 2 G grad v integrated over time, for (rr, zz, rz, tt)

    2 G R^2 / 4 (-(q + z / d^3), z / d^3, r / d^3, q)              stress
    q = 1 / (d (d - z)) = (1 + z / d) / r^2

The soil in the grid starts with this stress, as if the body had come from far; its deviator is
reduced to su where it is larger. The first waves build up the pressure in equilibrium with it. The
body pushes through soil that yields ahead of it, so this source is ahead of the body by
0.3 R sqrt(G/su). A start in undisturbed ground would affect the resistance over a penetration of
two to three heights of the window.

Bottom and top of the grid have this velocity. Along the side, spring k and dashpot c of a node
resist motion that differs from it, per radian and for each component. A is the area of the node, t
the growth of the source's traction per travel, v the source's velocity over V:

    m dv_node/dt = -k w - c (v_node - V v),    dw/dt = v_node - V (v + A t / k)

Where a free surface passes, k and c of a node are in proportion to its mass over that beside full
cells.

Soil that enters at the bottom has the velocity and the stress of the source; springs that enter
beside it balance that stress. Where the material varies, stress, springs and dashpots follow the
local stiffness; k and t are in proportion, so the motion is that of uniform ground.

So a small window has the resistance of a large one. Between a bottom and a top at rest the
displaced volume would have to flow out sideways, which needs additional pressure.
"""

import functools
import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.kernel_types import kernel, one, real, two, vec2, vec4, zero
from mpm_warp.materials.material import Material, principal_stresses
from mpm_warp.parts.boundaries import FarField, Fixed, raise_springs
from mpm_warp.parts.window import Window
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.scene import Part, Scene

SOURCE_DISTANCE = 0.3
"""Distance of the source of the initial stress ahead of the body, over R sqrt(G / su), the radius
of the plastic zone around a long shaft. Here the stress is most like that after a long travel."""
ISOTROPIC = np.array([1.0, 1.0, 0.0, 1.0])
"""(rr, zz, rz, tt) of an isotropic unit stress."""


@dataclass(frozen=True, kw_only=True)
class TravellingSource(Checked):
    """Motion and stress of elastic ground far from a body that moves down.

    Positions are (r, z) in a grid that travels with the body [m], shape [..., 2].

    Example:
        >>> source = TravellingSource(radius=0.02, height=0.0, shear_modulus=1e6)
        >>> source.velocity(np.array([[0.1, 0.0], [0.2, 0.0]])).shape
        (2, 2)
    """

    radius: float = parameter(meaning="radius of the shaft behind the body", unit="m", above=0)
    height: float = parameter(meaning="height of the source in the grid", unit="m")
    shear_modulus: float = parameter(meaning="shear modulus of the ground", unit="Pa", above=0)

    def velocity(self, position: Floats) -> Floats:
        """Velocity of the ground over that of the body at positions, dimensionless, [..., 2]."""
        x, distance = self._seen_from_source(position)
        return 0.25 * self.radius**2 * x / distance[..., None] ** 3

    def stress_since(self, position: Floats, travel: float) -> Floats:
        """Stress (rr, zz, rz, tt) of soil due to a past travel of the body [m] [Pa], [..., 4].

        Positions are the present ones; above the source they are off the axis.
        """
        return self.stress_from_afar(position) - self.stress_from_afar(_place(position, travel))

    def stress_from_afar(self, position: Floats) -> Floats:
        """The same due to a body that has come from infinitely far above [Pa], shape [..., 4]."""
        x, distance = self._seen_from_source(position)
        r, z = x[..., 0], x[..., 1]
        # Of the two forms of q each is free of cancellation on its side of the source.
        below = z < 0.0
        q = np.empty_like(z)
        q[below] = 1.0 / (distance[below] * (distance[below] - z[below]))
        q[~below] = (1.0 + z[~below] / distance[~below]) / r[~below] ** 2
        lift = z / distance**3
        return self._scale * np.stack([-(q + lift), lift, r / distance**3, q], axis=-1)

    def traction_rate(self, position: Floats) -> Floats:
        """Growth of (stress rr, stress rz) of soil per travel of the body [Pa/m], [..., 2]."""
        x, distance = self._seen_from_source(position)
        r, z = x[..., 0], x[..., 1]
        gradients = [distance**-3 - 3.0 * r**2 / distance**5, -3.0 * r * z / distance**5]
        return self._scale * np.stack(gradients, axis=-1)

    @property
    def _scale(self) -> float:
        """2 G R^2 / 4 [N]."""
        return 0.5 * self.shear_modulus * self.radius**2

    def _seen_from_source(self, position: Floats) -> tuple[Floats, Floats]:
        x = position - np.array([0.0, self.height])
        return x, np.linalg.norm(x, axis=-1)


@dataclass(frozen=True, kw_only=True, eq=False)
class SurroundingGround(Part):
    """The elastic ground below, above and beside a window that travels with a body.

    The inner side of the grid is the axis and the body. The side has the stiffness around an
    infinite cylinder, 2 G / r along r and G / r along z per area, with the dashpots of `FarField`.

    Attributes:
        source: the body as a source.
        grid: that of the scene, or one with the same nodes.
        material: soil of a stiffness ratio of 1.
        from_afar: whether the body has come from infinitely far above; else it starts in
            undisturbed ground, as at the surface.

    Example:
        >>> ground = ConePenetration().build().find(SurroundingGround)
        >>> ground.from_afar, ground.source.radius
        (True, 0.01785)
    """

    needs = (Window,)
    not_beside = ((FarField, ""),)
    source: TravellingSource
    grid: Grid
    material: Material
    strength: float = parameter(
        meaning="undrained shear strength of soil of a strength ratio of 1", unit="Pa", above=0
    )
    from_afar: bool = True

    @cached_property
    def far(self) -> FarField:
        """The medium beside the window: nodes of the side, springs along r, dashpots."""
        return FarField.around(self.grid, self.material)

    @property
    def spring(self) -> Floats:
        """Stiffness of each node of the side along r and z per radian [N/m], [side_count, 2]."""
        return self.far.spring[:, None] * np.array([1.0, 0.5])

    @cached_property
    def side_positions(self) -> Floats:
        """Positions of the nodes of the side [m], shape [side_count, 2]."""
        return self.grid.node_positions[self.far.nodes]

    @cached_property
    def side_areas(self) -> Floats:
        """Area of each per radian [m2], shape [side_count]."""
        modulus = self.material.ground_shear_modulus
        return self.far.spring * self.grid.outer_radius / (2.0 * modulus)

    def check(self, scene: Scene) -> None:
        """Check that the grid is that of the scene."""
        if not np.array_equal(scene.grid.node_positions, self.grid.node_positions):
            raise SceneError("SurroundingGround: grid has other nodes than that of the scene")

    def stress(self, scene: Scene, position: Floats, travel: float) -> Floats:
        """Stress (rr, zz, rz, tt) of elastic ground after a travel of the body [Pa], [..., 4].

        Positions are (r, z) in the grid [m], shape [..., 2]. The in-situ stress is included.
        """
        own = self._stiffness_ratio(scene, position, travel)[..., None]
        before = scene.stress_at_rest_at(_place(position, travel))
        source = self.source
        if self.from_afar:
            return before + own * source.stress_from_afar(position)
        return before + own * source.stress_since(position, travel)

    def stress_at_start(self, scene: Scene, position: Floats) -> Floats:
        """The initial stress, by a source ahead of the body, limited by su [Pa], [..., 4]."""
        plastic_zone = self.source.radius * math.sqrt(self.source.shear_modulus / self.strength)
        height = self.source.height - SOURCE_DISTANCE * plastic_zone
        ahead = replace(self, source=replace(self.source, height=height))
        elastic = ahead.stress(scene, position, 0.0)
        strength = self.strength * scene.material.ratio_at(position, "strength_ratio")
        shear = 0.5 * np.ptp(principal_stresses(elastic), axis=-1)
        mean = (elastic @ ISOTROPIC / 3.0)[..., None] * ISOTROPIC
        return mean + (elastic - mean) / np.maximum(1.0, shear / strength)[..., None]

    def entering_spring(self, scene: Scene, travel: float) -> Floats:
        """Displacement (r, z) of the lowest spring that balances the stress there [m], [2]."""
        lowest = self.side_positions[:1]
        stress = self.stress(scene, lowest, travel)
        spring = self.spring[0] * self._stiffness_ratio(scene, lowest, travel)
        return -(self.side_areas[0] * stress[0, [0, 2]]) / spring

    def enter(self, run: Run, scene: Scene, position: Floats, travel: float) -> None:
        """Give a layer the velocity and the stress of the ground."""
        speed = run.array("window.motion")[1]
        run.assign("layer.velocity", speed * self.source.velocity(position))
        run.assign("layer.stress", self.stress(scene, position, travel))

    def follow(self, run: Run, scene: Scene, travel: float, *, by_a_row: bool) -> None:
        """Move the springs up with the soil beside them, and give them its stiffness."""
        if by_a_row:
            raise_springs(run, lowest=self.entering_spring(scene, travel))
        if scene.material.variation is None:
            return  # the stiffness stays
        own = self._stiffness_ratio(scene, self.side_positions, travel)[:, None]
        run.assign("far_field.spring", own * self.spring)
        run.assign("far_field.dashpot", np.sqrt(own) * self.far.dashpot)

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Give the soil its initial stress."""
        if not self.from_afar:
            return
        soil = plan.initial("particle.mass") > 0.0
        position = plan.initial("particle.position")[soil]
        plan.initial("particle.stress")[soil] = self.stress_at_start(scene, position)

    def add_boundary(self, plan: Plan, scene: Scene) -> None:
        """Add two launches, over the nodes of the side and of the ends."""
        nodes = (scene.grid.node_count,)
        side_flow = self.source.velocity(self.side_positions)
        drawn = self.side_areas[:, None] * self.source.traction_rate(self.side_positions)
        own = self._stiffness_ratio(scene, self.side_positions, 0.0)[:, None]
        before = self.stress_at_start(scene, self.side_positions)[:, [0, 2]]
        at_rest = -(self.side_areas[:, None] * before) / (own * self.spring)
        plan.add_array("far_field.nodes", "int", self.far.nodes, nodes)
        plan.add_array("far_field.spring", "vec2", own * self.spring)
        plan.add_array("far_field.dashpot", "vec2", np.sqrt(own) * self.far.dashpot)
        plan.add_array("far_field.flow", "vec2", side_flow)
        plan.add_array("far_field.drawn", "vec2", side_flow + drawn / self.spring)
        plan.add_array("far_field.displacement", "vec2", at_rest)
        partly = "cell.full_mass" in plan.arrays
        plan.add_launch(_make_moving_side(partly), len(self.far.nodes))
        # The ends come last: a spring in a corner must not move a node of the bottom.
        ends = Fixed.on(self.grid, radial=["bottom", "top"], vertical=["bottom", "top"])
        flow = self.source.velocity(scene.grid.node_positions[ends.nodes])
        plan.add_array("end.nodes", "int", ends.nodes, nodes)
        plan.add_array("end.free", "vec2", ends.free)
        plan.add_array("end.flow", "vec2", (1.0 - ends.free) * flow)
        plan.add_launch(moving_ends, len(ends.nodes))

    def _stiffness_ratio(self, scene: Scene, position: Floats, travel: float) -> Floats:
        return scene.material.ratio_at(_place(position, travel), "stiffness_ratio")


def _place(position: Floats, travel: float) -> Floats:
    """Place in the ground of undisturbed soil at positions in the grid [m], shape [..., 2]."""
    return position - np.array([0.0, travel])


@kernel
def moving_ends(
    offset: int,
    end_nodes: wp.array[int],
    end_free: wp.array[vec2],
    end_flow: wp.array[vec2],
    window_motion: wp.array[real],
    node_velocities: wp.array[vec4],
):
    """Launched over the nodes of bottom and top."""
    k = offset + wp.tid()
    node = end_nodes[k]
    v, V = node_velocities[node], window_motion[1]
    given = wp.cw_mul(end_free[k], vec2(v[0], v[1])) + V * end_flow[k]
    node_velocities[node] = vec4(given[0], given[1], v[2], v[3])


@functools.cache
def _make_moving_side(partly: bool) -> Any:
    """The kernel, launched over the nodes of the side; `partly`: cells may be partly filled."""

    @kernel
    def moving_side(
        offset: int,
        far_field_nodes: wp.array[int],
        far_field_spring: wp.array[vec2],
        far_field_dashpot: wp.array[vec2],
        far_field_flow: wp.array[vec2],
        far_field_drawn: wp.array[vec2],
        node_mass: wp.array[real],
        node_least_mass: wp.array[real],
        time_step: real,
        window_motion: wp.array[real],
        far_field_displacement: wp.array[vec2],
        node_velocities: wp.array[vec4],
    ):
        k = offset + wp.tid()
        node = far_field_nodes[k]
        if node_mass[node] <= zero:
            return
        v, V, w = node_velocities[node], window_motion[1], far_field_displacement[k]
        m = node_mass[node]
        if wp.static(partly):
            m = wp.max(m, two * node_least_mass[node])  # the mass beside full cells
        rate = time_step / m
        c = rate * far_field_dashpot[k]
        pulled = vec2(v[0], v[1]) - rate * wp.cw_mul(far_field_spring[k], w)
        new = wp.cw_div(pulled + V * wp.cw_mul(c, far_field_flow[k]), vec2(one) + c)
        far_field_displacement[k] = w + time_step * (new - V * far_field_drawn[k])
        node_velocities[node] = vec4(new[0], new[1], v[2], v[3])

    return moving_side
