"""The grid of rings and rays: exact geometry, and what its shape functions reproduce."""

from __future__ import annotations

import numpy as np
import pytest

from mpm_warp.grid.polar import PolarGrid
from mpm_warp.grid.seeding import seed_rows

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
