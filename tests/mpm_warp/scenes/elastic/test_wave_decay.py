"""The modal analysis of a step, against the simulator and against all eigenvalues."""

import numpy as np
import pytest

from mpm_warp import ElasticColumnWave, Scene, Simulation
from mpm_warp.scenes.elastic.column_wave import PERIOD
from mpm_warp.scenes.elastic.wave_decay import step_matrix, wave_factor

CELLS = 5
SMALL = 1e-9
"""Velocity over that of waves: what is not linear is of second order in it."""


@pytest.fixture
def column() -> Scene:
    return ElasticColumnWave(cell_count=CELLS).build()


def test_the_matrix_is_the_step_of_the_simulator(column: Scene) -> None:
    """For any velocities of the particles, step by step, in every unknown."""
    simulation = Simulation(column)
    count = simulation.particle_count
    speed = SMALL * column.material.pressure_wave_speed
    along = speed * np.random.default_rng(0).uniform(-1.0, 1.0, count)
    simulation.assign("particle.velocity", np.stack([0.0 * along, along], axis=-1))
    matrix = step_matrix(column, simulation.plan.time_step)
    state = np.concatenate([along, np.zeros(matrix.shape[0] - count)])
    nodes = slice(count, count + column.grid.node_count)
    stress_scale = column.material.density * column.material.pressure_wave_speed * speed
    for _ in range(5):
        simulation.advance(1)
        state = (matrix @ state).real
        velocity = simulation.array("particle.velocity")[:, 1]
        np.testing.assert_allclose(state[:count], velocity, atol=1e-8 * speed)
        at_nodes = simulation.array("node.velocities")[:, 1]
        np.testing.assert_allclose(state[nodes], at_nodes, atol=1e-8 * speed)
        stress = simulation.array("particle.stress").reshape(CELLS, 4, 4)
        for component, first in ((1, nodes.stop), (2, nodes.stop + CELLS)):
            of_cells = state[first : first + CELLS]
            np.testing.assert_allclose(stress[:, 0, component], of_cells, atol=1e-8 * stress_scale)


def test_the_factor_is_an_eigenvalue_and_none_is_beyond_one(column: Scene) -> None:
    time_step = Simulation(column).plan.time_step
    factors = np.linalg.eigvals(step_matrix(column, time_step).toarray())
    frequency = 2.0 * np.pi / PERIOD
    factor = wave_factor(column, frequency, time_step)
    assert np.abs(factors - factor).min() < 1e-9
    assert np.angle(factor) / (frequency * time_step) == pytest.approx(1.0, rel=0.02)
    # Of soil at rest some factors are 1: stresses in balance, and motion that no node sees.
    assert np.abs(factors).max() < 1.0 + 1e-6
    assert abs(factor) < 1.0
