"""The material points (particles) of a run: initial values, arrays, transfer to the grid.

Every array `particle.*` has one entry for each slot. A slot holds a particle, or is empty; the cell
of an empty slot is (-1, -1). A particle that enters through a window fills its slot in all arrays.

Stage 1: particles add mass and momentum to nodes, and stress to cells.

Symbols: m mass, v velocity, sigma stress, N_i shape function of node i at the particle.

    m_i       = sum m N_i
    (m v)_i   = sum m N_i v
    sigma_c   = sum m sigma / sum m            the mean over the cell; stage 2 divides
"""

import functools
from typing import Any, NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.errors import SceneError
from mpm_warp.fields.checks import check_array
from mpm_warp.grid.fitted import GAUSS_POINTS, Floats, Grid, Integers
from mpm_warp.grid.location import make_location
from mpm_warp.kernel_types import kernel, one, real, vec2, vec3, vec4, vec5, zero
from mpm_warp.materials.material import ADHESION_RATIO, PROPERTIES
from mpm_warp.plan.launch import ShareRow, share_bounds
from mpm_warp.plan.plan import Plan
from mpm_warp.scene import Scene


class Seed(NamedTuple):
    """Particles at the start, each of which represents a part of its cell."""

    position: Floats  # centroids (r, z) of the parts [m], shape [particle_count, 2]
    volume: Floats  # volumes of the parts per radian [m3], shape [particle_count]
    cell: Integers  # column and row of the cell, shape [particle_count, 2]


def seed_rows(grid: Grid, row_count: int, particles_per_side: int) -> Seed:
    """Particles that fill the lowest rows of cells, as far as there is soil.

    They are at the centroids of their parts. So the mass of each node is the exact integral of its
    shape function in upright cells; beside a cone, where cells lean, it is so within 0.2 %.
    Particles are ordered by layer, then by radius.
    """
    # Row by row, because their Gauss points take ten times the memory of the particles.
    rows = [_seed_row(grid, row, particles_per_side) for row in range(row_count)]
    return Seed(*map(np.concatenate, zip(*rows, strict=True)))


def _seed_row(grid: Grid, number: int, particles_per_side: int) -> Seed:
    n = particles_per_side
    row, layer, column, across = (
        axis.ravel().astype(np.int32)
        for axis in np.meshgrid(
            [number], np.arange(n), np.arange(grid.column_count), np.arange(n), indexing="ij"
        )
    )
    gauss_xi, gauss_eta = (g.ravel() for g in np.meshgrid(GAUSS_POINTS, GAUSS_POINTS))
    xi = (across[:, None] + gauss_xi) / n
    eta = (layer[:, None] + gauss_eta) / n
    points = grid.place(column[:, None], row[:, None], xi, eta)
    volumes = grid.jacobian(column[:, None], row[:, None], xi, eta) / (4 * n * n)
    volume = volumes.sum(axis=1)
    position = np.sum(points * volumes[..., None], axis=1) / volume[:, None]
    soil = np.all(position < [grid.soil_radius, grid.ground_level], axis=1)
    return Seed(position[soil], volume[soil], np.stack([column, row], axis=-1)[soil])


def add_points(plan: Plan, scene: Scene, *, spare_fraction: float) -> None:
    """Add particles at rest with their properties and initial state.

    `spare_fraction` is the number of empty slots over that of particles, >= 0.
    """
    material = scene.material
    _add_seed(plan, scene, spare_fraction)
    position = plan.initial("particle.position")
    if material.variation is not None:
        properties, count = material.properties_at(position), len(material.properties)
        check_array(f"{type(material).__name__}.properties_at", properties, (len(position), count))
        plan.add_array(PROPERTIES, f"vec{count}", properties)
        if material.variation.adhesion_ratio is not None:
            plan.add_array(ADHESION_RATIO, "real", material.ratio_at(position, "adhesion_ratio"))
    if material.state:
        state = material.state_at(plan.initial("particle.stress"), position)
        count = len(material.state)
        check_array(f"{type(material).__name__}.state_at", state, (len(position), count))
        plan.add_array("particle.state", f"vec{count}", state)
    common = material.law().properties_type(*material.properties)
    plan.given["properties"] = common if material.variation is None else PROPERTIES


