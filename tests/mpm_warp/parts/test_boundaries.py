"""What acts on nodes: loads, gravity, damping, held nodes, the medium beyond the grid, rays."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Grid
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.parts.boundaries import FarField, Fixed, RadialMotion
from mpm_warp.parts.forces import Damping, Gravity, NodalLoad
from mpm_warp.scene import Part, Scene
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import axis_and_ends

ONE = np.ones((1, 2))


def after_a_step(scene: Scene, *parts: Part) -> Simulation:
    """A run of one step from a uniform velocity (3, 7) m/s, so short that no stress matters."""
    short = dataclasses.replace(scene, parts=parts, time_step_fraction=1e-6)
    simulation = Simulation(short)
    simulation.array("particle.velocity")[:] = [3.0, 7.0]
    simulation.advance(1)
    return simulation


def test_gravity_pulls_downward_and_damping_is_implicit_in_time(floating: Scene) -> None:
    """v / (1 + dt c), however large dt c is; alike at all nodes."""
    step = after_a_step(floating).plan.time_step
    damped, pulled = [0.75, 1.75], [3.0, 7.0 - 1e6 * step]
    for part, expected in ((Damping(3.0 / step), damped), (Gravity(1e6), pulled)):
        velocity = after_a_step(floating, part).array("node.velocities")[:, :2]
        np.testing.assert_allclose(velocity, np.tile(expected, (len(velocity), 1)), atol=1e-9)


def test_a_nodal_load_accelerates_its_nodes_by_their_mass(floating: Scene) -> None:
    nodes, forces = np.array([2, 7]), np.array([[1e9, 0.0], [-2e9, 5e8]])
    simulation = after_a_step(floating, NodalLoad(nodes=nodes, forces=forces))
    change = simulation.array("node.velocities")[:, :2] - [3.0, 7.0]
    impulse = simulation.array("node.mass")[:, None] * change
    expected = np.zeros_like(impulse)
    expected[nodes] = simulation.plan.time_step * forces
    np.testing.assert_allclose(impulse, expected, atol=1e-6 * np.abs(expected).max())


def test_a_node_without_soil_is_left_alone(floating: Scene, elastic: LinearElastic) -> None:
    """Not a number there would stay in the far field after soil has come back."""
    far, load = FarField.around(floating.grid, elastic), NodalLoad(nodes=np.array([0]), forces=ONE)
    simulation = Simulation(floating.with_parts(far, load, Gravity(10.0)))
    # All of it is in one cell.
    simulation.array("particle.cell")[:] = [2, 2]
    middle = floating.grid.place(np.array(2), np.array(2), np.array(0.5), np.array(0.5))
    simulation.array("particle.position")[:] = middle
    simulation.assign("far_field.displacement", 1.0)
    simulation.advance(1)
    bare = [0, *far.nodes]
    assert not simulation.array("node.mass")[bare].any()
    np.testing.assert_array_equal(simulation.array("node.velocities")[bare], 0.0)
    np.testing.assert_array_equal(simulation.array("far_field.displacement"), 1.0)


def test_fixed_nodes_are_at_rest_along_what_is_held(floating: Scene, rectilinear: Grid) -> None:
    fixed = axis_and_ends(rectilinear)
    simulation = after_a_step(floating, fixed)
    shape = (rectilinear.row_count + 1, rectilinear.column_count + 1, 4)
    velocity = simulation.array("node.velocities").reshape(shape)[..., :2]
    assert np.all(velocity[0] == 0.0)
    assert np.all(velocity[-1, :, 1] == 0.0)
    assert np.all(velocity[:, 0, 0] == 0.0)
    np.testing.assert_allclose(velocity[1:-1, 1:], np.tile([3.0, 7.0], (2, 4, 1)), rtol=1e-6)


def test_a_far_field_is_that_of_an_elastic_cavity_around_a_round_grid_with_upright_sides(
    rectilinear: Grid, spherical: Scene, elastic: LinearElastic
) -> None:
    """u = p r / 2 G on all of the side: stiffness over area is 2 G / r."""
    far = FarField.around(rectilinear, elastic)
    radius, height = rectilinear.outer_radius, np.ptp(rectilinear.rows)
    area = radius * height
    assert far.spring.sum() == pytest.approx(2.0 * elastic.shear_modulus / radius * area)
    shear = elastic.density * elastic.shear_wave_speed
    pressure = elastic.density * elastic.pressure_wave_speed
    np.testing.assert_allclose(far.dashpot.sum(axis=0), [pressure * area, shear * area])
    np.testing.assert_array_equal(rectilinear.node_positions[far.nodes, 0], radius)
    # Dashpots are no harder than those of soil that may change its volume.
    clay = dataclasses.replace(elastic, poissons_ratio=0.4999)
    dashpot = FarField.around(rectilinear, clay).dashpot
    np.testing.assert_allclose(dashpot[:, 0], 3.3 * dashpot[:, 1], rtol=1e-12)
    for grid in (dataclasses.replace(rectilinear, planar=True), spherical.grid):
        with pytest.raises(SceneError, match=r"FarField.around: not together with"):
            FarField.around(grid, elastic)


def test_the_far_field_pushes_back_like_an_elastic_cavity(cone: Scene) -> None:
    """From rest: m dv / dt = - k u - c v with the dashpot implicit, to rounding."""
    far = cone[FarField]
    simulation = Simulation(cone)
    pushed = 1e-3 * np.linspace(1.0, 2.0, len(far.nodes))
    simulation.assign("far_field.displacement", pushed)
    simulation.advance(1)
    mass, step = simulation.array("node.mass")[far.nodes], simulation.plan.time_step
    expected = -step * far.spring * pushed / (mass + step * far.dashpot[:, 0])
    velocity = simulation.array("node.velocities")[far.nodes, 0]
    np.testing.assert_allclose(velocity, expected, rtol=1e-12)
    moved = simulation.array("far_field.displacement") - pushed
    np.testing.assert_allclose(moved, step * expected, rtol=1e-9)


def test_the_springs_of_the_far_field_rise_with_the_soil(empty: Scene) -> None:
    """After a row of travel each spring is one row higher, and the lowest is undisturbed."""
    # Springs without stiffness, in soil at rest: nothing else changes their displacement.
    limp = dataclasses.replace(empty[FarField], spring=0.0 * empty[FarField].spring)
    simulation = Simulation(empty.with_parts(limp))
    count = simulation.array("far_field.displacement").shape[0]
    simulation.assign("far_field.displacement", np.arange(1.0, count + 1.0))
    simulation.travel_to(float(empty.grid.rows[1] - empty.grid.rows[0]))
    np.testing.assert_array_equal(
        simulation.array("far_field.displacement"), np.arange(float(count))
    )


def test_radial_motion_keeps_the_velocity_along_the_ray(spherical: Scene) -> None:
    """A velocity that is the same everywhere keeps its part along each ray, to rounding."""
    simulation = after_a_step(spherical, RadialMotion(), *spherical.parts)
    velocity = simulation.array("node.velocities")[:, :2].reshape(6, -1, 2)
    rows = spherical.grid.rows
    outward = np.stack([np.sin(rows), np.cos(rows)], axis=-1)
    expected = (outward @ [3.0, 7.0])[:, None] * outward
    beyond_the_wall = velocity[:, 1:]
    np.testing.assert_allclose(
        beyond_the_wall, np.broadcast_to(expected[:, None], beyond_the_wall.shape), atol=1e-9
    )


def test_nodes_along_lines_of_a_grid_are_held(rectilinear: Grid) -> None:
    shape = (rectilinear.row_count + 1, rectilinear.column_count + 1)
    radial, vertical = np.zeros(shape, dtype=bool), np.ones(shape, dtype=bool)
    radial[:, [0, -1]] = radial[[0, -1]] = True
    by_mask = Fixed.where(radial=radial, vertical=vertical)
    by_name = Fixed.on(
        rectilinear, radial=["axis", "side", "bottom", "top"], vertical=["everywhere"]
    )
    np.testing.assert_array_equal(by_name.nodes, by_mask.nodes)
    np.testing.assert_array_equal(by_name.free, by_mask.free)
    with pytest.raises(SceneError, match="Fixed: line = 'left' must be one of bottom, top, side"):
        Fixed.on(rectilinear, radial=["left"])
