"""History of the soil: its place in the ground at entry, and its plastic shear strain.

The place of entry X is a position in the ground. Soil at rest at x in the grid is at x + T e_z
after the grid has travelled down by T. So the displacement u since entry needs no kernel:

    u = x - T e_z - X

Every 16th step also records the plastic shear strain of the soil. Symbols: tau elastic trial
stress, G its shear modulus, sigma stress after the step, dev the deviator. The difference of the
two stresses gives the deviator of the plastic strain, de, and its sum gamma:

    de = dev(tau - sigma) / (2 G),    gamma <- gamma + 16 sqrt(2 de:de)

In pure shear gamma is the plastic engineering shear strain. A step moves a point by a small part of
a cell, so the strain of 16 steps is about 16 times that of one step.
"""

import functools
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import kernel, maybe, real, vec4, vec7
from mpm_warp.materials.elasticity import make_plastic_step
from mpm_warp.materials.material import Law
from mpm_warp.materials.von_mises import j2
from mpm_warp.plan.plan import AUDIT_INTERVAL, Plan, Run
from mpm_warp.scene import Part, Scene

ORIGIN = "particle.origin"
"""Array of the places of entry X [m], shape [slot_count, 2]."""
PLASTIC_STRAIN = "particle.plastic_strain"
"""Array of gamma since entry, shape [slot_count]."""


class History(Part):
    """Points store their place of entry and their plastic shear strain.

    Example:
        >>> scene = GravityColumn().build()
        >>> scene.find(History), scene.with_parts(History()).find(History) is not None
        (None, True)
    """

    def add_to_points(self, plan: Plan, scene: Scene) -> None:
        """Add the arrays of the places of entry and of the plastic strain."""
        plan.add_array(ORIGIN, "vec2", plan.initial("particle.position"))
        plan.add_zeros(PLASTIC_STRAIN, "real", plan.arrays["particle.mass"].shape)

    def enter(self, run: Run, scene: Scene, position: Floats, travel: float) -> None:
        """Store the place of entry of a layer."""
        run.assign("layer.origin", position - np.array([0.0, travel]))

    def add_records(self, plan: Plan, scene: Scene) -> None:
        """Add the record of the plastic strain, and the launch "yield_share" between steps.

        The launch gives the array `yield.share`, the shear stress of each slot over the shear
        strength by the yield function: 1 at yield. There is none where the material never yields.
        """
        law, slots = scene.material.law(), plan.arrays["particle.mass"].shape
        record = plan.launch(_make_record_plastic_strain(law), slots)
        # Here the rates of cells are known, and the stress is still that before the update.
        plan.audit(record, before="grid_to_particles")
        if law.yield_function is not None:
            plan.add_zeros("yield.share", "real", slots)
            plan.between_steps["yield_share"] = plan.launch(_make_yield_share(law), slots)


def displacement(run: Run, travel: float) -> Floats:
    """Displacement since entry of the point in each slot [m], after a travel of the grid [m]."""
    moved: Floats = run.array("particle.position") - run.array(ORIGIN)
    moved[:, 1] -= travel
    return moved


@functools.cache
def _make_record_plastic_strain(law: Law) -> Any:
    """The kernel, launched over slots of particles."""
    plastic_step = make_plastic_step(law)
    steps = wp.constant(real(AUDIT_INTERVAL))

    @kernel
    def record_plastic_strain(
        offset: int,
        particle_cell: wp.array[wp.vec2i],
        particle_stress: wp.array[vec4],
        particle_state: maybe(law.state_type),
        cell_motion: wp.array[vec7],
        column_count: int,
        time_step: real,
        properties: law.properties_argument,
        particle_plastic_strain: wp.array[real],
    ):
        p = offset + wp.tid()
        cell = particle_cell[p]
        if cell[0] < 0:
            return
        own, remembered = law.of_point(properties, particle_state, p)
        motion = cell_motion[cell[1] * column_count + cell[0]]
        _, relaxed, moduli = plastic_step(particle_stress[p], motion, time_step, own, remembered)
        particle_plastic_strain[p] += steps * wp.sqrt(j2(relaxed)) / moduli[0]

    return record_plastic_strain


@functools.cache
def _make_yield_share(law: Law) -> Any:
    """The kernel, launched over slots of particles, empty ones too."""

    @kernel
    def yield_share(
        particle_stress: wp.array[vec4],
        particle_state: maybe(law.state_type),
        properties: law.properties_argument,
        yield_share: wp.array[real],
    ):
        p = wp.tid()
        own, remembered = law.of_point(properties, particle_state, p)
        measured = law.yield_function(particle_stress[p], own, remembered)
        yield_share[p] = measured[0] / measured[1]

    return yield_share
