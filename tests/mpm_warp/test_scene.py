"""A scene: what it refuses, and the order of its parts."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Grid
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.parts.boundaries.moving_wall import MovingWall
from mpm_warp.parts.forces.damping import Damping
from mpm_warp.parts.forces.gravity import Gravity
from mpm_warp.parts.forces.nodal_load import NodalLoad
from mpm_warp.parts.window.window import Window
from mpm_warp.scene import Scene

WALL = MovingWall(speed=1.0, ramp_travel=1.0)
WINDOW = Window(speed=1.0, ramp_travel=1.0, spare_fraction=0.1)
ON_RAYS = PolarGrid(
    columns=np.linspace(0.0, 1.0, 4),
    rows=np.linspace(0.0, 0.5 * np.pi, 4),
    surface_radius=np.ones(4),
    fitted_radius=2.0,
)


@pytest.fixture
def plane(rectilinear: Grid) -> Grid:
    """A grid in plane strain."""
    return dataclasses.replace(rectilinear, planar=True)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"particles_per_side": 0}, "particles_per_side = 0 must be >= 1$"),
        (
            {"time_step_fraction": float("nan")},
            "time_step_fraction = nan must be a finite number > 0$",
        ),
        ({"bulk_viscosity": -0.2}, "bulk_viscosity = -0.2 must be > 0$"),
        ({"precision": "float16"}, "precision = 'float16' must be one of float64, float32$"),
        (
            {"moving_wall": WALL, "window": WINDOW},
            "moving_wall: not together with a window$",
        ),
        (
            {"conservative_interpolation": True, "grid": ON_RAYS},
            "conservative_interpolation: not together with a grid of rays$",
        ),
    ],
)
def test_what_does_not_go_together_is_refused_in_one_line(
    floating: Scene, changes: dict[str, object], message: str
) -> None:
    with pytest.raises(SceneError, match=f"^{message}"):
        dataclasses.replace(floating, **changes)


def test_a_wall_moves_in_no_grid_that_leans_or_is_plane(
    floating: Scene, fitted: Grid, plane: Grid
) -> None:
    for grid in (fitted, plane):
        with pytest.raises(SceneError, match=r"^moving_wall: not together with a grid that leans"):
            dataclasses.replace(floating, grid=grid, moving_wall=WALL)


def test_parts_act_on_nodes_in_one_order(cone: Scene) -> None:
    """Forces in the order in which they are given, then what holds nodes, then the contact."""
    load = NodalLoad(nodes=np.array([0]), forces=np.ones((1, 2)))
    forces = (load, Gravity(9.81), Damping(1.0))
    scene = dataclasses.replace(cone, forces=forces)
    rest = [cone.fixed, cone.far_field, cone.contact]
    assert list(scene.node_actions) == [*forces, *rest]
    turned = dataclasses.replace(scene, forces=forces[::-1], far_field=None)
    assert list(turned.node_actions) == [*forces[::-1], cone.fixed, cone.contact]


@pytest.mark.parametrize(
    ("particles_per_side", "free_surface", "corrected"),
    [(2, False, True), (3, False, True), (1, False, False), (2, True, False)],
)
def test_velocities_are_corrected_where_cells_are_full_of_several_particles(
    floating: Scene, particles_per_side: int, free_surface: bool, corrected: bool
) -> None:
    scene = dataclasses.replace(
        floating, particles_per_side=particles_per_side, free_surface=free_surface
    )
    assert scene.has_mass_matrix_correction is corrected
