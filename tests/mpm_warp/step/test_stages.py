"""The stages of a step: points, what they give to nodes and cells, momentum, and what they take."""

import dataclasses
import itertools

import numpy as np
import pytest

from mpm_warp import FreeSurface, Grid, Scene, Simulation, Window
from mpm_warp.grid.fitted import nodal_areas
from mpm_warp.plan.launch import share_bounds
from mpm_warp.planning import make_plan
from tests.mpm_warp.conftest import cells_of, nodal_forces


def test_every_share_has_as_many_particles_and_as_many_empty_slots(cone: Scene) -> None:
    """The empty ones at its end, outside every cell and without mass."""
    plan = make_plan(cone)
    cell, mass = (plan.arrays[f"particle.{name}"].initial for name in ("cell", "mass"))
    empty = cell[:, 0] < 0
    assert empty.sum() == round(cone[Window].spare_fraction * plan.particle_count)
    np.testing.assert_array_equal(cell[empty], -1)
    np.testing.assert_array_equal(mass[empty], 0.0)
    bounds = share_bounds(len(cell), plan.share_count)
    taken = [np.count_nonzero(~empty[a:b]) for a, b in itertools.pairwise(bounds)]
    assert np.ptp(taken) <= 1
    for first, count in zip(bounds, taken, strict=False):
        assert not empty[first : first + count].any()


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
    """The integral of N r over rectilinear cells: exact, as the centroids of upright cells are."""
    simulation = Simulation(floating)
    simulation.advance(1)
    heights = np.append(np.diff(floating.grid.rows), 0.0)
    to_rows = 0.5 * (heights + np.roll(heights, 1))
    radius = floating.grid.node_positions[: floating.grid.column_count + 1, 0]
    expected = floating.material.density * np.outer(to_rows, nodal_areas(radius, np.diff(radius)))
    np.testing.assert_allclose(simulation.array("node.mass"), expected.ravel(), rtol=1e-12)


