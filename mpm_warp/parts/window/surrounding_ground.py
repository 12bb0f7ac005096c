"""The ground around a travelling window: it moves as the body in the window moves it.

Bottom and top of the grid have the velocity v of a travelling source, V v at the speed V of the
window. Along the side, spring k and dashpot c of a node act about that motion, per radian and for
each component, A its area and t the growth of the source's traction per way:

    m dv_node/dt = -k w - c (v_node - V v),    dw/dt = v_node - V (v + A t / k)

Where a free surface passes, a node with less mass than beside full cells has as much less of k, c.

Soil that enters at the bottom has the velocity and the stress of the source, and springs that enter
beside it hold that stress. Where the material varies, stress, springs and dashpots are those of the
soil's own stiffness; k and t are in proportion, so that the motion is that of uniform ground.

So a small window has the resistance of a large one: a bottom at rest and a lid would have the
volume of the body flow out between them, which costs pressure.
"""

import functools
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import warp as wp

from mpm_warp.arguments import NOT_NEGATIVE, POSITIVE, check_array, check_nodes
from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats, Grid, Integers
from mpm_warp.materials.material import Material
from mpm_warp.parts.boundaries.far_field import FarField
from mpm_warp.parts.part import Setting
from mpm_warp.parts.window.travelling_source import TravellingSource
from mpm_warp.plan.plan import Plan
from mpm_warp.plan.run import Run
from mpm_warp.precision import Precision


@dataclass(frozen=True, kw_only=True, eq=False)
class SurroundingGround:
    """The elastic ground below, above and beside a window that travels with a body.

    Attributes:
        source: what the body is from afar.
        ends: flat indices of the nodes of bottom and top whose velocity is given, shape
            [end_count].
        free: 1 where the velocity of such a node is free after all, 0 where it is given, shape
            [end_count, 2].
        end_positions: where they are [m], shape [end_count, 2].
        side: flat indices of the nodes on the side, from below to above, shape [side_count].
        side_positions: where they are [m], shape [side_count, 2].
        side_areas: area of each per radian [m2], > 0, shape [side_count].
        spring: stiffness of each along r and z per radian [N/m], > 0, shape [side_count, 2]; where
            the material varies, that of a stiffness ratio of 1.
        dashpot: viscosity of each along r and z per radian [N s/m], >= 0, shape [side_count, 2],
            likewise.

    Raises:
        SceneError: a value is not allowed.
    """

    source: TravellingSource
    ends: Integers
    free: Floats
    end_positions: Floats
    side: Integers
    side_positions: Floats
    side_areas: Floats
    spring: Floats
    dashpot: Floats

    def __post_init__(self) -> None:
        count = np.size(self.side)
        check_array("surroundings: side_areas", self.side_areas, (count,), POSITIVE)
        check_array("surroundings: spring", self.spring, (count, 2), POSITIVE)
        check_array("surroundings: dashpot", self.dashpot, (count, 2), NOT_NEGATIVE)
        for name, nodes in (("end", self.ends), ("side", self.side)):
            positions = getattr(self, f"{name}_positions")
            check_array(f"surroundings: {name}_positions", positions, (np.size(nodes), 2))
        check_array("surroundings: free", self.free, (np.size(self.ends), 2))
        if not np.isin(self.free, (0.0, 1.0)).all():
            raise SceneError("surroundings: free must be 0 or 1")

    @classmethod
    def around(cls, grid: Grid, material: Material, source: TravellingSource) -> Self:
        """The ground around all of a grid whose inner side is the axis and the body.

        Along the side it is that of an endless cylinder, 2 G / r along r and G / r along z for each
        area, with the dashpots of a `FarField`. At the top the radial velocity is free: the body is
        there.
        """
        far = FarField.around(grid, material)
        of_rows = np.ones((grid.row_count + 1, grid.column_count + 1, 2))
        of_rows[0] = 0.0
        of_rows[-1, :, 1] = 0.0
        free = of_rows.reshape(-1, 2)
        ends = np.flatnonzero(free.min(axis=-1) == 0.0)
        return cls(
            source=source,
            ends=ends,
            free=free[ends],
            end_positions=grid.node_positions[ends],
            side=far.nodes,
            side_positions=grid.node_positions[far.nodes],
            side_areas=far.spring * grid.outer_radius / (2.0 * material.shear_modulus),
            spring=far.spring[:, None] * np.array([1.0, 0.5]),
            dashpot=far.dashpot,
        )

    def check(self, setting: Setting) -> None:
        """Check that the grid has the nodes."""
        for name, nodes in (("ends", self.ends), ("side", self.side)):
            check_nodes(f"surroundings: {name}", nodes, setting.grid.node_count)

    def stress(self, setting: Setting, position: Floats, travel: float) -> Floats:
        """Stress (rr, zz, rz, tt) of elastic ground when the body has gone so far [Pa], [..., 4].

        Args:
            setting: the soil, and its stress before the body comes.
            position: (r, z) in the grid [m], shape [..., 2].
            travel: of the body [m], >= 0.
        """
        own = self._stiffness_ratio(setting, position, travel)[..., None]
        before = setting.stress_at_rest_at(_place(position, travel))
        stress: Floats = before + own * self.source.stress_since(position, travel)
        return stress

    def entering_spring(self, setting: Setting, travel: float) -> Floats:
        """Displacement (r, z) of the lowest spring at which it holds the stress there [m], [2]."""
        lowest = self.side_positions[:1]
        stress = self.stress(setting, lowest, travel)
        spring = self.spring[0] * self._stiffness_ratio(setting, lowest, travel)
        displacement: Floats = -(self.side_areas[0] * stress[0, [0, 2]]) / spring
        return displacement

    def follow(self, run: Run, setting: Setting, travel: float) -> None:
        """Springs and dashpots of the side as stiff as the soil that is beside them now."""
        if setting.material.variation is None:
            return  # they are as at the start
        own = self._stiffness_ratio(setting, self.side_positions, travel)[:, None]
        run.assign("far_field.spring", own * self.spring)
        run.assign("far_field.dashpot", np.sqrt(own) * self.dashpot)

    def add_to(self, plan: Plan, setting: Setting) -> None:
        """Add two launches, over the nodes of the side and of the ends.

        Raises:
            SceneError: the scene has no window.
        """
        if plan.find("window.motion") is None:
            raise SceneError("surroundings: not without a window")
        precision, nodes = plan.precision, (setting.grid.node_count,)
        side_flow = self.source.velocity(self.side_positions)
        drawn = self.side_areas[:, None] * self.source.traction_rate(self.side_positions)
        own = self._stiffness_ratio(setting, self.side_positions, 0.0)[:, None]
        before = setting.stress_at_rest_at(self.side_positions)[:, [0, 2]]
        at_rest = -(self.side_areas[:, None] * before) / (own * self.spring)
        plan.add_array("far_field.nodes", "int", self.side, nodes)
        plan.add_array("far_field.spring", "vec2", own * self.spring)
        plan.add_array("far_field.dashpot", "vec2", np.sqrt(own) * self.dashpot)
        plan.add_array("far_field.flow", "vec2", side_flow)
        plan.add_array("far_field.drawn", "vec2", side_flow + drawn / self.spring)
        plan.add_array("far_field.displacement", "vec2", at_rest)
        partly = plan.find("cell.full_mass") is not None
        plan.add_launch(_make_moving_side(partly, precision), len(self.side))
        # After the side: a spring in a corner must not move what the bottom holds.
        plan.add_array("end.nodes", "int", self.ends, nodes)
        plan.add_array("end.free", "vec2", self.free)
        plan.add_array("end.flow", "vec2", self._end_flow)
        plan.add_launch(_make_moving_ends(precision), len(self.ends))

    def _stiffness_ratio(self, setting: Setting, position: Floats, travel: float) -> Floats:
        """Stiffness ratio of undisturbed soil at positions in the grid, shape [...]."""
        return setting.material.stiffness_ratio_at(_place(position, travel))

    @property
    def _end_flow(self) -> Floats:
        """What the velocity of each node of the ends gets beside what is free of it, over V."""
        flow: Floats = (1.0 - self.free) * self.source.velocity(self.end_positions)
        return flow


