"""Loads, gravity, damping and held nodes: what each does to the velocities of the nodes."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Grid
from mpm_warp.parts.forces import Damping, Gravity, NodalLoad
from mpm_warp.scene import Part, Scene
from mpm_warp.simulation import Simulation
from tests.mpm_warp.edges import axis_and_ends


def after_a_step(scene: Scene, *parts: Part) -> Simulation:
    """A run of one step from a uniform velocity (3, 7) m/s, so short that no stress matters."""
    short = dataclasses.replace(scene, parts=parts, time_step_fraction=1e-6)
    simulation = Simulation(short)
    simulation.array("particle.velocity")[:] = [3.0, 7.0]
    simulation.advance(1)
    return simulation


def test_gravity_pulls_downward_alike_on_all_nodes(floating: Scene) -> None:
    simulation = after_a_step(floating, Gravity(1e6))
    change = simulation.array("node.velocities")[:, :2] - [3.0, 7.0]
    expected = [0.0, -1e6 * simulation.plan.time_step]
    np.testing.assert_allclose(change, np.tile(expected, (len(change), 1)), atol=1e-9)


def test_damping_is_implicit_in_time(floating: Scene) -> None:
    """v / (1 + dt c), however large dt c is."""
    step = after_a_step(floating).plan.time_step
    simulation = after_a_step(floating, Damping(3.0 / step))
    velocity = simulation.array("node.velocities")[:, :2]
    np.testing.assert_allclose(velocity, np.tile([0.75, 1.75], (len(velocity), 1)), rtol=1e-9)


def test_a_nodal_load_accelerates_its_nodes_by_their_mass(floating: Scene) -> None:
    nodes, forces = np.array([2, 7]), np.array([[1e9, 0.0], [-2e9, 5e8]])
    simulation = after_a_step(floating, NodalLoad(nodes=nodes, forces=forces))
    change = simulation.array("node.velocities")[:, :2] - [3.0, 7.0]
    impulse = simulation.array("node.mass")[:, None] * change
    expected = np.zeros_like(impulse)
    expected[nodes] = simulation.plan.time_step * forces
    np.testing.assert_allclose(impulse, expected, atol=1e-6 * np.abs(expected).max())


def test_a_node_without_soil_has_neither_load_nor_weight(floating: Scene) -> None:
    """All particles are gone from the cells around the first nodes."""
    load = NodalLoad(nodes=np.array([0]), forces=np.ones((1, 2)))
    simulation = Simulation(floating.with_parts(load, Gravity(10.0)))
    simulation.array("particle.cell")[:] = [2, 2]
    simulation.array("particle.position")[:] = floating.grid.place(
        np.array(2), np.array(2), np.array(0.5), np.array(0.5)
    )
    simulation.advance(1)
    assert simulation.array("node.mass")[0] == 0.0
    np.testing.assert_array_equal(simulation.array("node.velocities")[0], 0.0)


def test_fixed_nodes_are_at_rest_along_what_is_held(floating: Scene, rectilinear: Grid) -> None:
    fixed = axis_and_ends(rectilinear)
    simulation = after_a_step(floating, fixed)
    shape = (rectilinear.row_count + 1, rectilinear.column_count + 1, 4)
    velocity = simulation.array("node.velocities").reshape(shape)[..., :2]
    assert np.all(velocity[0] == 0.0)
    assert np.all(velocity[-1, :, 1] == 0.0)
    assert np.all(velocity[:, 0, 0] == 0.0)
    np.testing.assert_allclose(velocity[1:-1, 1:], np.tile([3.0, 7.0], (2, 4, 1)), rtol=1e-6)


@pytest.mark.parametrize("value", [0.0, -9.81, float("nan")])
def test_a_force_of_nothing_is_refused_in_one_line(value: float) -> None:
    with pytest.raises(
        SceneError, match=r"^Gravity: acceleration = .* m/s2 must be (a finite number )?> 0$"
    ):
        Gravity(value)
    with pytest.raises(
        SceneError, match=r"^Damping: rate = .* 1/s must be (a finite number )?> 0$"
    ):
        Damping(value)
