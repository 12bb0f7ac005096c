"""What particles give to nodes and cells."""

import dataclasses

import numpy as np

from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


def test_a_linear_velocity_arrives_at_the_nodes_amid_a_regular_lattice(floating: Scene) -> None:
    """v = a + b z on rows of one height: what the particles on either side add cancels."""
    regular = dataclasses.replace(floating.grid, rows=np.array([0.0, 0.5, 1.0, 1.5]))
    simulation = Simulation(dataclasses.replace(floating, grid=regular))
    velocity = simulation.array("particle.velocity")
    velocity[:, 1] = 2.0 + 3.0 * simulation.array("particle.position")[:, 1]
    simulation.advance(1)
    before = simulation.array("node.velocities")[:, 3].reshape(4, -1)
    np.testing.assert_allclose(before[1:-1], [[3.5] * 5, [5.0] * 5], rtol=1e-12)


def test_nodes_have_the_mass_of_the_soil_around_them(floating: Scene) -> None:
    """The integral of their shape functions: exact, as the centroids of upright cells are."""
    simulation = Simulation(floating)
    simulation.advance(1)
    grid = floating.grid
    mass = np.zeros(grid.node_count)
    np.add.at(mass, grid.cell_nodes, nodal_volumes_of_cells(floating))
    expected = floating.material.density * mass
    np.testing.assert_allclose(simulation.array("node.mass"), expected, rtol=1e-12)


def nodal_volumes_of_cells(scene: Scene) -> np.ndarray:
    """Integrals of N r over rectilinear cells for their nodes, [cell_count, 4]."""
    grid = scene.grid
    radius, height = np.moveaxis(grid.node_positions[grid.cell_nodes], -1, 0)
    inner, outer = radius[:, 0], radius[:, 1]
    to_inner = (outer - inner) * (inner / 3.0 + outer / 6.0)
    to_outer = (outer - inner) * (inner / 6.0 + outer / 3.0)
    half = 0.5 * (height[:, 2] - height[:, 0])
    return np.stack([to_inner, to_outer, to_inner, to_outer], axis=-1) * half[:, None]


def test_the_stress_of_a_cell_is_the_mean_of_its_particles_by_mass(floating: Scene) -> None:
    simulation = Simulation(floating)
    random = np.random.default_rng(6)
    stress, mass = simulation.array("particle.stress"), simulation.array("particle.mass")
    stress[:] = random.normal(size=stress.shape)
    mass[:] *= random.uniform(0.5, 2.0, size=mass.shape)
    given, (column, row) = stress.copy(), simulation.array("particle.cell").T.copy()
    simulation.advance(1)
    grid = floating.grid
    cell = row * grid.column_count + column
    expected = np.stack([np.bincount(cell, mass * part) for part in given.T], axis=-1)
    expected /= np.bincount(cell, mass)[:, None]
    np.testing.assert_allclose(simulation.array("cell.stress"), expected, rtol=1e-12, atol=1e-15)
