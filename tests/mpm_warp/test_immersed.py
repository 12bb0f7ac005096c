"""The penetrometer on a plain grid: cut cells, and the nodes that its surface acts on."""

from __future__ import annotations

import numpy as np
import pytest

from mpm_warp.immersed import POINTS_PER_CELL, ImmersedGrid, SampledSurface
from mpm_warp.grid.seeding import seed_rows
from mpm_warp.penetrometer import Penetrometer

ROUNDING = 1e-12
SAMPLING = 1.0 / POINTS_PER_CELL
"""A cut cell is sampled: its volume is known to a point along each side at worst."""


@pytest.fixture
def immersed(penetrometer: Penetrometer) -> ImmersedGrid:
    return ImmersedGrid.around(
        penetrometer,
        cell_size=0.4,
        cell_growth=0.8,
        outer_radius=6.0,
        depth_below=2.0,
        height_above=2.0,
    )


@pytest.fixture
def surface(penetrometer: Penetrometer, immersed: ImmersedGrid) -> SampledSurface:
    return SampledSurface(
        penetrometer=penetrometer,
        grid=immersed,
        face_adhesion=3.0,
        shaft_adhesion=1.0,
        friction=0.0,
        in_situ_stress=10.0,
    )


def test_volume_is_that_of_the_ground_less_the_penetrometer(
    penetrometer: Penetrometer, immersed: ImmersedGrid
) -> None:
    rows = immersed.rows
    ground = 0.5 * immersed.outer_radius**2 * (rows[-1] - rows[0])
    shaft = 0.5 * penetrometer.radius**2 * (rows[-1] - penetrometer.cone_height)
    cone = 0.5 * penetrometer.radius**2 * penetrometer.cone_height / 3.0
    open_volume = (
        immersed.gradient_integrals[..., 2] * immersed.node_positions[immersed.cell_nodes, 0]
    )
    cut_volume = penetrometer.radius * 0.4 * (rows[-1] - rows[0])
    assert open_volume.sum() == pytest.approx(ground - shaft - cone, abs=SAMPLING * cut_volume)
    np.testing.assert_array_less(0.0, immersed.cell_volumes)


def test_a_uniform_velocity_has_no_gradient_anywhere(immersed: ImmersedGrid) -> None:
    gradients = immersed.gradient_integrals[..., :2].sum(axis=1)
    np.testing.assert_allclose(gradients, 0.0, atol=ROUNDING * immersed.outer_radius)


def test_cells_away_from_the_penetrometer_are_those_of_a_plain_grid(
    immersed: ImmersedGrid,
) -> None:
    radius = immersed.node_positions[immersed.cell_nodes, 0]
    height = immersed.node_positions[immersed.cell_nodes, 1]
    whole = 0.5 * (radius[:, 1] ** 2 - radius[:, 0] ** 2) * (height[:, 2] - height[:, 0])
    away = (radius[:, 0] > 1.0) | (height[:, 2] < 0.0)
    np.testing.assert_allclose(immersed.cell_volumes[away], whole[away], rtol=1e-10)


def test_particles_are_where_the_penetrometer_is_not(
    penetrometer: Penetrometer, immersed: ImmersedGrid
) -> None:
    position = seed_rows(immersed, 0, immersed.row_count, 2).position
    assert (position[:, 0] > penetrometer.surface_radius(position[:, 1])).all()
    in_the_shaft = (position[:, 0] < 1.0) & (position[:, 1] > penetrometer.cone_height)
    assert not in_the_shaft.any()


def test_areas_of_face_and_shaft_are_exact(surface: SampledSurface) -> None:
    face, shaft = surface.areas
    assert face.sum() == pytest.approx(0.5 / np.sin(np.radians(30.0)), rel=ROUNDING)
    length = surface.grid.rows[-1] - surface.penetrometer.cone_height
    assert shaft.sum() == pytest.approx(length, rel=ROUNDING)


def test_a_uniform_pressure_gives_its_value_times_the_base(surface: SampledSurface) -> None:
    contact = surface.contact
    nodal = np.stack([7.0 * contact.normal_areas, np.zeros(len(contact.nodes))], axis=-1)
    assert surface.forces(nodal).face_normal == pytest.approx(7.0 * 0.5, rel=ROUNDING)


def test_the_surface_acts_on_nodes_within_the_penetrometer(surface: SampledSurface) -> None:
    place = surface.grid.node_positions[surface.nodes]
    assert not surface.grid.holds_soil(place).any()
