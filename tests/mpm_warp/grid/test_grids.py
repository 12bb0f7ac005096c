"""Geometry of the grids, fitted and of rays: exact integrals, whatever the shape of the cells."""

import dataclasses
import functools
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.grid.fitted import Floats, Grid, graded, nodal_areas
from mpm_warp.grid.location import make_location
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.kernel_types import vec5
from mpm_warp.step.points import seed_rows

ROUNDING = 1e-12


@pytest.fixture(params=["fitted", "partly_upright", "rectilinear"])
def grid(request: pytest.FixtureRequest) -> Grid:
    """Each of the grids with horizontal rows."""
    return request.getfixturevalue(request.param)


def test_cells_fill_the_space_around_the_penetrometer(fitted: Grid) -> None:
    height = float(np.ptp(fitted.rows))
    cone_height = 1.0 / np.tan(np.radians(30.0))
    shaft = 0.5 * (fitted.rows[-1] - cone_height)
    expected = 0.5 * fitted.outer_radius**2 * height - cone_height / 6.0 - shaft  # per radian
    assert fitted.cell_volumes.sum() == pytest.approx(expected, rel=ROUNDING)


def test_mean_strain_rate_of_a_linear_velocity_field_is_exact(grid: Grid) -> None:
    """v = A x: the integrals of the gradients times nodal velocities give A in every cell.

    Of v_r = r the hoop rate is one.
    """
    gradient = np.array([[0.3, -0.7], [1.1, 0.2]])
    position = grid.node_positions[grid.cell_nodes]
    integrals = grid.gradient_integrals / grid.cell_volumes[:, None, None]
    mean = np.einsum("cnj,cni->cij", integrals[..., :2], position @ gradient.T)
    np.testing.assert_allclose(mean, np.broadcast_to(gradient, mean.shape), atol=1e-11)
    hoop = np.sum(integrals[..., 2] * position[..., 0], axis=1)
    np.testing.assert_allclose(hoop, 1.0, rtol=ROUNDING)


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
    seed = seed_rows(grid, grid.row_count, per_side)
    volume = np.zeros(grid.cell_count)
    np.add.at(volume, seed.cell[:, 1] * grid.column_count + seed.cell[:, 0], seed.volume)
    np.testing.assert_allclose(volume, grid.cell_volumes, rtol=ROUNDING)
    assert len(seed.volume) == grid.cell_count * per_side**2


def test_particles_give_nodes_their_exact_share(rectilinear: Grid) -> None:
    """In straight cells, linear functions of r and z are integrated exactly by the centroids."""
    seed = seed_rows(rectilinear, rectilinear.row_count, 1)
    moment = np.sum(seed.volume[:, None] * seed.position, axis=0)
    radius, height = rectilinear.outer_radius, rectilinear.rows[-1]
    exact: Floats = np.array([radius**3 / 3.0 * height, radius**2 / 2.0 * height**2 / 2.0])
    np.testing.assert_allclose(moment, exact, rtol=ROUNDING)


def test_there_is_no_particle_above_the_ground_or_beside_it(rectilinear: Grid) -> None:
    """A border between two points of a cell: what is inside is as in a grid that is full."""
    level = 0.5 * (rectilinear.rows[1] + rectilinear.rows[2])
    side = 0.5 * rectilinear.fitted_radius * (rectilinear.columns[1] + rectilinear.columns[2])
    for border, axis, at in (("ground_level", 1, level), ("soil_radius", 0, side)):
        ground = dataclasses.replace(rectilinear, **{border: at})
        full, seed = (seed_rows(it, it.row_count, 2) for it in (rectilinear, ground))
        inside = full.position[:, axis] < at
        assert 0 < inside.sum() < len(inside)
        for found, expected in zip(seed, full, strict=True):
            np.testing.assert_array_equal(found, expected[inside])


@pytest.mark.parametrize(
    ("first", "length", "growth", "fewest"),
    [
        (0.25, 39.0, 1.2, 10),
        (1.0, 1.5, 1.1, 1),
        *((1.0 / it, 999.0, 1.0 + 0.1 / it, 900) for it in (20, 40, 100)),
    ],
)
def test_graded_edges_reach_the_end_in_equal_ratios(
    first: float, length: float, growth: float, fewest: int
) -> None:
    """Also 1,500 and more widths, each a little more than the one before."""
    edges = graded(first, length, growth)
    widths = np.diff(edges)
    ratios = widths[1:] / widths[:-1]
    assert edges[0] == 0.0
    assert edges[-1] == length
    assert len(widths) >= fewest
    np.testing.assert_allclose(ratios, ratios[:1].repeat(len(ratios)), rtol=1e-9)
    if fewest > 100:
        assert widths[0] == pytest.approx(first, rel=1e-6)
        np.testing.assert_allclose(ratios, growth, rtol=1e-4)


INNER, OUTER = 1.0, 3.0


def polar(*, planar: bool, rows: int = 6, last: float = 0.5 * np.pi) -> PolarGrid:
    return PolarGrid(
        columns=np.array([0.0, 0.2, 0.5, 1.0]),
        rows=np.linspace(0.0, last, rows + 1),
        surface_radius=np.full(rows + 1, INNER),
        fitted_radius=OUTER,
        planar=planar,
    )


def test_volume_and_wall_are_those_of_a_quarter_ring_and_of_half_a_shell() -> None:
    """Per radian; the wall adds up to the two shadows of an arc, to the disc of an equator."""
    ring, shell = polar(planar=True), polar(planar=False)
    volume = 0.25 * np.pi * (OUTER**2 - INNER**2)
    assert ring.cell_volumes.sum() == pytest.approx(volume, rel=ROUNDING)
    np.testing.assert_allclose(ring.wall_vectors.sum(axis=0), [INNER, INNER], rtol=ROUNDING)
    # 4 pi / 3 of a whole shell
    volume = (OUTER**3 - INNER**3) / 3.0
    assert shell.cell_volumes.sum() == pytest.approx(volume, rel=ROUNDING)
    assert shell.wall_vectors[:, 1].sum() == pytest.approx(0.5 * INNER**2, rel=ROUNDING)


@pytest.mark.parametrize("planar", [True, False])
def test_particles_fill_the_grid_and_a_uniform_velocity_has_no_gradient(planar: bool) -> None:
    grid = polar(planar=planar)
    seed = seed_rows(grid, grid.row_count, 2)
    # Two Gauss points along each side of a quarter of a cell: of fourth order in its angle.
    assert seed.volume.sum() == pytest.approx(grid.cell_volumes.sum(), rel=(np.pi / 24) ** 4)
    assert len(seed.volume) == 4 * grid.cell_count
    gradients = grid.gradient_integrals[..., :2].sum(axis=1)
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


def test_nodal_areas_integrate_linear_functions_exactly() -> None:
    """Of r over a line of slope: the whole, and its first moment along the line."""
    radius = np.array([0.0, 0.5, 0.8, 2.0])
    length = 2.0 * np.diff(radius)
    area = nodal_areas(radius, length)
    assert area.sum() == pytest.approx(2.0 * 0.5 * 2.0**2, rel=1e-13)
    assert area @ radius == pytest.approx(2.0 * 2.0**3 / 3.0, rel=1e-13)


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
    return found.numpy()


@pytest.fixture
def rays() -> PolarGrid:
    """A quarter of a ring."""
    return polar(planar=True)


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
