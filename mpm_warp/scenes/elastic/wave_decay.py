"""Decay and frequency that a time step gives a wave along a column, by modal analysis.

For small strain a step is linear, and particles keep their places in the cells. The unknowns are
the vertical velocities v_p of the particles and v_i of the nodes after the previous step, and the
stresses s = (sigma_zz, sigma_rz) of the cells:

    u_i <- sum m_p N_ip v_p / m_i + (S v)_i / max(m_i, 2 M_i)
    v_i <- u_i + dt f_i(s) / max(m_i, M_i), or 0 where the node is held
    v_p <- v_p + sum N_ip (v_i - u_i)
    s   <- s + dt E sum G_i v_i

Symbols are those of `mpm_warp.step.momentum`; G_i is the velocity gradient by a unit velocity of a
node, E the elastic moduli. The four lines are the rows of a matrix. The eigenvalue of a wave is
a = |a| exp(i w dt): each step multiplies its amplitude by |a| and its energy by |a|^2, and w is its
angular frequency.
"""

from functools import partial

import numpy as np
import scipy  # loads sparse matrices where they are first used: no other scene waits for them

from mpm_warp.grid.fitted import Floats, Grid, Integers, bilinear
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.scene import Scene
from mpm_warp.step.points import seed_rows


def wave_factor(scene: Scene, angular_frequency: float, time_step: float) -> complex:
    """Eigenvalue a of the wave that is nearest to an exact angular frequency [1/s].

    The scene has a grid with horizontal rows, soil that moves along z only, a mass-matrix
    correction, and no forces but those of fixed nodes.
    """
    near = np.exp(1j * angular_frequency * time_step)
    matrix = step_matrix(scene, time_step)
    # A given start vector makes the result the same to the last bit.
    start = np.ones(matrix.shape[0], dtype=complex)
    (factor,) = scipy.sparse.linalg.eigs(
        matrix, k=1, sigma=near, v0=start, return_eigenvectors=False
    )
    return complex(factor)


def step_matrix(scene: Scene, time_step: float) -> "scipy.sparse.csc_array":
    """The matrix of a step, of the unknowns (v_p, v_i, sigma_zz, sigma_rz)."""
    diagonal, identity = scipy.sparse.diags_array, scipy.sparse.eye_array
    grid, material, fixed = scene.grid, scene.material, scene.find(Fixed)
    seed = seed_rows(grid, grid.row_count, scene.particles_per_side)
    particle_mass = material.density * seed.volume
    share = _shares(grid, seed.position, seed.cell)
    mass = share @ particle_mass
    least_mass = 0.5 * material.density * grid.node_volumes
    free = np.ones(grid.node_count)
    if fixed is not None:
        free[fixed.nodes] = fixed.free[:, 1]

    # X and Y of the correction: +1 at the right and at the upper nodes of a cell, else -1.
    across, up = np.array([-1.0, 1.0, -1.0, 1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    part = (1.0 - scene.particles_per_side**-2.0) / 24.0 * material.density * grid.cell_volumes
    in_cells = partial(_from_nodes, grid, grid.cell_nodes)
    differences = [in_cells(np.tile(sign, (grid.cell_count, 1))) for sign in (across, up)]
    correction = sum(of.T @ diagonal(part) @ of for of in differences)
    pulls = [in_cells(grid.gradient_integrals[..., axis]) for axis in (1, 0)]

    by_velocities = [
        diagonal(1.0 / mass) @ share @ diagonal(particle_mass),
        diagonal(1.0 / np.maximum(mass, 2.0 * least_mass)) @ correction,
    ]
    gain = diagonal(time_step / np.maximum(mass, least_mass))
    before = [*by_velocities, *(0.0 * pull.T for pull in pulls)]
    after = [
        diagonal(free) @ part for part in (*by_velocities, *(-gain @ pull.T for pull in pulls))
    ]
    assert isinstance(material, LinearElastic)
    constrained = material.bulk_modulus + 4.0 / 3.0 * material.shear_modulus
    stressing = [
        diagonal(time_step * modulus / grid.cell_volumes) @ pull
        for modulus, pull in zip((constrained, material.shear_modulus), pulls, strict=True)
    ]
    rows = [
        [share.T @ (new - old) for new, old in zip(after, before, strict=True)],
        after,
        *([stress @ new for new in after] for stress in stressing),
    ]
    points, cells = identity(len(particle_mass)), identity(grid.cell_count)
    no_nodes = scipy.sparse.csc_array((grid.node_count, grid.node_count))
    unchanged = scipy.sparse.block_diag([points, no_nodes, cells, cells])
    return scipy.sparse.csc_array(scipy.sparse.block_array(rows) + unchanged, dtype=complex)


def _shares(grid: Grid, position: Floats, cell: Integers) -> "scipy.sparse.csc_array":
    """Shape functions of the nodes at particles, shape [node_count, particle_count]."""
    column, row = cell.T
    along = position[:, 0] / grid.fitted_radius - grid.columns[column]
    xi = along / np.diff(grid.columns)[column]
    eta = (position[:, 1] - grid.rows[row]) / np.diff(grid.rows)[row]
    nodes = grid.cell_nodes[row * grid.column_count + column]
    return _from_nodes(grid, nodes, bilinear(xi, eta)[0].T).T.tocsc()


def _from_nodes(grid: Grid, nodes: Integers, values: Floats) -> "scipy.sparse.csc_array":
    """Matrix [n, node_count] of sums over four nodes with the weights `values` [n, 4]."""
    row = np.repeat(np.arange(len(nodes)), 4)
    shape = (len(nodes), grid.node_count)
    return scipy.sparse.csc_array((values.ravel(), (row, nodes.ravel())), shape=shape)
