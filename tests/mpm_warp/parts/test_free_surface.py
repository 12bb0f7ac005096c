"""A free surface that the soil carries up through a window."""

import dataclasses

import numpy as np
import pytest

from mpm_warp import (
    ConservativeInterpolation,
    ContactForces,
    Fixed,
    FreeSurface,
    Grid,
    PassingSurface,
    Scene,
    Simulation,
    SurfaceContact,
    Tresca,
    Window,
)

LEVEL_ROW = 5
"""Number of the row of nodes at the surface."""


@pytest.fixture
def ground(empty: Scene) -> Scene:
    """Soil up to a row of the window, and no penetrometer in it."""
    rows = empty.grid.rows
    level = float(rows[LEVEL_ROW])
    layer = 1.5 * float(rows[1] - rows[0])
    in_window = empty.with_parts(
        dataclasses.replace(empty[Window], spare_fraction=3.0),
        PassingSurface(level=level, layer=layer, pic_fraction=0.25),
    )
    grid = dataclasses.replace(empty.grid, ground_level=level)
    return dataclasses.replace(in_window, grid=grid)


def _by_row(simulation: Simulation, ground: Scene, name: str) -> np.ndarray:
    return simulation.array(name).reshape(ground.grid.row_count, -1)


def test_cells_are_filled_in_part_near_the_surface_wherever_it_is(ground: Scene) -> None:
    """Of one and a half rows below the surface two are near it; it rises with the travel."""
    simulation = Simulation(ground)
    height = float(ground.grid.rows[1] - ground.grid.rows[0])
    full = (ground.material.density * ground.grid.cell_volumes).reshape(ground.grid.row_count, -1)
    for travelled in (0, 1, 2):
        simulation.travel_to((travelled + 0.3) * height)
        near = np.arange(ground.grid.row_count) >= LEVEL_ROW - 2 + travelled
        expected = np.where(near[:, None], full, 0.5 * full)
        np.testing.assert_allclose(_by_row(simulation, ground, "cell.full_mass"), expected)
        fraction = _by_row(simulation, ground, "cell.pic_fraction")
        np.testing.assert_array_equal(fraction, np.where(near, 0.25, 0.0)[:, None] + 0.0 * full)


def test_ground_below_a_surface_is_at_rest_until_it_has_left_the_window(ground: Scene) -> None:
    simulation = Simulation(ground)
    extent = float(np.ptp(ground.grid.rows))
    simulation.travel_to(0.7 * extent)
    assert np.abs(simulation.array("particle.velocity")).max() == 0.0
    cell = simulation.array("particle.cell")
    assert set(cell[cell[:, 0] >= 0, 1]) == set(range(ground.grid.row_count))


def test_a_point_near_the_surface_takes_its_share_of_the_velocity_of_the_grid(
    ground: Scene,
) -> None:
    """All of it is the velocity that the point moves with; deeper points keep their own."""

    def after_a_step(fraction: float) -> tuple[np.ndarray, np.ndarray]:
        surface = dataclasses.replace(ground[PassingSurface], pic_fraction=fraction)
        simulation = Simulation(ground.without(ConservativeInterpolation).with_parts(surface))
        velocity = simulation.array("particle.velocity")
        velocity[:, 0] = 1e-3 * np.sin(np.arange(len(velocity)))
        before = simulation.array("particle.position")[:, 0].copy()
        simulation.advance(1)
        moved = simulation.array("particle.position")[:, 0] - before
        return velocity[:, 0].copy(), moved / simulation.plan.time_step

    cell = Simulation(ground).array("particle.cell")
    is_near = cell[:, 1] >= LEVEL_ROW - 2
    is_deep = (cell[:, 0] >= 0) & ~is_near
    (own, _), (part, _), (whole, moving) = map(after_a_step, (1e-15, 0.25, 1.0))
    np.testing.assert_allclose(whole[is_near], moving[is_near], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(part, 0.75 * own + 0.25 * whole, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(part[is_deep], own[is_deep])
    assert np.abs(own - whole)[is_near].max() > 1e-4


@pytest.mark.parametrize(
    ("cells", "beyond", "told"),  # cells a metre; of them the last; what `own_scene.md` says
    [(4, 0.0, "2.00"), (8, 0.0, "1.99"), (4, 0.5, "1.92"), (8, 0.5, "1.96")],
)
def test_clay_in_a_wider_grid_bears_twice_its_strength(
    cells: int, beyond: float, told: str
) -> None:
    """Half a block 1 m wide between smooth plates, which shorten it by 0.2 %.

    The load is known to half a cell where its side is within one. On a column it is known to that
    strain, by which the block is wider and the share of it beyond the column is not supported.
    """
    strength, height, strain, width = 1e3, 2.0, 2e-3, 1.0 + beyond / cells
    edges = np.linspace(0.0, height, 2 * cells + 1)
    grid = Grid(
        columns=edges / height,
        rows=edges,
        surface_radius=0.0 * edges,
        fitted_radius=height,
        planar=True,
        soil_radius=width,
    )
    clay = Tresca(shear_modulus=1e6, poissons_ratio=0.3, density=1700.0, strength=strength)
    nodes = grid.node(np.arange(len(edges)), np.full(len(edges), grid.row_count))
    plate = SurfaceContact(
        nodes=nodes,
        normals=np.tile([0.0, 1.0], (len(nodes), 1)),
        normal_areas=np.full(len(nodes), 1.0 / cells),
        adhesion_forces=np.zeros(len(nodes)),
        in_situ_stress=0.0,
        speed=2e-5 * clay.shear_wave_speed,
    )
    base = Fixed.on(grid, radial=["axis"], vertical=["bottom"])
    parts = (base, plate, FreeSurface())
    simulation = Simulation(Scene(grid=grid, material=clay, bulk_viscosity=0.2, parts=parts))
    end = strain * height / plate.speed
    simulation.advance_to(0.75 * end)
    forces = ContactForces(simulation)
    simulation.advance_to(end)
    load = plate.upward_force(forces.take()) / (strength * width)
    known_to = 2.0 * strain + beyond / cells / width
    assert load == pytest.approx(2.0, rel=known_to)
    assert f"{load:.2f}" == told
