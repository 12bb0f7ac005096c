"""What only a scene with an audit of energy has: a step to be taken now and then instead."""

from __future__ import annotations

from mpm_warp.parts.energy_kernel import make_kinetic_energy
from mpm_warp.plan.plan import Launch, Plan


def add_energy_audit(plan: Plan) -> None:
    """The step once more, with the kinetic energy after and before the transfers."""
    grid = plan.scene.grid
    energy = plan.add_zeros("transfer.energy", "real", grid.row_count + 1)
    before, after = (
        Launch(
            kernel=make_kinetic_energy(when, plan.precision),
            dim=(grid.row_count + 1,),
            arguments=(grid.column_count, "node.mass", "node.motion", energy),
        )
        for when in ("before", "after")
    )
    update = next(i for i, it in enumerate(plan.step) if "node.least_mass" in it.arrays) + 1
    plan.audited_step = [after, *plan.step[:update], before, *plan.step[update:]]
