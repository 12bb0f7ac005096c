"""The watch: a fault planted in a sound run is noticed within 500 steps, and named.

On small scenes, and (slow) on every scene of the catalogue.
"""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp import FreeSurface, Scene, Simulation, SimulationDiverged, SurfaceContact, Tresca
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.errors import Fault
from mpm_warp.fields.declaration import Value
from mpm_warp.kernel_types import real, vec1, vec3, vec4, zero
from mpm_warp.scenes import scene_class, scene_names
from mpm_warp.watch import check_contact

NOTICED_WITHIN = 500
BLOCK = 3
"""Cells along the side of a block that is watched for its soil."""
FAULTS = [
    ("particle.stress", np.nan, "stress"),
    ("particle.velocity", 1e30, "velocity"),
    ("particle.position", 1e6, "position"),
    ("particle.mass", 0.0, "mass"),
]
PARAMETERS: dict[str, dict[str, Value]] = {
    # With an approach a row of cells runs empty below at its speed, where no soil is let in.
    "cone_penetration": {"approach": 0},
    # So deep that the soil may not part from the penetrometer.
    "sounding": {"from_depth": 20, "to_depth": 21},
}
"""What a scene of the catalogue has in place of its defaults."""
BUILT = {name: scene_class(name).build.__annotations__["return"] for name in scene_names()}
"""What each scene builds: soil in a grid, bodies, or what is not watched."""
SOIL_SCENES = [name for name, kind in BUILT.items() if kind in (Scene, "Scene")]
BODY_SCENES = [name for name, kind in BUILT.items() if kind in (BodyScene, "BodyScene")]
SMALL = ["cone", "cavity", "floating"]
"""A window with contact, a wall that moves, and soil alone."""


class DriftingTresca(Tresca):
    """A return that adds a thousandth of the strength a step to the pressure."""

    def update(self) -> Any:
        return _make_drifting(super().update())


@functools.cache
def _make_drifting(plain: Any) -> Any:

    @wp.func
    def drifting(stress: vec4, strain: vec4, time_step: real, properties: vec3, state: vec1):
        returned, remembered = plain(stress, strain, time_step, properties, state)
        added = real(1e-3) * properties[2]
        return returned + vec4(added, added, zero, added), remembered

    return drifting


@functools.cache
def composition(name: str) -> Any:
    """What a scene of the catalogue builds, built once."""
    return scene_class(name)(**PARAMETERS.get(name, {})).build()


@pytest.fixture
def scene(request: pytest.FixtureRequest) -> Any:
    """A small scene, or one of the catalogue."""
    name = request.param
    return request.getfixturevalue(name) if name in SMALL else composition(name)


def on(*small: str, catalogue: Sequence[str] = ()) -> pytest.MarkDecorator:
    """A test on small scenes, and on scenes of the catalogue."""
    slow = [pytest.param(name, marks=pytest.mark.slow) for name in catalogue]
    return pytest.mark.parametrize("scene", [*small, *slow], indirect=True)


def started(scene: Scene | BodyScene) -> Simulation:
    """A run, a few steps on."""
    simulation = Simulation(scene)
    simulation.advance(3)
    return simulation


def plant(simulation: Simulation, array: str, particle: int, value: float) -> None:
    """Give a particle a value, its first component only: above a window soil leaves by right."""
    values = simulation.array(array)
    values.reshape(len(values), -1)[particle, 0] = value


@on(*SMALL)
@pytest.mark.parametrize(("array", "value", "named"), FAULTS)
def test_planted_fault_is_noticed_and_its_particle_named(
    scene: Scene, array: str, value: float, named: str
) -> None:
    """Of other scenes the watch is the same: that they have it, a doubled time step tells."""
    simulation = started(scene)
    particle = simulation.plan.particle_count // 2
    plant(simulation, array, particle, value)
    with pytest.raises(SimulationDiverged) as noticed:
        simulation.advance(NOTICED_WITHIN)
    message = str(noticed.value)
    assert f"{named} of particle {particle} at" in message
    assert "healthy at step 0" in message
    assert "try a smaller time_step_fraction" in message
    assert noticed.value.status == "diverged"
    assert "\n" not in message


@pytest.mark.slow
@pytest.mark.parametrize(("array", "value", "named"), FAULTS)
def test_planted_fault_in_a_body_is_noticed(array: str, value: float, named: str) -> None:
    simulation = started(composition("sliding_block"))
    plant(simulation, array, 0, value)
    with pytest.raises(SimulationDiverged, match=r"of particle \d+ at"):
        simulation.advance(NOTICED_WITHIN)


@on(*SMALL, catalogue=[*SOIL_SCENES, *BODY_SCENES])
def test_doubled_time_step_is_noticed(scene: Scene | BodyScene) -> None:
    """Twice the longest that is stable: some scenes take far shorter ones."""
    simulation = started(scene)
    simulation.plan.time_step = 2.0 * simulation.plan.longest_time_step
    with pytest.raises(SimulationDiverged, match="time step of"):
        simulation.advance(NOTICED_WITHIN)


