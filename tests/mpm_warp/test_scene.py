"""A scene: what it refuses, and the order of its parts."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Grid
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.parts.boundaries import FarField, Fixed
from mpm_warp.parts.energy import EnergyBalance
from mpm_warp.parts.forces import Gravity
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.parts.window import MovingGrid, Window
from mpm_warp.planning import has_mass_matrix_correction
from mpm_warp.scene import Part, Scene

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
        ({"bulk_viscosity": -0.2}, "bulk_viscosity = -0.2 must be > 0$"),
        ({"parts": (WALL, WINDOW)}, "MovingWall: not together with a MovingGrid$"),
        (
            {"parts": (ConservativeInterpolation(),), "grid": ON_RAYS},
            "ConservativeInterpolation: not together with a grid of rays$",
        ),
        ({"parts": (EnergyBalance(),)}, "EnergyBalance: not without a MovingGrid$"),
        ({"parts": (Fixed.axis, WALL)}, r"parts\[0\] = <.*> must be of type Part$"),
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
        with pytest.raises(SceneError, match=r"^MovingWall: not together with a grid that leans"):
            dataclasses.replace(floating, grid=grid, parts=(WALL,))


def test_parts_are_found_by_kind_changed_and_left_out(cone: Scene) -> None:
    assert cone.find(MovingGrid) is cone[Window]
    assert cone.find(Gravity) is None
    with pytest.raises(SceneError, match=r"^the scene has no Gravity$"):
        cone[Gravity]
    faster = dataclasses.replace(cone[Window], speed=2.0)
    changed = cone.with_parts(faster, Gravity(9.81))
    place = cone.parts.index(cone[Window])
    assert changed.parts == (*cone.parts[:place], faster, *cone.parts[place + 1 :], Gravity(9.81))
    assert changed.without(MovingGrid, FarField, Gravity).parts == tuple(
        part for part in cone.parts if not isinstance(part, (Window, FarField))
    )


@pytest.mark.parametrize(
    ("particles_per_side", "surface", "corrected"),
    [(2, (), True), (3, (), True), (1, (), False), (2, (FreeSurface(),), False)],
)
def test_velocities_are_corrected_where_cells_are_full_of_several_particles(
    floating: Scene, particles_per_side: int, surface: tuple[Part, ...], corrected: bool
) -> None:
    scene = dataclasses.replace(floating, particles_per_side=particles_per_side, parts=surface)
    assert has_mass_matrix_correction(scene) is corrected
