"""From nodes to particles and back: nothing is made greater, whatever the particles' places."""

import numpy as np
import pytest

from mpm_warp import Grid, LinearElastic, Scene, Simulation
from mpm_warp.grid.fitted import Floats
from mpm_warp.sampling import soil_scene
from tests.mpm_warp.conftest import cells_of

ROUNDING = 1e-7
"""Of what is found from many random motions by least squares."""
SOFT = LinearElastic(shear_modulus=1.0, poissons_ratio=0.3, density=1000.0)


def still(grid: Grid, particles_per_side: int) -> Simulation:
    """Soil in which nothing moves by much in a step."""
    return Simulation(
        Scene(
            grid=grid, material=SOFT, particles_per_side=particles_per_side, time_step_fraction=1e-9
        )
    )


def shifted(simulation: Simulation, up: float) -> tuple[Floats, Floats]:
    """Shift the particles by a share of a cell's height, within each cell.

    Returns:
        Shape functions of the nodes at them, [particle_count, node_count], and their masses.
    """
    grid = soil_scene(simulation).grid
    position = simulation.array("particle.position")
    nodes = grid.cell_nodes[cells_of(simulation)]
    corner = grid.node_positions[nodes]
    size = corner[:, 3] - corner[:, 0]
    xi, eta = ((position - corner[:, 0]) / size).T
    eta = (eta + up) % 1.0
    position[:, 1] = corner[:, 0, 1] + eta * size[:, 1]
    shape = np.zeros((len(position), grid.node_count))
    weights = [(1 - xi) * (1 - eta), xi * (1 - eta), (1 - xi) * eta, xi * eta]
    for node, weight in zip(nodes.T, weights, strict=True):
        shape[np.arange(len(position)), node] = weight
    return shape, simulation.array("particle.mass")


def returned_by_correction(simulation: Simulation) -> Floats:
    """The matrix from velocities (z) of the nodes to what they come back with beside particles."""
    before, after = [], []
    velocity = simulation.array("particle.velocity")
    random = np.random.default_rng(3)
    for _ in range(2 * soil_scene(simulation).grid.node_count):
        simulation.array("particle.stress")[:] = 0.0
        velocity[:] = random.normal(size=velocity.shape)
        simulation.advance(1)
        before.append(simulation.array("node.velocities")[:, 1].copy())
        simulation.array("particle.stress")[:] = 0.0
        velocity[:] = 0.0
        simulation.advance(1)
        after.append(simulation.array("node.velocities")[:, 3].copy())
    return np.asarray(np.linalg.lstsq(np.array(before), np.array(after), rcond=None)[0].T)


@pytest.mark.parametrize("particles_per_side", [2, 3])
@pytest.mark.parametrize("up", [0.0, 0.1, 0.25, 0.4])
def test_transfers_and_correction_amplify_no_motion(
    rectilinear: Grid, particles_per_side: int, up: float
) -> None:
    """Of no motion more than all: else it grows at any time step."""
    simulation = still(rectilinear, particles_per_side)
    shape, mass = shifted(simulation, up)
    by_particles = (shape * mass[:, None]).T @ shape / (mass @ shape)[:, None]
    whole = by_particles + returned_by_correction(simulation)
    assert np.linalg.eigvals(whole).real.max() <= 1.0 + ROUNDING


@pytest.mark.parametrize("particles_per_side", [2, 3])
@pytest.mark.parametrize("up", [0.0, 0.25])
def test_the_correction_of_a_velocity_that_alternates_upward(
    rectilinear: Grid, particles_per_side: int, up: float
) -> None:
    """k of the mass of all cells around a node over its own: 4 k = 1/2 of 2 x 2 points amid cells.

    It decides on the time step.
    """
    simulation = still(rectilinear, particles_per_side)
    shape, mass = shifted(simulation, up)
    alternating = np.where(np.arange(len(rectilinear.rows)) % 2, 1.0, -1.0)
    alternating = np.repeat(alternating, rectilinear.column_count + 1)
    around = np.zeros(rectilinear.node_count)
    np.add.at(around, rectilinear.cell_nodes, rectilinear.cell_volumes[:, None])
    share = SOFT.density * around * (1.0 - particles_per_side**-2.0) / 6.0
    share /= np.maximum(mass @ shape, SOFT.density * rectilinear.node_volumes)
    returned = alternating * (returned_by_correction(simulation) @ alternating)
    np.testing.assert_allclose(returned, share, atol=ROUNDING)


def test_the_correction_is_symmetric_and_leaves_uniform_motion(rectilinear: Grid) -> None:
    """What it takes from one motion for another, it takes from that for this one."""
    simulation = still(rectilinear, 2)
    matrix = returned_by_correction(simulation)
    full = SOFT.density * rectilinear.node_volumes
    matrix *= np.maximum(simulation.array("node.mass"), full)[:, None]
    np.testing.assert_allclose(matrix, matrix.T, atol=ROUNDING * np.abs(matrix).max())
    np.testing.assert_allclose(matrix.sum(axis=1), 0.0, atol=ROUNDING * np.abs(matrix).max())
    assert np.linalg.eigvalsh(matrix).min() >= -ROUNDING * np.abs(matrix).max()
