"""The strength of the soil beside a surface, which its adhesion follows.

The adhesion follows the strength of the soil. Symbols: k strength of a particle in the cells beside
a node, k0 initial strength of the material, without variation, x adhesion ratio of the particle, 1
where it does not vary, m mass of the particle.

    a A = (a A)_0 sum m x (k / k0) / sum m,     k A likewise, without x

So a rough surface stays rough where the soil beside it is remoulded or of another layer. Every 16th
step updates the adhesion; in 16 steps soil moves by a small part of a cell.
"""

import functools
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import kernel, maybe, one, real, vec3, vec4, zero
from mpm_warp.materials.material import ADHESION_RATIO, Law
from mpm_warp.parts.window import MovingGrid
from mpm_warp.plan.launch import ShareRow
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene

COMPONENTS = {"contact.adhesion": 0, "contact.strength": 1}
"""Components of the sums beside a surface, by the array of forces that follows them."""


def strength_changes(scene: Scene) -> bool:
    """Whether the strength of the soil beside a surface changes during a run."""
    material = scene.material
    comes = material.variation is not None and scene.find(MovingGrid) is not None
    return bool(material.state) or comes


def add_strength_beside(
    plan: Plan, scene: Scene, node_count: int, forces: Mapping[str, Floats]
) -> None:
    """Add the launches by which forces of a surface follow the strength of the soil beside it.

    `forces` are those beside soil of the initial strength [N], each of shape [node_count], by array
    of the plan. Nothing is added if the strength does not change, or all forces are 0.
    """
    material, row_count = scene.material, scene.grid.row_count
    law = material.law()
    following = {name: at_first for name, at_first in forces.items() if at_first.any()}
    if not (strength_changes(scene) and law.strength is not None and following):
        return
    uniform = replace(material, variation=None)
    state = uniform.state_at(np.zeros(4), np.zeros(2)) if law.remembers else np.zeros(1)
    # (m x k / k0, m k / k0, m) by row of the first column of cells.
    plan.add_zeros("contact.strength_sum", "vec3", (plan.share_count, row_count))
    plan.audit(
        plan.launch(
            _make_sum_of_strength(law, ADHESION_RATIO in plan.arrays),
            plan.arrays["particle.mass"].shape,
            common=law.properties_type(*material.properties),
            at_first=law.state_type(*state),
            contact_strength_sum=ShareRow("contact.strength_sum"),
        ),
        *(
            plan.launch(
                follow_strength,
                node_count,
                of=COMPONENTS[name],
                first=plan.add_array(f"{name}_at_first", "real", at_first),
                forces=name,
            )
            for name, at_first in following.items()
        ),
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
        contact_strength_sum: wp.array[vec3],
    ):
        p = offset + wp.tid()
        cell = particle_cell[p]
        if cell[0] == 0:
            own, remembered = law.of_point(properties, particle_state, p)
            k = law.strength(particle_stress[p], own, remembered)
            k0 = law.strength(vec4(), common, at_first)
            x = one
            if wp.static(varies_adhesion):
                x = particle_adhesion_ratio[p]
            m = particle_mass[p]
            ratio = k / k0
            wp.atomic_add(contact_strength_sum, cell[1], vec3(m * (x * ratio), m * ratio, m))

    return sum_of_strength


@kernel
def follow_strength(
    offset: int,
    contact_nodes: wp.array[int],
    of: int,
    first: wp.array[real],
    contact_strength_sum: wp.array2d[vec3],
    column_count: int,
    row_count: int,
    forces: wp.array[real],
):
    """The force of a node follows component `of` of the sums; without soil it stays.

    Launched over the surface's nodes.
    """
    n = offset + wp.tid()
    row = contact_nodes[n] / (column_count + 1)
    sums = vec3()
    for share in range(contact_strength_sum.shape[0]):
        if row > 0:
            sums += contact_strength_sum[share, row - 1]
        if row < row_count:
            sums += contact_strength_sum[share, row]
    if sums[2] > zero:
        forces[n] = first[n] * (sums[of] / sums[2])


@kernel
def clear_strength(contact_strength_sum: wp.array2d[vec3]):
    """Launched over the sums: (shares, rows)."""
    share, row = wp.tid()
    contact_strength_sum[share, row] = vec3()
