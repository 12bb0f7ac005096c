"""The watch: a fault planted in a sound run is noticed within 500 steps, and named."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp import health, planning
from mpm_warp.materials.materials import LinearElastic, PerfectlyPlastic, Tresca, VonMises
from mpm_warp.parameters import from_mapping
from mpm_warp.penetration import Penetration
from mpm_warp.plan.plan import AUDIT_INTERVAL
from mpm_warp.planning import make_plan
from mpm_warp.precision import Precision
from mpm_warp.scenes import scene_class, scene_names
from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.simulation import CHECK_INTERVAL, Simulation, TimeLoop

NOTICED_WITHIN = 500
BLOCK = 3
"""Cells along the side of a block that is watched for its soil."""
GRID_SCENES = [name for name in scene_names() if scene_class(name)().plan() is not None]
SOIL_SCENES = [name for name in GRID_SCENES if scene_class(name)().simulated_scene() is not None]


def started(name: str) -> TimeLoop:
    """A scene at its defaults, a few steps on.

    Without an approach: at its speed a row of cells runs empty below, where no soil is let in.
    """
    scene = from_mapping(scene_class(name), {"approach": 0} if name == "cone_penetration" else {})
    soil = scene.simulated_scene()
    plan = scene.plan()
    assert plan is not None
    loop = TimeLoop(plan) if soil is None else Simulation(soil)
    loop.advance(3)
    return loop


def particle_in(loop: TimeLoop) -> int:
    return loop.plan.particle_count // 2


def plant(loop: TimeLoop, array: str, particle: int, value: float) -> None:
    """Give a particle a value, its first component only: above a window soil leaves by right."""
    values = loop.array(array)
    values.reshape(len(values), -1)[particle, 0] = value


def test_watch_looks_often_enough() -> None:
    assert CHECK_INTERVAL <= NOTICED_WITHIN


@pytest.mark.parametrize("name", SOIL_SCENES)
@pytest.mark.parametrize(
    ("array", "value", "named"),
    [
        ("particle.stress", np.nan, "stress"),
        ("particle.velocity", 1e30, "velocity"),
        ("particle.position", 1e6, "position"),
        ("particle.mass", 0.0, "mass"),
    ],
)
def test_planted_fault_is_noticed_and_its_particle_named(
    name: str, array: str, value: float, named: str
) -> None:
    loop = started(name)
    particle = particle_in(loop)
    plant(loop, array, particle, value)
    with pytest.raises(health.SimulationDiverged) as noticed:
        loop.advance(NOTICED_WITHIN)
    message = str(noticed.value)
    assert f"{named} of particle {particle} at" in message
    assert "healthy at step 0" in message
    assert noticed.value.status == "diverged"
    assert "\n" not in message


@pytest.mark.parametrize(
    ("array", "value"),
    [
        ("particle.stress", np.nan),
        ("particle.velocity", 1e30),
        ("particle.position", 1e6),
        ("particle.mass", 0.0),
    ],
)
def test_planted_fault_in_a_body_is_noticed(array: str, value: float) -> None:
    loop = started("sliding_block")
    plant(loop, array, 0, value)
    with pytest.raises(health.SimulationDiverged, match=r"of particle \d+ at"):
        loop.advance(NOTICED_WITHIN)


@pytest.mark.parametrize("name", GRID_SCENES)
def test_doubled_time_step_is_noticed_in_every_scene(name: str) -> None:
    """Twice the longest that is stable: some scenes take far shorter ones."""
    loop = started(name)
    loop.plan.time_step = 2.0 * loop.plan.longest_time_step
    with pytest.raises(health.SimulationDiverged, match="time step of"):
        loop.advance(NOTICED_WITHIN)


def test_speeds_that_grow_at_twice_the_stable_step_are_noticed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without the check of the step itself: what it does to the soil is noticed too."""
    monkeypatch.setattr("mpm_warp.simulation.check_time_step", lambda **_: None)
    soil = ConePenetration(cells_per_radius=2.0).simulated_scene()
    simulation = Simulation(replace(soil, time_step_fraction=2.5))
    with pytest.raises(health.SimulationDiverged, match=r"velocity of particle \d+ at"):
        simulation.advance(4 * NOTICED_WITHIN)


