"""The infinite elastic medium beyond the outer radius of the grid: springs and dashpots.

Spring k and dashpots c of a node, per radian, w its radial displacement; the dashpots implicit:

    m dv/dt = -k w - c v,    dw/dt = v_r
"""

import functools
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import warp as wp

from mpm_warp.arguments import NOT_NEGATIVE, check_array, check_nodes
from mpm_warp.grid.fitted import Floats, Grid, Integers
from mpm_warp.materials.material import Material
from mpm_warp.parts.part import Setting
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision

QUIET_SPEED_RATIO = 3.3
"""Speed of pressure waves over that of shear waves at a Poisson's ratio of 0.45."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FarField:
    """The infinite elastic medium beyond the outer radius of the grid.

    Statically a spring of 2 G / r per area (the elastic cavity, u = p r / 2 G); for waves the quiet
    dashpots rho c of Lysmer & Kuhlemeyer (1969, J. Eng. Mech. Div. 95(4):859-877). They resist flow
    that never stops too, in proportion to c; so the speed of the pressure waves is taken as at most
    `QUIET_SPEED_RATIO` times that of the shear waves. In clay that hardly changes its volume it is
    more, and part of these waves comes back.

    Attributes:
        nodes: flat indices of the nodes on the side, from below to above, shape [node_count].
        spring: stiffness of each node per radian [N/m], >= 0, shape [node_count].
        dashpot: viscosity of each node along r and z per radian [N s/m], >= 0,
            shape [node_count, 2].

    Raises:
        SceneError: a value is not allowed.
    """

    nodes: Integers
    spring: Floats
    dashpot: Floats

    def __post_init__(self) -> None:
        count = np.size(self.nodes)
        check_array("far_field: spring", self.spring, (count,), NOT_NEGATIVE)
        check_array("far_field: dashpot", self.dashpot, (count, 2), NOT_NEGATIVE)

    def check(self, setting: Setting) -> None:
        """Check that the grid has the nodes."""
        check_nodes("far_field: nodes", self.nodes, setting.grid.node_count)

    @classmethod
    def around(cls, grid: Grid, material: Material) -> Self:
        """The medium around all of the grid's outer side."""
        half_heights = 0.5 * np.diff(grid.rows)
        heights = np.append(half_heights, 0.0) + np.insert(half_heights, 0, 0.0)
        area = grid.outer_radius * heights
        shear_speed = material.shear_wave_speed
        quiet_speed = min(material.pressure_wave_speed, QUIET_SPEED_RATIO * shear_speed)
        speeds = np.array([quiet_speed, shear_speed])
        return cls(
            nodes=grid.node(grid.column_count, np.arange(grid.row_count + 1)),
            spring=2.0 * material.shear_modulus / grid.outer_radius * area,
            dashpot=material.density * area[:, None] * speeds,
        )

    def add_to(self, plan: Plan, setting: Setting) -> None:
        """Add the launch, over the nodes of the side."""
        count = len(self.nodes)
        plan.add_array("far_field.nodes", "int", self.nodes, (setting.grid.node_count,))
        plan.add_array("far_field.spring", "real", self.spring)
        plan.add_array("far_field.dashpot", "vec2", self.dashpot)
        plan.add_zeros("far_field.displacement", "real", count)
        plan.add_launch(_make_far_field(plan.precision), count)


@functools.cache
def _make_far_field(precision: Precision) -> Any:
    real, vec2, vec4 = precision.real, precision.vec2, precision.vec4
    zero, one = wp.constant(real(0.0)), wp.constant(real(1.0))

    @wp.kernel(module=f"mpm_warp.far_field.{precision.numpy_name}", enable_backward=False)
    def far_field(
        offset: int,
        far_field_nodes: wp.array(dtype=int),
        far_field_spring: wp.array(dtype=real),
        far_field_dashpot: wp.array(dtype=vec2),
        node_mass: wp.array(dtype=real),
        time_step: real,
        far_field_displacement: wp.array(dtype=real),
        node_velocities: wp.array(dtype=vec4),
    ):
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

    return far_field
