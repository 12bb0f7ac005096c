"""Geometry of the grid: exact integrals, whatever the shape of the cells."""

import numpy as np
import pytest

from mpm_warp.grid.fitted import Floats, Grid, GroundGrid, graded
from mpm_warp.step.points import seed_rows

ROUNDING = 1e-12


def _cone_volume(radius: float, height: float) -> float:
    return radius**2 * height / 6.0  # per radian


def test_cells_fill_the_space_around_the_penetrometer(fitted: Grid) -> None:
    height = float(np.ptp(fitted.rows))
    cone_height = 1.0 / np.tan(np.radians(30.0))
    shaft = 0.5 * (fitted.rows[-1] - cone_height)
    expected = 0.5 * fitted.outer_radius**2 * height - _cone_volume(1.0, cone_height) - shaft
    assert fitted.cell_volumes.sum() == pytest.approx(expected, rel=ROUNDING)


def test_mean_strain_rate_of_a_linear_velocity_field_is_exact(grid: Grid) -> None:
    """v = A x: the integrals of the gradients times nodal velocities give A in every cell."""
    gradient = np.array([[0.3, -0.7], [1.1, 0.2]])
    velocity = grid.node_positions @ gradient.T
    integrals = grid.gradient_integrals
    mean = np.einsum("cnj,cni->cij", integrals[..., :2], velocity[grid.cell_nodes])
    mean /= grid.cell_volumes[:, None, None]
    np.testing.assert_allclose(mean, np.broadcast_to(gradient, mean.shape), atol=1e-11)


def test_hoop_rate_of_a_radial_field_is_exact(grid: Grid) -> None:
    """v_r = r: the hoop rate is one."""
    hoop = np.sum(grid.gradient_integrals[..., 2] * grid.node_positions[grid.cell_nodes, 0], axis=1)
    np.testing.assert_allclose(hoop / grid.cell_volumes, 1.0, rtol=ROUNDING)


def test_uniform_pressure_is_in_balance_away_from_the_boundary(grid: Grid) -> None:
    """The divergence of a uniform pressure vanishes: gradient and hoop terms cancel at nodes."""
    force = np.zeros((grid.node_count, 2))
    pull = grid.gradient_integrals[..., :2].copy()
    pull[..., 0] += grid.gradient_integrals[..., 2]
    np.add.at(force, grid.cell_nodes, pull)
    at_nodes = force.reshape(grid.row_count + 1, grid.column_count + 1, 2)
    scale = np.abs(pull).max()
    np.testing.assert_allclose(at_nodes[1:-1, 1:-1], 0.0, atol=ROUNDING * scale)


def test_critical_length_of_a_square_far_from_the_axis() -> None:
    side, radius = 0.1, 1e6
    grid = Grid(
        columns=np.array([0.0, 1.0]),
        rows=np.array([0.0, side]),
        surface_radius=np.full(2, radius),
        fitted_radius=radius + side,
    )
    assert grid.cell_lengths[0] == pytest.approx(side / np.sqrt(2.0), rel=1e-6)


@pytest.mark.parametrize("per_side", [1, 2, 3])
def test_particles_hold_the_volume_of_their_cells(grid: Grid, per_side: int) -> None:
    seed = seed_rows(grid, 0, grid.row_count, per_side)
    volume = np.zeros(grid.cell_count)
    np.add.at(volume, seed.cell[:, 1] * grid.column_count + seed.cell[:, 0], seed.volume)
    np.testing.assert_allclose(volume, grid.cell_volumes, rtol=ROUNDING)
    assert seed.particle_count == grid.cell_count * per_side**2


def test_particles_give_nodes_their_exact_share(rectilinear: Grid) -> None:
    """In straight cells, linear functions of r and z are integrated exactly by the centroids."""
    seed = seed_rows(rectilinear, 0, rectilinear.row_count, 1)
    moment = np.sum(seed.volume[:, None] * seed.position, axis=0)
    radius, height = rectilinear.outer_radius, rectilinear.rows[-1]
    exact: Floats = np.array([radius**3 / 3.0 * height, radius**2 / 2.0 * height**2 / 2.0])
    np.testing.assert_allclose(moment, exact, rtol=ROUNDING)


def test_there_is_no_particle_above_the_ground(rectilinear: Grid) -> None:
    """A level between the two layers of a row: what is below it is as in a grid that is full."""
    level = 0.5 * (rectilinear.rows[1] + rectilinear.rows[2])
    ground = GroundGrid(
        columns=rectilinear.columns,
        rows=rectilinear.rows,
        surface_radius=rectilinear.surface_radius,
        fitted_radius=rectilinear.outer_radius,
        ground_level=level,
    )
    full, seed = (seed_rows(it, 0, it.row_count, 2) for it in (rectilinear, ground))
    below = full.position[:, 1] < level
    np.testing.assert_array_equal(seed.position, full.position[below])
    np.testing.assert_array_equal(seed.volume, full.volume[below])
    np.testing.assert_array_equal(seed.cell, full.cell[below])


@pytest.mark.parametrize(("first", "length", "growth"), [(0.25, 39.0, 1.2), (1.0, 1.5, 1.1)])
def test_graded_edges_reach_the_end_in_equal_ratios(
    first: float, length: float, growth: float
) -> None:
    edges = graded(first, length, growth)
    ratios = np.diff(edges)[1:] / np.diff(edges)[:-1]
    assert edges[0] == 0.0
    assert edges[-1] == length
    np.testing.assert_allclose(ratios, ratios[:1].repeat(len(ratios)), rtol=1e-9)


@pytest.mark.parametrize("cells_per_radius", [20, 40, 100])
def test_columns_of_any_number_are_graded(cells_per_radius: int) -> None:
    """1,500 and more widths, each a little more than the one before, that add up."""
    first, length, growth = 1.0 / cells_per_radius, 999.0, 1.0 + 0.1 / cells_per_radius
    widths = np.diff(graded(first, length, growth))
    assert len(widths) > 900
    assert widths.sum() == pytest.approx(length, rel=1e-12)
    assert widths[0] == pytest.approx(first, rel=1e-6)
    np.testing.assert_allclose(widths[1:] / widths[:-1], growth, rtol=1e-4)
