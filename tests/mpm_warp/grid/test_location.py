"""Where the device finds a particle, against where the grid has put it."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.location import make_location
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.precision import FLOAT64

vec5 = FLOAT64.vec5


@functools.cache
def make_locate(polar: bool) -> Any:
    """The kernel that gives natural coordinates, and the position outside the surface."""
    location = make_location(polar, FLOAT64)
    natural, outside_surface = location.natural, location.outside_surface

    @wp.kernel(enable_backward=False, module="unique")
    def locate(
        x: wp.vec2d, column: wp.vec3d, row: vec5, outer: wp.float64, found: wp.array(dtype=wp.vec2d)
    ):
        found[0] = natural(x, column, row, outer)
        found[1] = outside_surface(x, row)

    return locate


def located(grid: Grid, i: int, j: int, x: Floats) -> Floats:
    """Natural coordinates of a position in a cell, and that position outside the surface."""
    width, height = np.diff(grid.columns)[i], np.diff(grid.rows)[j]
    lean = np.diff(grid.surface_radius)[j]
    column = wp.vec3d(grid.columns[i], width, 1.0 / width)
    row = vec5(grid.rows[j], height, 1.0 / height, grid.surface_radius[j], lean)
    found = wp.zeros(2, dtype=wp.vec2d, device="cpu")
    arguments = [wp.vec2d(*x), column, row, grid.fitted_radius, found]
    wp.launch(make_locate(grid.polar), 1, arguments, device="cpu")
    values: Floats = found.numpy()
    return values


@pytest.fixture
def rays() -> PolarGrid:
    """A quarter of a ring."""
    return PolarGrid(
        columns=np.array([0.0, 0.2, 0.5, 1.0]),
        rows=np.linspace(0.0, 0.5 * np.pi, 7),
        surface_radius=np.full(7, 1.0),
        fitted_radius=3.0,
        planar=True,
    )


@pytest.mark.parametrize(
    ("name", "column"),
    [("rays", 1), ("fitted", 1), ("rectilinear", 1), ("partly_upright", 1), ("partly_upright", -2)],
)
def test_device_places_a_particle_where_the_grid_does(
    name: str, column: int, request: pytest.FixtureRequest
) -> None:
    """Natural coordinates, against the grid's own positions."""
    grid: Grid = request.getfixturevalue(name)
    i, j, xi, eta = column % grid.column_count, grid.row_count // 2, 0.3, 0.8
    x = grid.place(np.array(i), np.array(j), np.array(xi), np.array(eta))
    natural, outside = located(grid, i, j, x)
    np.testing.assert_allclose(natural, [xi, eta], rtol=1e-12)
    np.testing.assert_array_equal(outside, x)


def test_a_particle_within_the_surface_is_moved_out_of_it(fitted: Grid, rays: PolarGrid) -> None:
    """Along r out of a cone, along the ray out of a sphere."""
    row = int(np.flatnonzero(fitted.rows >= 0.0)[0])
    half_up = 0.5 * (fitted.rows[row] + fitted.rows[row + 1])
    _, outside = located(fitted, 0, row, np.array([0.01, half_up]))
    np.testing.assert_allclose(outside, [half_up * np.tan(np.radians(30.0)), half_up], rtol=1e-12)
    _, outside = located(rays, 0, 2, np.array([0.3, 0.4]))
    np.testing.assert_allclose(outside, [0.6, 0.8], rtol=1e-12)
