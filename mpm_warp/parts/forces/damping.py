"""A drag against all motion, for states of rest: v <- v / (1 + dt c), with c the rate."""

import functools
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.arguments import POSITIVE, check_number
from mpm_warp.parts.part import Setting
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision


@dataclass(frozen=True)
class Damping:
    """Drag in proportion to momentum, implicit in time.

    Attributes:
        rate: at which all motion dies out, force over momentum c [1/s], > 0.

    Raises:
        SceneError: the rate is not > 0.
    """

    rate: float

    def __post_init__(self) -> None:
        check_number("damping: rate", self.rate, POSITIVE, unit="1/s")

    def add_to(self, plan: Plan, setting: Setting) -> None:
        """Add the launch, over all nodes."""
        plan.add_launch(
            _make_damping(plan.precision), setting.grid.node_count, drag=self.rate * plan.time_step
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
