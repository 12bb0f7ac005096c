"""The weight of the soil: v <- v - dt g e_z, with g the acceleration of gravity."""

import functools
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.arguments import POSITIVE, check_number
from mpm_warp.parts.part import Setting
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision


@dataclass(frozen=True)
class Gravity:
    """Uniform gravity, downward.

    Attributes:
        acceleration: g [m/s2], > 0.

    Raises:
        SceneError: the acceleration is not > 0.
    """

    acceleration: float

    def __post_init__(self) -> None:
        check_number("gravity: acceleration", self.acceleration, POSITIVE, unit="m/s2")

    def add_to(self, plan: Plan, setting: Setting) -> None:
        """Add the launch, over all nodes."""
        plan.add_launch(
            _make_gravity(plan.precision),
            setting.grid.node_count,
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
