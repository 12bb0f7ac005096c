"""The material points (particles) of a run: arrays of all that they carry.

A slot of these arrays holds a particle in the grid, or none: its cell is then (-1, -1). Every array
called `particle.*` belongs to the particles: what enters through a window, and what moves, brings
all of them along, whichever they are.
"""

from collections.abc import Callable

import numpy as np

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.seeding import seed_rows
from mpm_warp.materials.material import ADHESION_RATIO, PROPERTIES, Material
from mpm_warp.plan.launch import share_bounds
from mpm_warp.plan.plan import Plan


def add_points(
    plan: Plan,
    grid: Grid,
    material: Material,
    *,
    particles_per_side: int,
    spare_fraction: float,
    stress_at: Callable[[Floats], Floats],
) -> None:
    """Seed the grid with particles at rest.

    Args:
        plan: of the run.
        grid: every cell that it says holds soil is filled.
        material: of the soil.
        particles_per_side: along each side of a cell, >= 1.
        spare_fraction: empty slots over the number of particles, dimensionless, >= 0.
        stress_at: gives their stress (rr, zz, rz, tt) [Pa], [..., 4], by place [m], [..., 2].
    """
    seed = seed_rows(grid, 0, grid.row_count, particles_per_side)
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
    stress = stress_at(position)
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
