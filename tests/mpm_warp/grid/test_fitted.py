"""Geometry of the grid: exact integrals, whatever the shape of the cells."""

from __future__ import annotations

import numpy as np
import pytest

from mpm_warp.grid.fitted import Grid

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
    force = force.reshape(grid.row_count + 1, grid.column_count + 1, 2)
    scale = np.abs(pull).max()
    np.testing.assert_allclose(force[1:-1, 1:-1], 0.0, atol=ROUNDING * scale)


def test_critical_length_of_a_square_far_from_the_axis() -> None:
    side, radius = 0.1, 1e6
    grid = Grid(
        columns=np.array([0.0, 1.0]),
        rows=np.array([0.0, side]),
        surface_radius=np.full(2, radius),
        fitted_radius=radius + side,
    )
    assert grid.cell_lengths[0] == pytest.approx(side / np.sqrt(2.0), rel=1e-6)
