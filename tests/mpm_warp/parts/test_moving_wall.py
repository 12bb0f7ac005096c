"""The wall that moves, and the grid that follows it."""

import dataclasses

import numpy as np
import pytest

from mpm_warp import Fixed, MovingWall, Scene, Simulation
from mpm_warp.plan.plan import SLACK


@pytest.fixture(params=["cavity", "spherical"])
def scene(request: pytest.FixtureRequest) -> Scene:
    """A cavity on a grid of rows or of rays."""
    return request.getfixturevalue(request.param)


def test_the_grid_that_followed_the_wall_is_the_grid_around_it(scene: Scene) -> None:
    """Integrals and volumes brought up to date on the device are those of a new grid."""
    simulation = Simulation(scene)
    simulation.advance(2000)
    radius = simulation.array("wall.motion")[:, 2]
    assert radius[0] > 1.01
    grid = dataclasses.replace(scene.grid, surface_radius=radius.copy())
    integrals = simulation.array("cell.integrals")
    np.testing.assert_allclose(integrals, grid.gradient_integrals, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(simulation.array("cell.volume"), grid.cell_volumes, rtol=1e-9)
    np.testing.assert_array_equal(simulation.array("grid.rows")[:, 3], radius)


def test_soil_beside_the_wall_moves_with_it_and_without_shear(scene: Scene) -> None:
    """Along the normal its velocity is the wall's, across it what it was."""
    simulation = Simulation(dataclasses.replace(scene, time_step_fraction=1e-6))
    simulation.array("wall.motion")[:, 1] = 2.0
    simulation.array("particle.velocity")[:] = [3.0, 7.0]
    simulation.advance(1)
    grid = scene.grid
    nodes = grid.node(0, np.arange(grid.row_count + 1))
    velocity = simulation.array("node.velocities")[nodes, :2]
    if scene.find(Fixed):  # the ends hold it along z
        velocity[:, 1] = 7.0
    normals = grid.surface_normals
    tangents = np.stack([normals[:, 1], -normals[:, 0]], axis=-1)
    np.testing.assert_allclose(np.sum(velocity * normals, axis=1), 2.0, rtol=1e-9)
    across = np.sum(velocity * tangents, axis=1)
    np.testing.assert_allclose(across, tangents @ [3.0, 7.0], rtol=1e-9, atol=1e-9)
    pushed = 2.0 - (3.0 * normals[:, 0] if scene.find(Fixed) else normals @ [3.0, 7.0])
    expected = simulation.array("node.mass")[nodes] * pushed
    np.testing.assert_allclose(simulation.array("wall.impulse"), expected, rtol=1e-6)


def test_a_wall_that_squeezes_its_cells_to_a_half(cavity: Scene) -> None:
    """It goes on with steps that fit them, at the same time to the same place."""
    wall = cavity[MovingWall]
    end = (1.0 + wall.ramp_travel) / wall.speed
    simulation = Simulation(cavity)
    simulation.advance_to(end)
    plan = simulation.plan
    assert plan.time_step < 0.7 * plan.control.first
    critical = plan.control.critical(simulation.array)
    assert plan.control.first > 1.2 * critical
    assert plan.time_step / critical == pytest.approx(cavity.time_step_fraction, rel=SLACK - 1.0)
    assert simulation.time == pytest.approx(end, abs=0.5 * plan.time_step)
    radius = simulation.array("wall.motion")[0, 2]
    assert radius == pytest.approx(2.0, abs=wall.speed * plan.control.first)
