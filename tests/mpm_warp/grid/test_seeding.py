"""Particles as they are put into a grid: they stand for all of its soil, and for no more."""

from __future__ import annotations

import numpy as np
import pytest

from mpm_warp.grid.fitted import Floats, Grid, GroundGrid
from mpm_warp.grid.seeding import seed_rows

ROUNDING = 1e-12


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
