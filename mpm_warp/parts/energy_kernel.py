"""An audit of the transfer from nodes to particles and back: what kinetic energy it changes.

Launched before a step, for the velocities v that the last one has left, and after its momentum
equation, for the velocities u before it: only the transfer lies between the two.

    E <- E + sum over a row of m u.u / 2        before the step
    E <- E - sum over a row of m v.v / 2        after the one before it
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@functools.cache
def make_kinetic_energy(when: str, precision: Precision) -> Any:
    """The kernel, launched over rows of nodes, each of which keeps its own sum.

    Args:
        when: "before" or "after" a step.
        precision: floating point types.
    """
    real, vec4 = precision.real, precision.vec4
    first, sign = {"before": (2, 1.0), "after": (0, -1.0)}[when]
    key = f"{when}.{precision.numpy_name}"

    @wp.kernel(module=f"mpm_warp.kinetic_energy.{key}", enable_backward=False)
    def kinetic_energy(
        column_count: int,
        mass: wp.array(dtype=real),
        motion: wp.array(dtype=vec4),
        energy: wp.array(dtype=real),
    ):
        j = wp.tid()
        total = real(0.0)
        for i in range(column_count + 1):
            node = j * (column_count + 1) + i
            v = motion[node]
            total += mass[node] * (
                v[wp.static(first)] * v[wp.static(first)]
                + v[wp.static(first + 1)] * v[wp.static(first + 1)]
            )
        energy[j] = energy[j] + real(0.5 * wp.static(sign)) * total

    return kinetic_energy
