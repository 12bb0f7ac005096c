"""Soil that moves along the rays of a polar grid alone: v <- (v . n) n, n along the ray of a node.

This keeps a flow as round as it began. Soil whose stress falls as it is strained would part from
such a flow at the least disturbance: its strain gathers in bands (Rudnicki & Rice 1975, J. Mech.
Phys. Solids 23:371-394).
"""

import functools
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.parts.part import Setting
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision


@dataclass(frozen=True, kw_only=True)
class RadialMotion:
    """All nodes of a polar grid move along their rays; the last of the forces of a scene.

    Raises:
        SceneError: when a scene is made whose grid is not polar.
    """

    def check(self, setting: Setting) -> None:
        """Check that the grid has rays."""
        if not setting.grid.polar:
            raise SceneError("radial motion: the grid is a Grid, must be a PolarGrid")

    def add_to(self, plan: Plan, setting: Setting) -> None:
        """Add the launch, over nodes."""
        grid = setting.grid
        plan.add_array("ray.direction", "vec2", grid.surface_normals)
        plan.add_launch(
            _make_radial_motion(plan.precision), grid.node_count, column_count=grid.column_count
        )


@functools.cache
def _make_radial_motion(precision: Precision) -> Any:
    vec2, vec4 = precision.vec2, precision.vec4

    @wp.kernel(module=f"mpm_warp.radial_motion.{precision.numpy_name}", enable_backward=False)
    def radial_motion(
        offset: int,
        column_count: int,
        ray_direction: wp.array(dtype=vec2),
        node_velocities: wp.array(dtype=vec4),
    ):
        k = offset + wp.tid()
        n = ray_direction[k / (column_count + 1)]
        v = node_velocities[k]
        along = wp.dot(vec2(v[0], v[1]), n)
        node_velocities[k] = vec4(along * n[0], along * n[1], v[2], v[3])

    return radial_motion
