"""The energy audit, by hand; the energy balance: works of nodes, cells and points, by hand."""

import dataclasses

import numpy as np
import pytest

from mpm_warp import EnergyBalance, LinearElastic, Scene, SceneError, Simulation, SurfaceContact
from mpm_warp.parts.energy import OF_CELLS, OF_NODES, OF_POINTS
from mpm_warp.plan.plan import AUDIT_INTERVAL
from mpm_warp.planning import make_plan
from mpm_warp.sampling import transferred_energy
from tests.mpm_warp.conftest import nodal_forces

ROUNDING = 1e-9
"""What sums over nodes and steps are exact to, generously."""


def test_energy_audit_is_a_sample_of_what_the_transfers_do(cone: Scene) -> None:
    """Of every 16th step from the first, as many times over: by hand."""
    simulation = Simulation(cone)
    created, left = [], 0.0
    for _ in range(960):
        simulation.advance(1)
        mass, velocity = simulation.array("node.mass"), simulation.array("node.velocities")
        created.append(0.5 * float(mass @ np.sum(velocity[:, 2:] ** 2, axis=1)) - left)
        left = 0.5 * float(mass @ np.sum(velocity[:, :2] ** 2, axis=1))
    sampled = AUDIT_INTERVAL * sum(created[::AUDIT_INTERVAL])
    assert transferred_energy(simulation) == pytest.approx(sampled, rel=1e-9)
    assert sampled < 0.0


def test_an_audited_step_is_a_step_with_two_launches_more(cone: Scene) -> None:
    """The energy left before it, and that which has arrived when nodes know their velocity."""
    plan = make_plan(cone)
    names = [launch.name for launch in plan.audited_step]
    assert [it for it in plan.audited_step if it.name != "kinetic_energy"] == plan.step
    first, second = (at for at, name in enumerate(names) if name == "kinetic_energy")
    assert first == 0
    assert names[second - 1] == "momentum"


@pytest.fixture
def balanced(cone: Scene) -> Scene:
    return cone.with_parts(EnergyBalance())


def works_by_hand(simulation: Simulation) -> dict[str, float]:
    """Of the step to come: works at the nodes by what the body bears and what cells press with."""
    scene = simulation.scene
    assert isinstance(scene, Scene)
    contact, grid = scene[SurfaceContact], scene.grid
    speed = simulation.array("window.motion")[1]
    simulation.assign("contact.impulse", 0.0)
    viscous = grid.cell_volumes * simulation.array("cell.viscosity")
    viscous = viscous * simulation.array("cell.dilation_rate") ** 2 * simulation.plan.time_step
    simulation.advance(1)
    velocities, mass = simulation.array("node.velocities"), simulation.array("node.mass")
    least = np.maximum(mass, simulation.array("node.least_mass"))
    after, before = velocities[:, :2], velocities[:, 2:4]
    middle = 0.5 * (after + before)
    normals = contact.normals
    along = np.stack([normals[:, 1], -normals[:, 0]], axis=-1)
    normal, shear = simulation.array("contact.impulse").T
    on_body = normal[:, None] * normals + shear[:, None] * along
    by_stress = simulation.plan.time_step * nodal_forces(grid, simulation.array("cell.stress"))
    of_stress = float(np.sum(by_stress * middle))
    kept = float(np.sum((mass / least - 1.0)[:, None] * by_stress * middle))
    kinetic = 0.5 * float(mass @ np.sum(after**2 - before**2, axis=1))
    to_soil = -float(np.sum(on_body * middle[contact.nodes]))
    return {
        "body": float(on_body[:, 1].sum()) * speed,
        "to_soil": to_soil,
        "ground": kinetic - to_soil - of_stress - kept,
        "kinetic": kinetic,
        "least_mass": kept,
        "viscous": float(viscous.sum()),
        "of_stress": of_stress,
    }


def test_works_at_nodes_and_in_cells_are_those_of_the_audited_steps(balanced: Scene) -> None:
    """Of every 16th step from the first, whatever is between."""
    simulation = Simulation(balanced)
    works = []
    for _ in range(60):
        works.append(works_by_hand(simulation))
        simulation.advance(AUDIT_INTERVAL - 1)
    sums = {name: sum(it[name] for it in works) for name in works[0]}
    recorded = [*simulation.array(OF_NODES).sum(axis=0), simulation.array(OF_CELLS).sum()]
    for name, value in zip(sums, recorded, strict=False):
        assert value == pytest.approx(sums[name], abs=ROUNDING * sums["body"]), name
    assert sums["body"] > sums["to_soil"] > 0.0  # what is left slides
    assert sums["ground"] != 0.0
    assert sums["viscous"] > 0.0


def left_between_nodes_and_points(scene: Scene) -> float:
    """Work of stress at the nodes less that in cells and points, over the work of the body."""
    simulation = Simulation(scene)
    simulation.travel_to(1.5)
    body, to_soil, ground, kinetic, least_mass = simulation.array(OF_NODES).sum(axis=0)
    of_stress = to_soil + ground - kinetic + least_mass
    in_soil = simulation.array(OF_CELLS).sum() + simulation.array(OF_POINTS).sum()
    return float((of_stress - in_soil) / body)


def test_the_work_of_stress_is_that_in_cells_and_points(balanced: Scene) -> None:
    """But for what stress changes within a step, which goes with its length."""
    coarse, fine = (
        abs(left_between_nodes_and_points(dataclasses.replace(balanced, time_step_fraction=it)))
        for it in (0.8, 0.2)
    )
    assert coarse < 0.01
    assert fine < 0.5 * coarse


def test_elastic_soil_has_no_plastic_work(balanced: Scene) -> None:
    soil = LinearElastic(shear_modulus=2e6, poissons_ratio=0.3, density=1700.0)
    scene = dataclasses.replace(balanced, material=soil)
    simulation = Simulation(scene)
    simulation.travel_to(0.5)
    plastic, elastic = simulation.array(OF_POINTS).sum(axis=0)
    assert elastic > 0.0
    assert abs(plastic) < ROUNDING * elastic
    assert abs(left_between_nodes_and_points(scene)) < 0.01


def test_a_balance_needs_a_bulk_viscosity(balanced: Scene) -> None:
    with pytest.raises(SceneError, match=r"^EnergyBalance: not without a bulk_viscosity$"):
        dataclasses.replace(balanced, bulk_viscosity=None)
