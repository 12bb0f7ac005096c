"""A scene: what it refuses, the order of its parts, and a boundary that only this file knows."""

import dataclasses

import numpy as np
import pytest
import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.kernel_types import one, real, vec4
from mpm_warp.parts.boundaries import FarField, Fixed, RadialMotion
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.cyclic_window import CyclicWindow
from mpm_warp.parts.enclosed_soil import EnclosedSoil
from mpm_warp.parts.energy import EnergyAudit, EnergyBalance
from mpm_warp.parts.forces import Gravity
from mpm_warp.parts.free_surface import FreeSurface, PassingSurface
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.parts.surrounding_ground import SurroundingGround, TravellingSource
from mpm_warp.parts.window import MovingGrid, Window
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.planning import has_mass_matrix_correction, make_plan
from mpm_warp.scene import Part, Scene
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import layers, refused

WALL = MovingWall(speed=1.0, ramp_travel=1.0)
WINDOW = Window(speed=1.0, ramp_travel=1.0, spare_fraction=0.1)
LINES = {"columns": np.linspace(0.0, 1.0, 4), "fitted_radius": 2.0}
ON_RAYS = PolarGrid(**LINES, rows=np.linspace(0.0, 0.5 * np.pi, 4), surface_radius=np.ones(4))
PLANE = Grid(**LINES, rows=np.arange(4.0), surface_radius=np.ones(4), planar=True)
LEANING = Grid(**LINES, rows=np.arange(4.0), surface_radius=np.linspace(0.0, 1.0, 4))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"bulk_viscosity": -0.2},
            "Scene: bulk_viscosity = -0.2 is not allowed: must be a number > 0; ",
        ),
        ({"parts": (WALL, WINDOW)}, "MovingWall: not together with a MovingGrid$"),
        *(
            ({"parts": (WALL,), "grid": it}, "MovingWall: not together with a grid that leans")
            for it in (PLANE, LEANING)
        ),
        (
            {"parts": (ConservativeInterpolation(),), "grid": ON_RAYS},
            "ConservativeInterpolation: not together with a grid of rays$",
        ),
        ({"parts": (RadialMotion(),)}, "radial motion: the grid is a Grid, must be a PolarGrid$"),
        # It leaves cells that are empty by right.
        (
            {"parts": (FreeSurface(), EnclosedSoil())},
            "EnclosedSoil: not together with a free surface$",
        ),
        ({"parts": (Fixed.on, WALL)}, r"Scene: parts\[0\] = <.*> must be of type Part$"),
    ],
)
def test_what_does_not_go_together_is_refused_in_one_line(
    floating: Scene, changes: dict[str, object], message: str
) -> None:
    with pytest.raises(SceneError, match=f"^{message}"):
        dataclasses.replace(floating, **changes)


def test_parts_need_others_and_are_not_beside_some(cone: Scene) -> None:
    source = TravellingSource(radius=1.0, height=0.0, shear_modulus=2e6)
    ground = SurroundingGround(source=source, grid=cone.grid, material=cone.material, strength=1e4)
    surface = PassingSurface(level=0.0, layer=1.0, pic_fraction=0.1)
    cycles = CyclicWindow(speed=1.0, ramp_travel=0.1, stroke=1.0)
    bare = cone.without(FarField, EnergyAudit)
    in_ground = cone.without(FarField).with_parts(EnergyBalance(), ground, surface)
    varied = dataclasses.replace(cone.material, variation=layers((0, 1, 1)))
    for do, name in (
        (lambda: in_ground.without(Window), "EnergyBalance: not without a MovingGrid"),
        (lambda: in_ground.without(SurfaceContact), "EnergyBalance: not without a SurfaceContact"),
        (lambda: in_ground.without(EnergyAudit), "EnergyBalance: not without a EnergyAudit"),
        (
            lambda: bare.with_parts(ground).without(Window),
            "SurroundingGround: not without a Window",
        ),
        (lambda: bare.with_parts(surface).without(Window), "PassingSurface: not without a Window"),
        (lambda: cone.with_parts(ground), "SurroundingGround: not together with a FarField"),
        (lambda: cone.with_parts(cycles), "CyclicWindow: not together with a FarField"),
        (
            lambda: dataclasses.replace(cone, material=varied),
            "FarField: not together with a material that varies",
        ),
    ):
        refused(do, SceneError, name)


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


TRAVEL = 1.5


@dataclasses.dataclass(frozen=True)
class ViscousSide(Part):
    """Dashpots along the outer side, stiffer with depth: v <- v / (1 + dt c (1 + travel)).

    Attributes:
        rate: c [1/s], >= 0.
    """

    rate: float

    def add_boundary(self, plan: Plan, scene: Scene) -> None:
        grid = scene.grid
        nodes = grid.node(grid.column_count, np.arange(grid.row_count + 1))
        plan.add_array("side.nodes", "int", nodes, (grid.node_count,))
        plan.add_array("side.rate", "real", np.full(len(nodes), self.rate))
        plan.add_launch(viscous_side, len(nodes))

    def follow(self, run: Run, scene: Scene, travel: float, *, by_a_row: bool) -> None:
        run.assign("side.rate", self.rate * (1.0 + travel))


@wp.kernel(module="tests.viscous_side", enable_backward=False)
def viscous_side(
    offset: int,
    side_nodes: wp.array(dtype=int),
    side_rate: wp.array(dtype=real),
    time_step: real,
    node_velocities: wp.array(dtype=vec4),
):
    k = offset + wp.tid()
    v = node_velocities[side_nodes[k]]
    slowed = one + time_step * side_rate[k]
    node_velocities[side_nodes[k]] = vec4(v[0] / slowed, v[1] / slowed, v[2], v[3])


@pytest.fixture
def open_side(cone: Scene) -> Scene:
    """The cone without a far field: nothing is at the side."""
    return cone.without(FarField)


def after(scene: Scene) -> tuple[Simulation, Floats]:
    simulation = Simulation(scene)
    simulation.travel_to(TRAVEL)
    simulation.check()
    return simulation, simulation.array("particle.stress").copy()


def test_a_part_of_ones_own_adds_its_arrays_and_one_launch(open_side: Scene) -> None:
    """Before the contact, though it is the last of the parts; all else is what it was."""
    before, plan = make_plan(open_side), make_plan(open_side.with_parts(ViscousSide(1.0)))
    assert set(plan.arrays) - set(before.arrays) == {"side.nodes", "side.rate"}
    names, added = ([it.name for it in each.step] for each in (before, plan))
    place = names.index("surface_contact")
    assert added == [*names[:place], "viscous_side", *names[place:]]
    assert len(plan.audited_step) == len(before.audited_step) + 1
    assert plan.between_steps.keys() == before.between_steps.keys()


def test_a_part_of_ones_own_acts_and_follows_the_window(open_side: Scene) -> None:
    """With dashpots of no strength not a bit of the result is another."""
    _, expected = after(open_side)
    _, without_effect = after(open_side.with_parts(ViscousSide(0.0)))
    np.testing.assert_array_equal(without_effect, expected)
    simulation, slowed = after(open_side.with_parts(ViscousSide(1e4)))
    assert np.abs(slowed - expected).max() > 1.0
    rate = simulation.array("side.rate")
    assert np.all(rate == rate[0])
    layer = float(np.diff(open_side.grid.rows)[0]) / open_side.particles_per_side
    assert TRAVEL - layer <= rate[0] / 1e4 - 1.0 <= TRAVEL + layer