def test_stress_outside_the_yield_surface_is_noticed() -> None:
    simulation = Simulation(ConePenetration(cells_per_radius=2.0).simulated_scene())
    simulation.advance(10)
    simulation.array("particle.stress")[7, 2] = 1.001 * 20e3
    with pytest.raises(health.SimulationDiverged, match=r"stress of particle 7 .*yield surface"):
        simulation.check()


def test_cell_that_holds_more_soil_than_it_can_is_noticed() -> None:
    simulation = Simulation(ConePenetration(cells_per_radius=2.0).simulated_scene())
    simulation.array("particle.cell")[:200] = [3, 2]
    with pytest.raises(health.SimulationDiverged, match="soil in cell"):
        simulation.check()


def with_blocks(name: str) -> bool:
    """Whether a scene has cells around which there are others, whose soil leaves by no right."""
    scene = scene_class(name)().simulated_scene()
    assert scene is not None
    wide = min(scene.grid.row_count, scene.grid.column_count) > BLOCK
    return wide and not scene.free_surface


@pytest.mark.parametrize("name", list(filter(with_blocks, SOIL_SCENES)))
def test_cells_that_have_lost_their_soil_are_noticed(name: str) -> None:
    """Their particles are put into the cell beside them."""
    loop = started(name)
    loop.check()
    cell = loop.array("particle.cell")
    cell[np.all((cell >= 1) & (cell <= BLOCK), axis=1)] = [BLOCK + 1, 1]
    with pytest.raises(health.SimulationDiverged, match="soil in 3 x 3 cells from row"):
        loop.check()


def test_soil_may_leave_cells_where_it_may_part_from_the_surface() -> None:
    soil = ConePenetration(cells_per_radius=2.0, in_situ_stress=0.0).simulated_scene()
    simulation = Simulation(soil)
    cell = simulation.array("particle.cell")
    cell[np.all((cell >= 1) & (cell <= BLOCK), axis=1)] = [BLOCK + 1, 1]
    simulation.check()


def touches(name: str) -> bool:
    """Whether a scene has a surface from which soil parts by no right."""
    scene = scene_class(name)().simulated_scene()
    assert scene is not None
    return scene.contact is not None and scene.contact.in_situ_stress > 0.0


@pytest.mark.parametrize("name", list(filter(touches, SOIL_SCENES)))
def test_contact_that_is_lost_is_noticed(name: str) -> None:
    """It acts on nodes amid the soil instead of those of the surface."""
    loop = started(name)
    loop.advance(NOTICED_WITHIN - 10 - loop.step_count)  # before anything else goes wrong by it
    loop.array("contact.nodes")[:] = len(loop.array("node.mass")) // 2
    with pytest.raises(health.SimulationDiverged, match=r"contact is lost on \d+% of the"):
        loop.advance(NOTICED_WITHIN)


