"""The material points (particles) of a run: arrays of all that they carry.

A slot of these arrays holds a particle in the grid, or none: its cell is then (-1, -1). Every array
called `particle.*` belongs to the particles: what enters through a window, and what moves, brings
all of them along, whichever they are.
"""

import numpy as np

from mpm_warp.grid.seeding import seed_rows
from mpm_warp.materials.material import ADHESION_RATIO, PROPERTIES
from mpm_warp.plan.launch import share_bounds
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene


def add_points(plan: Plan, scene: Scene, *, spare_fraction: float) -> None:
    """Seed the grid with particles at rest.

    `spare_fraction` is that of empty slots over the number of particles, dimensionless, >= 0.
    """
    grid, material = scene.grid, scene.material
    seed = seed_rows(grid, 0, grid.row_count, scene.particles_per_side)
    plan.particle_count = seed.particle_count
    slots = seed.particle_count + round(spare_fraction * seed.particle_count)
    # Empty slots are at the end of each share, so that all shares have as much to do.
    bounds = share_bounds(seed.particle_count, plan.share_count)
    shift = share_bounds(slots, plan.share_count) - bounds
    taken = np.arange(seed.particle_count) + np.repeat(shift[:-1], np.diff(bounds))
    position = np.full((slots, 2), grid.outer_radius)
    mass = np.zeros(slots)
    cell = np.full((slots, 2), -1, dtype=np.int32)
    position[taken] = seed.position
    mass[taken] = material.density * seed.volume
    cell[taken] = seed.cell
    plan.add_array("particle.position", "vec2", position)
    plan.add_zeros("particle.velocity", "vec2", slots)
    stress = scene.stress_at_rest_at(position)
    plan.add_array("particle.stress", "vec4", stress)
    plan.add_array("particle.mass", "real", mass, least=0.0)
    counts = (grid.column_count, grid.row_count)
    plan.add_array("particle.cell", "vec2i", cell, counts, may_be_none=spare_fraction > 0.0)
    if material.variation is not None:
        properties = material.properties_at(position)
        plan.add_array(PROPERTIES, f"vec{properties.shape[-1]}", properties)
        if material.varies_adhesion:
            ratio = material.variation.adhesion_ratio_at(position)
            plan.add_array(ADHESION_RATIO, "real", ratio)
    if material.state:
        state = material.state_at(stress, position)
        plan.add_array("particle.state", f"vec{len(material.state)}", state)
