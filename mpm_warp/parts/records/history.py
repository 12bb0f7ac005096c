"""Where the soil of a run has come from: the place at which each material point entered.

Places are those in the ground: a grid that has travelled down by T sees soil at rest at x + T e_z
where it was seen at x before. With X the place of entry in the ground, u the displacement since,

    u = x - T e_z - X

so nothing has to be added up: a point keeps X, and no step has a kernel for it.
"""

from __future__ import annotations

import numpy as np

from mpm_warp.grid.fitted import Floats
from mpm_warp.plan.plan import Plan
from mpm_warp.plan.run import Run

ORIGIN = "particle.origin"
"""The array of the places of entry X [m], shape [slot_count, 2]."""


def add_origin(plan: Plan) -> None:
    """Add the array of the places of entry, when the plan has its points."""
    position = plan.arrays["particle.position"].initial
    assert position is not None
    plan.add_array(ORIGIN, "vec2", position)


def note_origin(run: Run, position: Floats, travel: float) -> None:
    """Record where a layer of soil enters, before it does; nothing where points do not keep it.

    Args:
        run: whose window lets the layer in.
        position: where its points are in the grid [m], shape [point_count, 2].
        travel: how far the grid has travelled [m].
    """
    if run.plan.find("layer.origin"):
        run.assign("layer.origin", position - np.array([0.0, travel], dtype=position.dtype))


def displacement(run: Run, travel: float) -> Floats:
    """Displacement of the point in each slot since it entered [m], shape [slot_count, 2].

    Args:
        run: whose points keep where they entered.
        travel: how far the grid has travelled [m]; 0 where it rests.
    """
    moved: Floats = run.array("particle.position") - run.array(ORIGIN)
    moved[:, 1] -= travel
    return moved
