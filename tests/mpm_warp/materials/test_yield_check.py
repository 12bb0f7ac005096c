"""The kernel that finds stresses outside the yield surface: to rounding, and no further."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.errors import SimulationDiverged
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.yield_check import BLOCK
from mpm_warp.planning import make_plan
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation

STRENGTH = 1e3
CLAY = Tresca(shear_modulus=1e6, poissons_ratio=0.3, density=1e3, strength=STRENGTH)


def clay_of(floating: Scene, **changes: object) -> Simulation:
    return Simulation(dataclasses.replace(floating, material=CLAY, **changes))


def test_yield_is_watched_to_rounding_of_the_stress_and_no_further(floating: Scene) -> None:
    """Under a mean stress of 1e4 su the rounding is that of the mean stress."""
    simulation = clay_of(floating)
    mean, eps = 1e7, float(np.finfo(float).eps)

    def look(beyond: float) -> None:
        radius = STRENGTH * (1.0 + beyond)
        simulation.array("particle.stress")[7] = [mean + radius, mean - radius, 0.0, mean]
        simulation.check()

    look(beyond=10 * eps * mean / STRENGTH)
    with pytest.raises(SimulationDiverged, match="stress of particle 7"):
        look(beyond=200 * eps * mean / STRENGTH)


def test_the_worst_particle_of_every_block_is_found(floating: Scene) -> None:
    """How far it is outside, over the strength; blocks without one are within."""
    simulation = clay_of(floating, particles_per_side=10)
    count = simulation.plan.particle_count
    planted = {5: 1.5, 6: 1.2, BLOCK: 1.1, count - 1: 2.0}
    for particle, factor in planted.items():
        simulation.array("particle.stress")[particle, 2] = factor * STRENGTH
    simulation.launch(simulation.plan.between_steps["yield_check"])
    margin = simulation.array("yield.margin")
    expected = np.full(-(-count // BLOCK), -1.0)
    expected[[0, 1, -1]] = [0.5, 0.1, 1.0]
    np.testing.assert_allclose(margin, expected, atol=1e-12)
    assert simulation.array("yield.particle")[[0, 1, -1]].tolist() == [5, BLOCK, count - 1]


def test_slots_that_hold_no_particle_are_not_looked_at(floating: Scene) -> None:
    simulation = clay_of(floating)
    simulation.array("particle.stress")[3, 2] = 10.0 * STRENGTH
    simulation.array("particle.cell")[3] = -1
    simulation.launch(simulation.plan.between_steps["yield_check"])
    assert simulation.array("yield.margin").max() < 0.0


def test_a_material_that_never_yields_has_no_check(floating: Scene) -> None:
    assert isinstance(floating.material, LinearElastic)
    plan = make_plan(floating)
    assert plan.between_steps == {}
    assert not {"yield.margin", "yield.particle"} & set(plan.arrays)