def test_parting_is_physics_where_the_ground_presses_less_than_soil_can_pull() -> None:
    """By the limit pressure of a sphere, 4/3 su (1 + ln 100) = 7.5 su, twice taken."""
    surface = ConePenetration().build()[1]
    strength, index = 1e3, 100.0
    material = Tresca(
        shear_modulus=index * strength, poissons_ratio=0.3, density=1.0, strength=strength
    )
    elastic = LinearElastic(shear_modulus=1e5, poissons_ratio=0.3, density=1.0)
    for in_situ, may_part in ((14e3, True), (16e3, False)):
        contact = replace(surface.contact, in_situ_stress=in_situ)
        assert contact.can_part(material, speed=0.0) is may_part
        assert contact.can_part(elastic, speed=0.0)
        assert contact.can_part(material, speed=100.0)


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_drift_of_the_mean_stress_is_noticed(
    precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A return to the yield surface that adds a thousandth of a strength a step to the pressure."""
    plain = planning.make_yielding

    def make_drifting(material: LinearElastic, precision: Precision) -> Any:
        real, vec4 = precision.real, precision.vec4
        yielding = plain(material, precision)

        @wp.func
        def drifting(stress: vec4, strength: real) -> vec4:
            added = real(1e-3) * strength
            return yielding(stress, strength) + vec4(added, added, real(0.0), added)

        return drifting

    soil = ConePenetration(cells_per_radius=2.0, precision=precision).simulated_scene()
    Simulation(soil).advance(NOTICED_WITHIN)
    monkeypatch.setattr(planning, "make_yielding", make_drifting)
    with pytest.raises(health.SimulationDiverged, match=r"mean stress of particle \d+ at"):
        Simulation(soil).advance(NOTICED_WITHIN)


def test_a_sound_run_is_left_alone_and_its_energy_error_recorded(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What the transfers made of the penetrometer's work: they dissipate noise, create nothing."""
    expected: list[float] = []
    run = Penetration.run

    def noted(penetration: Penetration, simulation: Simulation, progress: Any) -> None:
        run(penetration, simulation, progress)
        expected.append(simulation.transfer_energy / penetration.work)

    monkeypatch.setattr(Penetration, "run", noted)
    result = ConePenetration(cells_per_radius=2.0, penetration=2.0).run()
    assert [float(result.energy_error)] == expected
    assert expected[0] < 0.0


def test_energy_audit_is_a_sample_of_what_the_transfers_do() -> None:
    """Of every 16th step from the first, as many times over: by hand."""
    soil = ConePenetration(cells_per_radius=2.0, approach=0.0).simulated_scene()
    simulation = Simulation(soil)
    created, left = [], 0.0
    for _ in range(960):
        simulation.advance(1)
        mass, motion = simulation.array("node.mass"), simulation.array("node.motion")
        created.append(0.5 * float(mass @ np.sum(motion[:, 2:] ** 2, axis=1)) - left)
        left = 0.5 * float(mass @ np.sum(motion[:, :2] ** 2, axis=1))
    sampled = AUDIT_INTERVAL * sum(created[::AUDIT_INTERVAL])
    assert simulation.transfer_energy == pytest.approx(sampled, rel=1e-9)


def test_audit_costs_nothing_where_it_is_not_asked_for() -> None:
    soil = ConePenetration(cells_per_radius=2.0).simulated_scene()
    plan = make_plan(replace(soil, energy_audit=False))
    assert plan.audited_step == []
    assert "transfer.energy" not in plan.arrays


@pytest.mark.parametrize("criterion", [Tresca, VonMises])
def test_yield_excess(criterion: type[PerfectlyPlastic]) -> None:
    material = criterion(shear_modulus=1.0, poissons_ratio=0.3, density=1.0, strength=2.0)
    shear = np.array([[5.0, 5.0, 2.0, 5.0], [5.0, 5.0, 3.0, 5.0], [1.0, 1.0, 0.0, 1.0]])
    np.testing.assert_allclose(health.yield_excess(shear, material), [0.0, 0.5, -1.0], atol=1e-12)


def test_run_whose_transfers_dissipate_much_is_no_result() -> None:
    """Stiff soil in coarse cells at a third of the shear wave speed."""
    fast = ConePenetration(
        rigidity_index=3000.0, speed_ratio=0.3, cells_per_radius=1.0, penetration=3.0
    )
    with pytest.raises(health.InaccurateRun, match=r"took \d+\.\d% of the penetrometer's work"):
        fast.run()


@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_yield_is_watched_to_rounding_of_the_stress_and_no_further(precision: type) -> None:
    """Under a mean stress of 1e4 su, what single precision can tell is 1e-3 su."""
    material = Tresca(shear_modulus=1e6, poissons_ratio=0.3, density=1.0, strength=1e3)
    mean, eps = 1e7, float(np.finfo(precision).eps)

    def look(beyond: float) -> None:
        radius = 1e3 * (1.0 + beyond)
        stress = np.array([[mean + radius, mean - radius, 0.0, mean]], dtype=precision)
        position = np.zeros((1, 2))
        number = np.array([7], dtype=np.int32)
        health.check_yield(number=number, position=position, stress=stress, material=material)

    look(beyond=10 * eps * mean / 1e3)
    with pytest.raises(health.Fault, match="stress of particle 7"):
        look(beyond=200 * eps * mean / 1e3)