def test_speeds_that_grow_at_twice_the_stable_step_are_noticed(
    cone: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the check of the step itself: what it does to the soil is noticed too."""
    monkeypatch.setattr("mpm_warp.watch.check_time_step", lambda **_: None)
    simulation = Simulation(dataclasses.replace(cone, time_step_fraction=2.5))
    with pytest.raises(SimulationDiverged, match=r"velocity of particle \d+ at"):
        simulation.advance(4 * NOTICED_WITHIN)


def test_cell_that_holds_more_soil_than_it_can_is_noticed(cone: Scene) -> None:
    simulation = Simulation(cone)
    cell = simulation.array("particle.cell")
    cell[cell[:, 0] >= 0] = [1, 2]
    number = 2 * cone.grid.column_count + 1
    with pytest.raises(SimulationDiverged, match=rf"soil in cell {number} is \d+\.?\d* times"):
        simulation.check()


def lose_soil(simulation: Simulation) -> None:
    """The particles of a block of cells are put into the cell beside it."""
    cell = simulation.array("particle.cell")
    cell[np.all((cell >= 1) & (cell <= BLOCK), axis=1)] = [BLOCK + 1, 1]


@on("cone", catalogue=SOIL_SCENES)
def test_cells_that_have_lost_their_soil_are_noticed(scene: Scene) -> None:
    """Where cells have others around them, and soil leaves by no right."""
    if min(scene.grid.row_count, scene.grid.column_count) > BLOCK and not scene.find(FreeSurface):
        simulation = started(scene)
        simulation.check()
        lose_soil(simulation)
        with pytest.raises(SimulationDiverged, match=r"soil in 3 x 3 cells from row 1, column \d"):
            simulation.check()


def test_soil_may_leave_cells_where_it_may_part_from_the_surface(cone: Scene) -> None:
    parting = dataclasses.replace(cone[SurfaceContact], in_situ_stress=0.0)
    simulation = Simulation(cone.with_parts(parting))
    lose_soil(simulation)
    simulation.check()


@on("cone", catalogue=SOIL_SCENES)
def test_contact_that_is_lost_is_noticed(scene: Scene) -> None:
    """It acts on nodes amid the soil, where soil parts from the surface by no right."""
    contact = scene.find(SurfaceContact)
    if contact is not None and contact.in_situ_stress > 0.0:
        simulation = started(scene)
        # Before anything else goes wrong by it.
        simulation.advance(NOTICED_WITHIN - 10 - simulation.step_count)
        simulation.array("contact.nodes")[:] = len(simulation.array("node.mass")) // 2
        with pytest.raises(SimulationDiverged, match=r"contact is lost on \d+% of the"):
            simulation.advance(NOTICED_WITHIN)


def test_a_held_node_may_be_without_soil_for_a_moment(cone: Scene) -> None:
    """It then has no velocity, while the body goes on; here they are a half of all."""
    contact = cone[SurfaceContact]
    held = np.arange(len(contact.nodes)) < len(contact.nodes) // 2
    with_the_body = np.tile([0.0, -2.0], (len(contact.nodes), 1))
    without = with_the_body.copy()
    without[held] = 0.0
    check_contact(contact, without, speed=2.0, on_axis=held)
    with pytest.raises(Fault, match=r"contact is lost on \d+% of the surface"):
        check_contact(contact, without, speed=2.0, on_axis=np.zeros_like(held))


def test_drift_of_the_mean_stress_is_noticed(cone: Scene) -> None:
    """A return to the yield surface that adds a thousandth of a strength a step to the pressure."""
    Simulation(cone).advance(NOTICED_WITHIN)
    assert isinstance(cone.material, Tresca)
    drifting = DriftingTresca(**dataclasses.asdict(cone.material))
    with pytest.raises(SimulationDiverged, match=r"mean stress of particle \d+ at"):
        Simulation(dataclasses.replace(cone, material=drifting)).advance(NOTICED_WITHIN)


@on(*SMALL)
def test_a_sound_run_is_left_alone(scene: Scene) -> None:
    """However its steps are parted, and however often it is looked at."""
    simulation = Simulation(scene)
    for steps in (1, NOTICED_WITHIN - 2, 1, 7, 2 * NOTICED_WITHIN):
        simulation.advance(steps)
        simulation.check()
    assert simulation.step_count == 3 * NOTICED_WITHIN + 7


def test_the_watch_counts_the_particles_in_the_grid(cone: Scene) -> None:
    simulation = Simulation(cone)
    simulation.travel_to(1.0)
    simulation.check()
    cell = simulation.array("particle.cell")
    assert simulation.particle_count == np.count_nonzero(cell[:, 0] >= 0)
    cell[:] = -1
    with pytest.raises(SimulationDiverged, match="no material point is left in the grid"):
        simulation.check()
