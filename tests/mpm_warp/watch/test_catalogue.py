"""The watch on every scene of the catalogue: faults planted in it are noticed within 500 steps."""

import functools
from typing import Any

import numpy as np
import pytest

from mpm_warp.bodies.scene import BodyScene
from mpm_warp.errors import SimulationDiverged
from mpm_warp.parameters import Value
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.scene import Scene
from mpm_warp.scenes import scene_class, scene_names
from mpm_warp.simulation import Simulation

pytestmark = pytest.mark.slow

NOTICED_WITHIN = 500
BLOCK = 3
"""Cells along the side of a block that is watched for its soil."""
PARAMETERS: dict[str, dict[str, Value]] = {
    # With an approach a row of cells runs empty below at its speed, where no soil is let in.
    "cone_penetration": {"approach": 0},
    # So deep that the soil may not part from the penetrometer.
    "sounding": {"from_depth": 20, "to_depth": 21},
}
"""What a scene has in place of its defaults."""
SCENES = {name: scene_class(name).build.__annotations__["return"] for name in scene_names()}
"""What each scene builds: soil in a grid, bodies, or what is not watched."""
SOIL_SCENES = [name for name, kind in SCENES.items() if kind in (Scene, "Scene")]
BODY_SCENES = [name for name, kind in SCENES.items() if kind in (BodyScene, "BodyScene")]
FAULTS = [
    ("particle.stress", np.nan, "stress"),
    ("particle.velocity", 1e30, "velocity"),
    ("particle.position", 1e6, "position"),
    ("particle.mass", 0.0, "mass"),
]


@functools.cache
def composition(name: str) -> Any:
    """A scene of the catalogue, built once."""
    return scene_class(name)(**PARAMETERS.get(name, {})).build()


def started(name: str) -> Simulation:
    """A scene, a few steps on."""
    simulation = Simulation(composition(name))
    simulation.advance(3)
    return simulation


def plant(simulation: Simulation, array: str, particle: int, value: float) -> None:
    """Give a particle a value, its first component only: above a window soil leaves by right."""
    values = simulation.array(array)
    values.reshape(len(values), -1)[particle, 0] = value


@pytest.mark.parametrize("name", SOIL_SCENES)
@pytest.mark.parametrize(("array", "value", "named"), FAULTS)
def test_planted_fault_is_noticed_and_its_particle_named(
    name: str, array: str, value: float, named: str
) -> None:
    simulation = started(name)
    particle = simulation.plan.particle_count // 2
    plant(simulation, array, particle, value)
    with pytest.raises(SimulationDiverged) as noticed:
        simulation.advance(NOTICED_WITHIN)
    message = str(noticed.value)
    assert f"{named} of particle {particle} at" in message
    assert "healthy at step 0" in message
    assert noticed.value.status == "diverged"
    assert "\n" not in message


@pytest.mark.parametrize(("array", "value", "named"), FAULTS)
def test_planted_fault_in_a_body_is_noticed(array: str, value: float, named: str) -> None:
    simulation = started("sliding_block")
    plant(simulation, array, 0, value)
    with pytest.raises(SimulationDiverged, match=r"of particle \d+ at"):
        simulation.advance(NOTICED_WITHIN)


@pytest.mark.parametrize("name", [*SOIL_SCENES, *BODY_SCENES])
def test_doubled_time_step_is_noticed_in_every_scene(name: str) -> None:
    """Twice the longest that is stable: some scenes take far shorter ones."""
    simulation = started(name)
    simulation.plan.time_step = 2.0 * simulation.plan.longest_time_step
    with pytest.raises(SimulationDiverged, match="time step of"):
        simulation.advance(NOTICED_WITHIN)


def with_blocks(scene: Scene) -> bool:
    """Whether a scene has cells around which there are others, whose soil leaves by no right."""
    wide = min(scene.grid.row_count, scene.grid.column_count) > BLOCK
    return wide and scene.find(FreeSurface) is None


def touches(scene: Scene) -> bool:
    """Whether a scene has a surface from which soil parts by no right."""
    contact = scene.find(SurfaceContact)
    return contact is not None and contact.in_situ_stress > 0.0


def test_cells_that_have_lost_their_soil_are_noticed() -> None:
    """Their particles are put into the cell beside them."""
    names = [name for name in SOIL_SCENES if with_blocks(composition(name))]
    assert "cone_penetration" in names
    for name in names:
        simulation = started(name)
        simulation.check()
        cell = simulation.array("particle.cell")
        cell[np.all((cell >= 1) & (cell <= BLOCK), axis=1)] = [BLOCK + 1, 1]
        with pytest.raises(SimulationDiverged, match="soil in 3 x 3 cells from row"):
            simulation.check()


def test_contact_that_is_lost_is_noticed() -> None:
    """It acts on nodes amid the soil instead of those of the surface."""
    names = [name for name in SOIL_SCENES if touches(composition(name))]
    assert "cone_penetration" in names
    for name in names:
        simulation = started(name)
        # Before anything else goes wrong by it.
        simulation.advance(NOTICED_WITHIN - 10 - simulation.step_count)
        simulation.array("contact.nodes")[:] = len(simulation.array("node.mass")) // 2
        with pytest.raises(SimulationDiverged, match=r"contact is lost on \d+% of the"):
            simulation.advance(NOTICED_WITHIN)
