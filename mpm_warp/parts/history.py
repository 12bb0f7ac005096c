"""Where the soil of a run has come from: the place at which each material point entered.

Places are those in the ground: a grid that has travelled down by T sees soil at rest at x + T e_z
where it was seen at x before. With X the place of entry in the ground, u the displacement since,

    u = x - T e_z - X

so nothing has to be added up: a point keeps X, and no step has a kernel for it.
"""

from __future__ import annotations

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.yield_check import add_yield_share
from mpm_warp.parts.plastic_strain import add_plastic_strain, add_plastic_strain_audit
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.scene import Part, Scene

ORIGIN = "particle.origin"
"""The array of the places of entry X [m], shape [slot_count, 2]."""


class History(Part):
    """Points keep where they entered, and add up their plastic shear strain."""

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Add the arrays of the places of entry and of the plastic strain."""
        position = plan.arrays["particle.position"].initial
        assert position is not None
        plan.add_array(ORIGIN, "vec2", position)
        add_plastic_strain(plan)

    def enter(self, run: Run, scene: Scene, position: Floats, travel: float) -> None:
        """The layer keeps where it enters."""
        run.assign("layer.origin", position - np.array([0.0, travel], dtype=position.dtype))

    def add_records(self, plan: Plan, scene: Scene) -> None:
        """Add the record of the plastic strain, and the share of its strength that soil bears."""
        add_plastic_strain_audit(plan, scene.grid, scene.material)
        add_yield_share(plan, scene.material)


def displacement(run: Run, travel: float) -> Floats:
    """Displacement of the point in each slot since it entered [m], shape [slot_count, 2].

    Args:
        run: whose points keep where they entered.
        travel: how far the grid has travelled [m]; 0 where it rests.
    """
    moved: Floats = run.array("particle.position") - run.array(ORIGIN)
    moved[:, 1] -= travel
    return moved
