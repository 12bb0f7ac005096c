"""The mean stress of a cell: of one that is filled in part, and of one that is viscous."""

import dataclasses

import numpy as np

from mpm_warp.grid.fitted import Grid, GroundGrid
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


def test_a_cell_at_the_surface_of_the_ground_bears_stress_as_far_as_it_is_filled(
    floating: Scene, fitted: Grid
) -> None:
    """Four particles to a side of a cell; the ground ends half way up a row, below the tip."""
    row = 1
    assert not fitted.surface_radius[: row + 3].any()
    half_up = 0.5 * (fitted.rows[row] + fitted.rows[row + 1])
    ground = GroundGrid(
        columns=fitted.columns,
        rows=fitted.rows,
        surface_radius=fitted.surface_radius,
        fitted_radius=fitted.outer_radius,
        ground_level=half_up,
    )
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


def test_a_cell_that_is_empty_for_a_moment_keeps_its_stress(floating: Scene) -> None:
    simulation = Simulation(floating)
    simulation.array("particle.stress")[:] = [-3.0, -2.0, 1.0, -2.5]
    simulation.advance(1)
    cell = simulation.array("particle.cell")
    cell[(cell == [1, 1]).all(axis=1)] = [2, 1]
    simulation.array("particle.stress")[:] = 0.0
    simulation.advance(1)
    stress = simulation.array("cell.stress").reshape(floating.grid.row_count, -1, 4)
    np.testing.assert_allclose(stress[1, 1], [-3.0, -2.0, 1.0, -2.5], rtol=1e-12)
    np.testing.assert_array_equal(stress[1, 2], 0.0)
