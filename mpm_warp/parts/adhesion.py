"""Adhesion of a surface beside soil whose strength changes: it changes with that of the soil.

Symbols: a A greatest adhesive force of a node, k strength of a particle in the cells beside it, k0
that of the material as it starts, without variation, x adhesion ratio of the particle where that
varies, else 1, m mass of the particle.

    a A = (a A)_0 sum m x (k / k0) / sum m

So a rough surface is as rough when the soil beside it is remoulded, or of another layer. Every 16th
step brings the adhesion up to date: in that time soil moves by a small part of a cell.
"""

import functools
from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.kernel_types import kernel, maybe, real, vec2, vec4, zero
from mpm_warp.materials.material import ADHESION_RATIO, Law
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.plan import Plan, ShareRow
from mpm_warp.scene import Scene


def strength_changes(scene: Scene) -> bool:
    """Whether the soil beside a surface changes, or other soil comes, of another strength."""
    material = scene.material
    comes = material.variation is not None and scene.find(MovingGrid) is not None
    return bool(material.state) or comes


def add_changing_adhesion(
    plan: Plan, scene: Scene, *, nodes: Integers, adhesion_forces: Floats
) -> None:
    """Add the launches to the audited step of a complete plan; none where all strength stays.

    `nodes` are those of the surface, in the first column of nodes, and `adhesion_forces` [N] what
    each has beside soil of the strength k0; both of shape [node_count].
    """
    material, row_count = scene.material, scene.grid.row_count
    law = material.law()
    if not (strength_changes(scene) and law.strength is not None and adhesion_forces.any()):
        return
    uniform = replace(material, variation=None)
    at_first = uniform.state_at(np.zeros(4), np.zeros(2)) if law.remembers else np.zeros(1)
    plan.add_array("contact.first_adhesion", "real", adhesion_forces)
    # (m k / k0, m) by row of the first column of cells.
    plan.add_zeros("contact.strength_sum", "vec2", (plan.share_count, row_count))
    plan.audit(
        plan.launch(
            _make_sum_of_strength(law, ADHESION_RATIO in plan.arrays),
            plan.arrays["particle.mass"].shape,
            common=law.properties_type(*material.properties),
            at_first=law.state_type(*at_first),
            contact_strength_sum=ShareRow("contact.strength_sum"),
        ),
        plan.launch(adhesion_beside, len(nodes)),
        plan.launch(clear_strength, (plan.share_count, row_count)),
    )


@functools.cache
def _make_sum_of_strength(law: Law, varies_adhesion: bool) -> Any:
    """The kernel, launched over slots of particles."""

    @kernel
    def sum_of_strength(
        offset: int,
        particle_cell: wp.array[wp.vec2i],
        particle_stress: wp.array[vec4],
        particle_state: maybe(law.state_type),
        particle_mass: wp.array[real],
        particle_adhesion_ratio: maybe(real),
        properties: law.properties_argument,
        common: law.properties_type,
        at_first: law.state_type,
        contact_strength_sum: wp.array[vec2],
    ):
        p = offset + wp.tid()
        cell = particle_cell[p]
        if cell[0] == 0:
            own, remembered = law.of_point(properties, particle_state, p)
            k = law.strength(particle_stress[p], own, remembered)
            k0 = law.strength(vec4(), common, at_first)
            if wp.static(varies_adhesion):
                k *= particle_adhesion_ratio[p]
            m = particle_mass[p]
            wp.atomic_add(contact_strength_sum, cell[1], vec2(m * (k / k0), m))

    return sum_of_strength


@kernel
def adhesion_beside(
    offset: int,
    contact_nodes: wp.array[int],
    contact_first_adhesion: wp.array[real],
    contact_strength_sum: wp.array2d[vec2],
    column_count: int,
    row_count: int,
    contact_adhesion: wp.array[real],
):
    """Launched over the surface's nodes; one without soil keeps what it has."""
    n = offset + wp.tid()
    row = contact_nodes[n] / (column_count + 1)
    sums = vec2()
    for share in range(contact_strength_sum.shape[0]):
        if row > 0:
            sums += contact_strength_sum[share, row - 1]
        if row < row_count:
            sums += contact_strength_sum[share, row]
    if sums[1] > zero:
        contact_adhesion[n] = contact_first_adhesion[n] * (sums[0] / sums[1])


@kernel
def clear_strength(contact_strength_sum: wp.array2d[vec2]):
    """Launched over the sums: (shares, rows)."""
    share, row = wp.tid()
    contact_strength_sum[share, row] = vec2()
