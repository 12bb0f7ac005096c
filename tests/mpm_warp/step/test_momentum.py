"""The momentum equation of the nodes: what it keeps, and what bounds it."""

import numpy as np
import pytest

from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


def test_a_node_with_hardly_any_mass_is_accelerated_as_if_half_full(floating: Scene) -> None:
    """All particles but a speck of mass are gone from one cell; its stress still pulls."""
    simulation = Simulation(floating)
    simulation.array("particle.stress")[:, :2] = 1e3
    in_first_cell = (simulation.array("particle.cell") == [0, 0]).all(axis=1)
    simulation.array("particle.mass")[in_first_cell] *= 1e-9
    simulation.advance(1)
    grid, step = floating.grid, simulation.plan.time_step
    pull = 1e3 * np.abs(grid.gradient_integrals[0, 0, :2]).sum()
    bound = step * pull / (0.5 * floating.material.density * grid.node_volumes[0])
    assert 0.0 < np.abs(simulation.array("node.velocities")[0, :2]).max() <= bound


def test_momentum_along_the_axis_is_kept_while_waves_run(floating: Scene) -> None:
    simulation = Simulation(floating)
    random = np.random.default_rng(2)
    velocity = random.normal(size=simulation.array("particle.velocity").shape)
    simulation.assign("particle.velocity", velocity)
    mass = simulation.array("particle.mass")
    before = mass @ velocity[:, 1]
    simulation.advance(50)
    after = mass @ simulation.array("particle.velocity")[:, 1]
    assert after == pytest.approx(before, abs=1e-12 * mass.sum())


def test_the_force_on_a_node_is_minus_the_divergence_of_the_stress_around_it(
    floating: Scene,
) -> None:
    """From rest, f = - sum over cells (srr Gr + srz Gz + stt Gt, srz Gr + szz Gz)."""
    simulation = Simulation(floating)
    grid = floating.grid
    of_cells = 1e3 * np.random.default_rng(7).normal(size=(grid.cell_count, 4))
    column, row = simulation.array("particle.cell").T
    simulation.array("particle.stress")[:] = of_cells[row * grid.column_count + column]
    simulation.advance(1)
    rr, zz, rz, tt = of_cells.T[..., None]
    r, z, hoop = np.moveaxis(grid.gradient_integrals, -1, 0)
    force = np.zeros((grid.node_count, 2))
    pull = np.stack([rr * r + rz * z + tt * hoop, rz * r + zz * z], axis=-1)
    np.add.at(force, grid.cell_nodes, -pull)
    impulse = simulation.array("node.mass")[:, None] * simulation.array("node.velocities")[:, :2]
    expected = simulation.plan.time_step * force
    np.testing.assert_allclose(impulse, expected, atol=1e-12 * np.abs(expected).max())


def test_a_velocity_beyond_all_reason_is_left_out_of_the_step(floating: Scene) -> None:
    """The particle that gave it is for the watch to find; the others go on."""
    simulation = Simulation(floating)
    simulation.array("particle.velocity")[0] = 1e30
    simulation.advance(1)
    assert np.isfinite(simulation.array("node.velocities")).all()
    assert np.abs(simulation.array("node.velocities")).max() == 0.0
