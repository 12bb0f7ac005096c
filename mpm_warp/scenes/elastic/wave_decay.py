"""What a step does to a wave along a column: its decay and its frequency, by modal analysis.

For small strain a step is linear, and particles stay where they are in their cells. Its unknowns
are the vertical velocities v_p of the particles and v_i of the nodes after the step before, and the
stresses s = (sigma_zz, sigma_rz) of the cells:

    u_i <- sum m_p N_ip v_p / m_i + (S v)_i / max(m_i, 2 M_i)
    v_i <- u_i + dt f_i(s) / max(m_i, M_i), or 0 where the node is held
    v_p <- v_p + sum N_ip (v_i - u_i)
    s   <- s + dt E sum G_i v_i

with the symbols of `mpm_warp.step.momentum`, G_i the velocity gradient that a velocity of the node
makes, E the elastic moduli. These are the rows of a matrix. The eigenvalue that belongs to a wave
is a = |a| exp(i w dt): each step multiplies its amplitude by |a|, its energy by |a|^2, and w is its
angular frequency.
"""

import numpy as np
import scipy  # loads sparse matrices where they are first used: no other scene waits for them

from mpm_warp.grid.fitted import Floats, Grid, Integers, bilinear
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.scene import Scene
from mpm_warp.step.points import seed_rows


def wave_factor(scene: Scene, angular_frequency: float, time_step: float) -> complex:
    """By what a step [s] multiplies the wave whose angular frequency [1/s] is nearest.

    That frequency is w where steps are exact. The soil is on a grid with horizontal rows, moves
    along z alone, and has a mass-matrix correction; nothing acts on it but held nodes.
    """
    near = np.exp(1j * angular_frequency * time_step)
    matrix = step_matrix(scene, time_step)
    # From a given vector, so that the last bit is always the same.
    start = np.ones(matrix.shape[0], dtype=complex)
    (factor,) = scipy.sparse.linalg.eigs(
        matrix, k=1, sigma=near, v0=start, return_eigenvectors=False
    )
    return complex(factor)


def step_matrix(scene: Scene, time_step: float) -> scipy.sparse.csc_array:
    """The matrix of a step, of the unknowns (v_p, v_i, sigma_zz, sigma_rz)."""
    grid, material, fixed = scene.grid, scene.material, scene.find(Fixed)
    seed = seed_rows(grid, grid.row_count, scene.particles_per_side)
    particle_mass = material.density * seed.volume
    share = _shares(grid, seed.position, seed.cell)
    mass = share @ particle_mass
    least_mass = 0.5 * material.density * grid.node_volumes
    free = np.ones(grid.node_count)
    if fixed is not None:
        free[fixed.nodes] = fixed.free[:, 1]

    # At the right and at the upper nodes of a cell +, else -: X and Y of the correction.
    across, up = np.array([-1.0, 1.0, -1.0, 1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    part = (1.0 - scene.particles_per_side**-2.0) / 24.0 * material.density * grid.cell_volumes
    differences = [_by_cell(grid, np.tile(sign, (grid.cell_count, 1))) for sign in (across, up)]
    correction = sum(of.T @ scipy.sparse.diags_array(part) @ of for of in differences)
    pulls = [_by_cell(grid, grid.gradient_integrals[..., axis]) for axis in (1, 0)]

    before_by_particles = (
        scipy.sparse.diags_array(1.0 / mass) @ share @ scipy.sparse.diags_array(particle_mass)
    )
    before_by_nodes = (
        scipy.sparse.diags_array(1.0 / np.maximum(mass, 2.0 * least_mass)) @ correction
    )
    gain = scipy.sparse.diags_array(time_step / np.maximum(mass, least_mass))
    before = [before_by_particles, before_by_nodes, *(0.0 * pull.T for pull in pulls)]
    held = scipy.sparse.diags_array(free)
    after = [
        held @ part
        for part in (before_by_particles, before_by_nodes, *(-gain @ pull.T for pull in pulls))
    ]
    assert isinstance(material, LinearElastic)
    constrained = material.bulk_modulus + 4.0 / 3.0 * material.shear_modulus
    stressing = [
        scipy.sparse.diags_array(time_step * modulus / grid.cell_volumes) @ pull
        for modulus, pull in zip((constrained, material.shear_modulus), pulls, strict=True)
    ]
    rows = [
        [share.T @ (new - old) for new, old in zip(after, before, strict=True)],
        after,
        *([stress @ new for new in after] for stress in stressing),
    ]
    points, cells = (
        scipy.sparse.eye_array(len(particle_mass)),
        scipy.sparse.eye_array(grid.cell_count),
    )
    unchanged = scipy.sparse.block_diag(
        [points, scipy.sparse.csc_array((grid.node_count,) * 2), cells, cells]
    )
    return scipy.sparse.csc_array(scipy.sparse.block_array(rows) + unchanged, dtype=complex)


def _shares(grid: Grid, position: Floats, cell: Integers) -> scipy.sparse.csc_array:
    """Shape functions of the nodes at particles, of shape [node_count, particle_count]."""
    column, row = cell.T
    xi = (position[:, 0] / grid.fitted_radius - grid.columns[column]) / np.diff(grid.columns)[
        column
    ]
    eta = (position[:, 1] - grid.rows[row]) / np.diff(grid.rows)[row]
    values, nodes = bilinear(xi, eta)[0].T, grid.cell_nodes[row * grid.column_count + column]
    particle = np.repeat(np.arange(len(row)), 4)
    shape = (grid.node_count, len(row))
    return scipy.sparse.csc_array((values.ravel(), (nodes.ravel(), particle)), shape=shape)


def _by_cell(grid: Grid, values: Floats) -> scipy.sparse.csc_array:
    """From values of nodes to sums over the nodes of each cell, of shape [cell_count, node_count].

    Each node of a cell is multiplied by its value of `values`, of shape [cell_count, 4].
    """
    cell = np.repeat(np.arange(grid.cell_count), 4)
    shape = (grid.cell_count, grid.node_count)
    return scipy.sparse.csc_array((values.ravel(), (cell, grid.cell_nodes.ravel())), shape=shape)