def _add_seed(plan: Plan, scene: Scene, spare_fraction: float) -> None:
    """Add the arrays of all particles, one after the other to save memory."""
    grid, density = scene.grid, scene.material.density
    seed = seed_rows(grid, grid.row_count, scene.particles_per_side)
    count = plan.particle_count = len(seed.volume)
    if count == 0:
        raise SceneError(
            "no material point is in the grid: its ground_level or its soil_radius is below the "
            "first"
        )
    slots = count + round(spare_fraction * count)
    # Empty slots are at the end of each share, so that all shares have equal work.
    bounds = share_bounds(count, plan.share_count)
    shift = share_bounds(slots, plan.share_count) - bounds
    taken = np.arange(count) + np.repeat(shift[:-1], np.diff(bounds))

    def in_slots(values: NDArray[Any], empty: float) -> NDArray[Any]:
        array = np.full((slots, *values.shape[1:]), empty, dtype=values.dtype)
        array[taken] = values
        return array

    plan.add_array("particle.position", "vec2", in_slots(seed.position, grid.outer_radius))
    plan.add_zeros("particle.velocity", "vec2", slots)
    position = plan.initial("particle.position")
    plan.add_array("particle.stress", "vec4", scene.stress_at_rest_at(position))
    plan.add_array("particle.mass", "real", in_slots(density * seed.volume, 0.0), least=0.0)
    cell, counts = in_slots(seed.cell, -1), (grid.column_count, grid.row_count)
    plan.add_array("particle.cell", "vec2i", cell, counts, may_be_none=spare_fraction > 0.0)


def add_particles_to_grid(plan: Plan, grid: Grid, *, has_empty_slots: bool) -> None:
    """Add the stage with its sums, and the places of rows and columns."""
    width = np.append(np.diff(grid.columns), 1.0)
    height = np.append(np.diff(grid.rows), 1.0)
    lean = np.append(np.diff(grid.surface_radius), 0.0)
    columns = np.stack([grid.columns, width, 1.0 / width], axis=-1)
    rows = np.stack([grid.rows, height, 1.0 / height, grid.surface_radius, lean], axis=-1)
    plan.add_array("grid.columns", "vec3", columns)
    plan.add_array("grid.rows", "vec5", rows)
    plan.add_zeros("cell.stress_sum", "vec4", (plan.share_count, grid.cell_count))
    plan.add_zeros("cell.mass", "real", (plan.share_count, grid.cell_count))
    plan.add_zeros("node.momentum", "vec4", (plan.share_count, grid.node_count))
    plan.add_launch(
        _make_particles_to_grid(grid.polar, has_empty_slots),
        plan.arrays["particle.mass"].shape,
        node_momentum=ShareRow("node.momentum"),
        cell_stress_sum=ShareRow("cell.stress_sum"),
        cell_mass=ShareRow("cell.mass"),
    )


@functools.cache
def _make_particles_to_grid(polar: bool, has_empty_slots: bool) -> Any:
    """The kernel, launched over slots of particles."""
    natural = make_location(polar).natural

    @wp.func
    def share(m: real, v: vec2) -> vec4:
        # (mass, momentum, 0): four numbers are added in one instruction.
        return vec4(m, m * v[0], m * v[1], zero)

    @kernel
    def particles_to_grid(
        offset: int,
        particle_position: wp.array[vec2],
        particle_velocity: wp.array[vec2],
        particle_stress: wp.array[vec4],
        particle_mass: wp.array[real],
        particle_cell: wp.array[wp.vec2i],
        grid_columns: wp.array[vec3],
        grid_rows: wp.array[vec5],
        fitted_radius: real,
        column_count: int,
        node_momentum: wp.array[vec4],
        cell_stress_sum: wp.array[vec4],
        cell_mass: wp.array[real],
    ):
        p = offset + wp.tid()
        cell = particle_cell[p]
        i, j = cell[0], cell[1]
        if wp.static(has_empty_slots):
            if i < 0:
                return
        where = natural(particle_position[p], grid_columns[i], grid_rows[j], fitted_radius)
        xi, eta = where[0], where[1]
        m = particle_mass[p]

        c = j * column_count + i
        wp.atomic_add(cell_stress_sum, c, m * particle_stress[p])
        wp.atomic_add(cell_mass, c, m)

        v = particle_velocity[p]
        node = j * (column_count + 1) + i
        upper = node + column_count + 1
        wp.atomic_add(node_momentum, node, share((one - xi) * (one - eta) * m, v))
        wp.atomic_add(node_momentum, node + 1, share(xi * (one - eta) * m, v))
        wp.atomic_add(node_momentum, upper, share((one - xi) * eta * m, v))
        wp.atomic_add(node_momentum, upper + 1, share(xi * eta * m, v))

    return particles_to_grid