def _place(position: Floats, travel: float) -> Floats:
    """Where undisturbed soil comes from that is at positions in the grid [m], shape [..., 2]."""
    return position - np.array([0.0, travel])


@functools.cache
def _make_moving_ends(precision: Precision) -> Any:
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4

    @wp.kernel(module=f"mpm_warp.moving_ends.{precision.numpy_name}", enable_backward=False)
    def moving_ends(
        offset: int,
        end_nodes: wp.array(dtype=int),
        end_free: wp.array(dtype=vec2),
        end_flow: wp.array(dtype=vec2),
        window_motion: wp.array(dtype=wp.float64),
        node_velocities: wp.array(dtype=vec4),
    ):
        k = offset + wp.tid()
        node = end_nodes[k]
        v, V = node_velocities[node], real(window_motion[1])
        given = wp.cw_mul(end_free[k], vec2(v[0], v[1])) + V * end_flow[k]
        node_velocities[node] = vec4(given[0], given[1], v[2], v[3])

    return moving_ends


@functools.cache
def _make_moving_side(partly: bool, precision: Precision) -> Any:
    """The kernel, launched over the nodes of the side; `partly`: there may be less soil at some."""
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    zero, two = wp.constant(real(0.0)), wp.constant(real(2.0))
    key = f"{'partly.' if partly else ''}{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.moving_side.{key}", enable_backward=False)
    def moving_side(
        offset: int,
        far_field_nodes: wp.array(dtype=int),
        far_field_spring: wp.array(dtype=vec2),
        far_field_dashpot: wp.array(dtype=vec2),
        far_field_flow: wp.array(dtype=vec2),
        far_field_drawn: wp.array(dtype=vec2),
        node_mass: wp.array(dtype=real),
        node_least_mass: wp.array(dtype=real),
        time_step: real,
        window_motion: wp.array(dtype=wp.float64),
        far_field_displacement: wp.array(dtype=vec2),
        node_velocities: wp.array(dtype=vec4),
    ):
        k = offset + wp.tid()
        node = far_field_nodes[k]
        if node_mass[node] <= zero:
            return
        v, V, w = node_velocities[node], real(window_motion[1]), far_field_displacement[k]
        m = node_mass[node]
        if wp.static(partly):
            m = wp.max(m, two * node_least_mass[node])  # that beside full cells
        rate = time_step / m
        c = rate * far_field_dashpot[k]
        pulled = vec2(v[0], v[1]) - rate * wp.cw_mul(far_field_spring[k], w)
        # The dashpots are implicit.
        new = wp.cw_div(pulled + V * wp.cw_mul(c, far_field_flow[k]), vec2(real(1.0)) + c)
        far_field_displacement[k] = w + time_step * (new - V * far_field_drawn[k])
        node_velocities[node] = vec4(new[0], new[1], v[2], v[3])

    return moving_side