def test_a_cell_at_the_surface_of_the_ground_bears_stress_as_far_as_it_is_filled(
    floating: Scene, fitted: Grid
) -> None:
    """Four particles to a side of a cell; the ground ends half way up a row, below the tip."""
    row = 1
    assert not fitted.surface_radius[: row + 3].any()
    half_up = 0.5 * (fitted.rows[row] + fitted.rows[row + 1])
    ground = dataclasses.replace(fitted, ground_level=half_up)
    scene = dataclasses.replace(floating, grid=ground, particles_per_side=4, parts=(FreeSurface(),))
    simulation = Simulation(scene)
    simulation.array("particle.stress")[:] = [-3.0, -2.0, 1.0, -2.5]
    simulation.advance(1)
    stress = simulation.array("cell.stress").reshape(ground.row_count, -1, 4)
    whole, half, none = (stress[it, ground.column_count // 2] for it in (row - 1, row, row + 1))
    np.testing.assert_allclose(whole, [-3.0, -2.0, 1.0, -2.5], rtol=1e-12)
    # The lower half of a cell with vertical sides is half of its volume.
    np.testing.assert_allclose(half, 0.5 * whole, rtol=1e-9)
    np.testing.assert_array_equal(none, 0.0)


def test_bulk_viscosity_resists_the_change_of_volume(floating: Scene) -> None:
    """By b rho c h div v, with div v of the step before; h is 1 / |mean grad N|."""
    still = dataclasses.replace(floating, time_step_fraction=1e-9)
    simulation = Simulation(dataclasses.replace(still, bulk_viscosity=0.2))
    simulation.array("particle.velocity")[:] = simulation.array("particle.position") * [1.0, -3.0]
    simulation.advance(1)
    simulation.array("particle.stress")[:] = 0.0
    grid, soil = floating.grid, floating.material
    velocity = simulation.array("node.velocities")[grid.cell_nodes]
    r, z, hoop = np.moveaxis(grid.gradient_integrals, -1, 0)
    flux = np.sum(velocity[..., 0] * (r + hoop) + velocity[..., 1] * z, axis=1)
    lengths = grid.cell_volumes / np.sqrt(np.sum(r**2 + z**2, axis=1))
    pressure = 0.2 * soil.density * soil.pressure_wave_speed * lengths * flux / grid.cell_volumes
    simulation.advance(1)
    expected = pressure[:, None] * [1.0, 1.0, 0.0, 1.0]
    stress = simulation.array("cell.stress")
    np.testing.assert_allclose(stress, expected, atol=1e-9 * np.abs(pressure).max())
    assert pressure.min() < 0.0


def test_the_stress_of_a_cell_is_the_mean_of_its_particles_by_mass(floating: Scene) -> None:
    """A cell that is empty for a moment keeps its stress."""
    simulation = Simulation(floating)
    random = np.random.default_rng(6)
    stress, mass = simulation.array("particle.stress"), simulation.array("particle.mass")
    stress[:] = random.normal(size=stress.shape)
    mass[:] *= random.uniform(0.5, 2.0, size=mass.shape)
    given, cell = stress.copy(), cells_of(simulation)
    simulation.advance(1)
    expected = np.stack([np.bincount(cell, mass * part) for part in given.T], axis=-1)
    expected /= np.bincount(cell, mass)[:, None]
    np.testing.assert_allclose(simulation.array("cell.stress"), expected, rtol=1e-12, atol=1e-15)
    place = simulation.array("particle.cell")
    place[(place == [1, 1]).all(axis=1)] = [2, 1]
    stress[:] = 0.0
    simulation.advance(1)
    columns = floating.grid.column_count
    found = simulation.array("cell.stress")
    np.testing.assert_allclose(found[columns + 1], expected[columns + 1], rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(found[columns + 2], 0.0)


def test_the_motion_of_a_cell_is_that_of_its_mean_velocity_gradient(floating: Scene) -> None:
    """Strain dt D, and the spin's rotation after Cayley: tan(angle / 2) = dt (L_rz - L_zr) / 4."""
    simulation = Simulation(floating)
    random = np.random.default_rng(1)
    velocity = random.normal(size=simulation.array("particle.velocity").shape)
    simulation.assign("particle.velocity", velocity)
    simulation.advance(1)
    grid, step = floating.grid, simulation.plan.time_step
    v_r, v_z = np.moveaxis(simulation.array("node.velocities")[grid.cell_nodes, :2], -1, 0)
    r, z, hoop = np.moveaxis(grid.gradient_integrals, -1, 0)
    parts = (v_r * r, v_r * z, v_z * r, v_z * z, v_r * hoop)
    rr, rz, zr, zz, tt = (step * it.sum(axis=1) / grid.cell_volumes for it in parts)
    angle = 2.0 * np.arctan(0.25 * (rz - zr))
    rotation = [np.sin(angle) ** 2, np.sin(2.0 * angle), np.cos(2.0 * angle)]
    expected = np.stack([rr, zz, 0.5 * (rz + zr), tt, *rotation], axis=-1)
    assert np.abs(angle).max() > 1e-3
    np.testing.assert_allclose(simulation.array("cell.motion"), expected, rtol=1e-9, atol=1e-15)


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
    simulation.array("particle.stress")[:] = of_cells[cells_of(simulation)]
    simulation.advance(1)
    impulse = simulation.array("node.mass")[:, None] * simulation.array("node.velocities")[:, :2]
    expected = simulation.plan.time_step * nodal_forces(grid, of_cells)
    np.testing.assert_allclose(impulse, expected, atol=1e-12 * np.abs(expected).max())


def test_a_velocity_beyond_all_reason_is_left_out_of_the_step(floating: Scene) -> None:
    """The particle that gave it is for the watch to find; the others go on."""
    simulation = Simulation(floating)
    simulation.array("particle.velocity")[0] = 1e30
    simulation.advance(1)
    assert np.isfinite(simulation.array("node.velocities")).all()
    assert np.abs(simulation.array("node.velocities")).max() == 0.0


def test_a_rigid_motion_along_the_axis_leaves_no_stress_and_keeps_momentum(floating: Scene) -> None:
    """Of all points: a scene without a window has no slot to spare."""
    simulation = Simulation(floating)
    assert simulation.particle_count == len(simulation.array("particle.mass"))
    simulation.array("particle.velocity")[:, 1] = 0.7
    start = simulation.array("particle.position").copy()
    simulation.advance(20)
    np.testing.assert_allclose(simulation.array("particle.velocity")[:, 1], 0.7, rtol=1e-12)
    risen = simulation.array("particle.position") - start
    np.testing.assert_allclose(risen[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(risen[:, 1], 0.7 * simulation.time, rtol=1e-9)
    np.testing.assert_allclose(simulation.array("particle.stress"), 0.0, atol=1e-7)
