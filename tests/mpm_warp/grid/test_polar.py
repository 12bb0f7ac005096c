"""The grid of rings and rays: exact geometry, and what its shape functions reproduce."""

import functools
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.location import make_location
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.kernel_types import vec5
from mpm_warp.step.points import seed_rows

ROUNDING = 1e-12
INNER, OUTER = 1.0, 3.0


def polar(*, planar: bool, rows: int = 6, last: float = 0.5 * np.pi) -> PolarGrid:
    return PolarGrid(
        columns=np.array([0.0, 0.2, 0.5, 1.0]),
        rows=np.linspace(0.0, last, rows + 1),
        surface_radius=np.full(rows + 1, INNER),
        fitted_radius=OUTER,
        planar=planar,
    )


def test_volumes_are_those_of_a_quarter_ring_and_of_half_a_shell() -> None:
    assert polar(planar=True).cell_volumes.sum() == pytest.approx(
        0.25 * np.pi * (OUTER**2 - INNER**2), rel=ROUNDING
    )
    # 4 pi / 3 of a whole shell; half of it, per radian.
    assert polar(planar=False).cell_volumes.sum() == pytest.approx(
        (OUTER**3 - INNER**3) / 3.0, rel=ROUNDING
    )


@pytest.mark.parametrize("planar", [True, False])
def test_particles_fill_the_grid(planar: bool) -> None:
    grid = polar(planar=planar)
    seed = seed_rows(grid, 0, grid.row_count, 2)
    # Two Gauss points along each side of a quarter of a cell: of fourth order in its angle.
    assert seed.volume.sum() == pytest.approx(grid.cell_volumes.sum(), rel=(np.pi / 24) ** 4)
    assert seed.particle_count == 4 * grid.cell_count


@pytest.mark.parametrize("planar", [True, False])
def test_a_uniform_velocity_has_no_gradient(planar: bool) -> None:
    gradients = polar(planar=planar).gradient_integrals[..., :2].sum(axis=1)
    np.testing.assert_allclose(gradients, 0.0, atol=ROUNDING)


def dilation_error(rows: int, *, planar: bool) -> float:
    """Of the flow v = x, whose dilation is 2 in plane strain and 3 in axisymmetry."""
    grid = polar(planar=planar, rows=rows)
    velocity = grid.node_positions[grid.cell_nodes]
    r, z, hoop = np.moveaxis(grid.gradient_integrals, -1, 0)
    rates = velocity[..., 0] * (r + hoop) + velocity[..., 1] * z
    exact = 2.0 if planar else 3.0
    return float(np.abs(rates.sum(axis=1) / grid.cell_volumes / exact - 1.0).max())


@pytest.mark.parametrize("planar", [True, False])
def test_uniform_dilation_is_of_second_order_in_the_angle(planar: bool) -> None:
    coarse, fine = (dilation_error(rows, planar=planar) for rows in (8, 16))
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.1)


def test_integrals_after_the_wall_has_moved_are_those_of_a_grid_made_there() -> None:
    """The closed form, product by product, against quadrature."""
    grid = polar(planar=False)
    angular, caps = grid.angular_integrals
    distance = INNER + (OUTER - INNER) * grid.columns
    a, w = distance[:-1], np.diff(distance)
    squares = a**2 + a * w + w**2 / 3.0
    firsts = {0: w * (a / 2 + w / 6), 1: w * (a / 2 + w / 3)}
    expected = grid.gradient_integrals.reshape(grid.row_count, grid.column_count, 4, 3)
    for ray in (0, 1):
        for side, sign in ((0, -1.0), (1, 1.0)):
            t = angular[:, ray, :, None]
            r = sign * squares * t[:, 0] + firsts[side] * t[:, 1]
            z = sign * squares * t[:, 2] - firsts[side] * t[:, 3]
            parts = np.stack([r, z, firsts[side] * t[:, 4]], axis=-1)
            np.testing.assert_allclose(expected[:, :, 2 * ray + side], parts, atol=1e-12)
    volumes = grid.cell_volumes.reshape(grid.row_count, -1)
    np.testing.assert_allclose(volumes, np.outer(caps, squares * w), rtol=ROUNDING)


def test_wall_vectors_add_up_to_the_projected_wall() -> None:
    """Of a quarter circle its two shadows; of half a sphere, per radian, its equator's disc."""
    circle = polar(planar=True).wall_vectors.sum(axis=0)
    np.testing.assert_allclose(circle, [INNER, INNER], rtol=ROUNDING)
    sphere = polar(planar=False).wall_vectors[:, 1].sum()
    assert sphere == pytest.approx(0.5 * INNER**2, rel=ROUNDING)


def test_stress_along_rays_of_a_uniform_stress() -> None:
    grid = polar(planar=True)
    stress = np.tile([3.0, 1.0, 0.5, 7.0], (grid.cell_count, 1))
    turned = grid.along_rays(stress)
    np.testing.assert_allclose(turned[..., :2].sum(axis=-1), 4.0, rtol=ROUNDING)
    angle = 0.5 * (grid.rows[1:] + grid.rows[:-1])
    along = 2.0 - np.cos(2 * angle) + 0.5 * np.sin(2 * angle)
    np.testing.assert_allclose(turned[:, 0, 0], along, rtol=ROUNDING)


@functools.cache
def make_locate(polar: bool) -> Any:
    """The kernel that gives natural coordinates, and the position outside the surface."""
    location = make_location(polar)
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
