"""Energy audit: every 16th step also records the kinetic energy that the transfers change.

Recorded before a step, for the velocities v that the last one has left, and after its momentum
equation, for the velocities u before it: only the transfer to particles and back lies between.

    E <- E + sum over a row of m u.u / 2        before the step
    E <- E - sum over a row of m v.v / 2        after the one before it
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.plan.plan import Plan
from mpm_warp.precision import Precision
from mpm_warp.scene import Part, Scene


class EnergyAudit(Part):
    """Samples what energy the transfers create or dissipate."""

    def add_records(self, plan: Plan, scene: Scene) -> None:
        """Add an audited step.

        The array "transfer.energy" adds up what each row of nodes has gained in these steps [J].
        """
        grid = scene.grid
        plan.add_zeros("transfer.energy", "real", grid.row_count + 1)
        before, after = (
            plan.launch(
                _make_kinetic_energy(when, plan.precision),
                grid.row_count + 1,
                column_count=grid.column_count,
            )
            for when in ("before", "after")
        )
        plan.audit_first(after)
        plan.audit_after("momentum", before)


@functools.cache
def _make_kinetic_energy(when: str, precision: Precision) -> Any:
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
        node_mass: wp.array(dtype=real),
        node_velocities: wp.array(dtype=vec4),
        transfer_energy: wp.array(dtype=real),
    ):
        j = wp.tid()
        total = real(0.0)
        for i in range(column_count + 1):
            node = j * (column_count + 1) + i
            v = node_velocities[node]
            total += node_mass[node] * (
                v[wp.static(first)] * v[wp.static(first)]
                + v[wp.static(first + 1)] * v[wp.static(first + 1)]
            )
        transfer_energy[j] = transfer_energy[j] + real(0.5 * wp.static(sign)) * total

    return kinetic_energy
