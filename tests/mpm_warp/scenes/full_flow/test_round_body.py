"""Ball and T-bar: outline, normals, areas, and the force read from them."""

import numpy as np
import pytest

from mpm_warp import Grid, SurfaceContact
from mpm_warp.scenes.full_flow.cyclic import CyclicTBar
from mpm_warp.scenes.full_flow.round_body import RoundBody

ROUNDING = 1e-12
RADIUS = 2.0
BALL = RoundBody(radius=RADIUS)
BALL_AND_SHAFT = RoundBody(radius=RADIUS, shaft_radius=0.6)
BAR = RoundBody(radius=RADIUS, planar=True)


def around(body: RoundBody, cells: int = 4) -> tuple[Grid, SurfaceContact]:
    columns = np.array([0.0, 0.5, 1.0, 4.0])
    grid = body.fitted_grid(cells_per_radius=cells, columns=columns, extent=3)
    return grid, body.contact(grid, adhesion=5.0, in_situ_stress=0.0)


@pytest.mark.parametrize("body", [BALL, BALL_AND_SHAFT, BAR])
def test_the_first_column_stands_on_the_body_and_on_the_line_of_travel(body: RoundBody) -> None:
    grid, contact = around(body)
    r, z = grid.node_positions[contact.nodes].T
    on_body = (np.abs(z) <= RADIUS) & (r > body.shaft_radius)
    np.testing.assert_allclose(np.hypot(r, z)[on_body], RADIUS, rtol=ROUNDING)
    assert RADIUS in r  # the widest place is a node, so that the projected area is exact
    np.testing.assert_array_equal(grid.surface_radius[grid.rows <= -RADIUS], 0.0)
    np.testing.assert_array_equal(grid.surface_radius[grid.rows >= RADIUS], body.shaft_radius)
    assert z[0] == -RADIUS
    assert z[-1] == (RADIUS if body.shaft_radius == 0.0 else grid.rows[-1])


def test_rows_beside_the_poles_are_half_as_high_as_those_away_from_the_body() -> None:
    grid, _ = around(BALL, 4)
    heights = np.diff(grid.rows)
    from_pole = RADIUS * np.array([0.125, 0.21875, 0.21875, 0.21875, 0.21875])
    beside = np.abs(grid.rows[:-1] + 0.5 * heights) < RADIUS
    np.testing.assert_allclose(heights[beside], [*from_pole, *from_pole[::-1]], rtol=ROUNDING)
    np.testing.assert_allclose(heights[~beside], 0.25 * RADIUS, rtol=ROUNDING)


def test_the_nodes_near_the_body_are_the_same_in_a_larger_grid() -> None:
    columns = np.array([0.0, 1.0, 2.2, 4.0, 6.0, 9.0])
    small, large = (
        BALL.fitted_grid(cells_per_radius=4, columns=columns[:count], extent=3) for count in (4, 6)
    )
    of_small, of_large = (
        it.node_positions.reshape(it.row_count + 1, -1, 2) for it in (small, large)
    )
    np.testing.assert_allclose(of_large[:, :4], of_small, rtol=ROUNDING)
    # Beyond three radii all columns are upright.
    assert np.ptp(of_large[:, 3:, 0], axis=0).max() <= ROUNDING * RADIUS


@pytest.mark.parametrize(("body", "area"), [(BALL, 0.0), (BALL_AND_SHAFT, 0.18), (BAR, 0.0)])
def test_uniform_pressure_acts_on_the_area_of_the_shaft_alone(body: RoundBody, area: float) -> None:
    """On the whole it pushes by its value times the area where no soil is, pi rs^2 over 2 pi."""
    _, contact = around(body)
    pressure = np.stack([7.0 * contact.normal_areas, 0.0 * contact.normal_areas], axis=-1)
    assert contact.upward_force(pressure) == pytest.approx(7.0 * area, abs=1e-11)
    np.testing.assert_allclose(np.linalg.norm(contact.normals, axis=1), 1.0, rtol=ROUNDING)


@pytest.mark.parametrize(
    ("body", "surface"), [(BALL, 2.0 * RADIUS**2), (BAR, np.pi * RADIUS)], ids=["ball", "bar"]
)
def test_adhesion_acts_on_the_surface_of_the_body(body: RoundBody, surface: float) -> None:
    """A chord that spans the angle t misses t^2 / 24 of its arc: here at most that at the poles."""
    cells = 16
    _, contact = around(body, cells)
    widest = np.arccos(1.0 - 0.5 / cells)
    assert contact.adhesion_forces.sum() < 5.0 * surface
    assert contact.adhesion_forces.sum() == pytest.approx(5.0 * surface, rel=widest**2 / 24)


def test_the_shaft_is_smooth_and_shear_of_soil_that_flows_up_lifts_the_body() -> None:
    grid, contact = around(BALL_AND_SHAFT)
    height = grid.node_positions[contact.nodes, 1]
    np.testing.assert_array_equal(contact.adhesion_forces[height > RADIUS], 0.0)
    widest = np.flatnonzero(grid.node_positions[contact.nodes, 0] == RADIUS)
    nodal = np.zeros((len(contact.nodes), 2))
    # Soil that flows up past the body, d = (0, 1), drags it up: J = +1 along (n_z, -n_r) = (0, 1).
    nodal[widest, 1] = 1.0
    assert contact.upward_force(nodal) == pytest.approx(1.0, abs=0.1)


def test_normals_at_the_poles_are_vertical() -> None:
    for body, count in ((BALL, 2), (BAR, 2), (BALL_AND_SHAFT, 1)):
        grid, contact = around(body)
        poles = np.flatnonzero(grid.node_positions[contact.nodes, 0] == 0.0)
        assert len(poles) == count
        np.testing.assert_allclose(contact.normals[poles, 0], 0.0)


def test_a_body_in_clay_with_a_stiffness_of_its_own_is_slower_than_its_waves() -> None:
    """Whatever strength is given beside that law."""
    bar = CyclicTBar(material="modified_cam_clay", undrained_shear_strength=400.0)
    assert bar.window.speed == pytest.approx(bar.speed_ratio * bar.soil.shear_wave_speed)
