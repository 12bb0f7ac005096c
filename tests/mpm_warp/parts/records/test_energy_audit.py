"""The energy audit: a sample of what the transfers do to the kinetic energy."""

from __future__ import annotations

import numpy as np
import pytest

from mpm_warp.parts.energy_audit import EnergyAudit
from mpm_warp.plan.plan import AUDIT_INTERVAL
from mpm_warp.planning import make_plan
from mpm_warp.sampling import transferred_energy
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation


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


def test_audit_costs_nothing_where_it_is_not_asked_for(cone: Scene) -> None:
    plan = make_plan(cone.without(EnergyAudit))
    assert plan.audited_step == []
    assert "transfer.energy" not in plan.arrays


def test_an_audited_step_is_a_step_with_two_launches_more(cone: Scene) -> None:
    """The energy left before it, and that which has arrived when nodes know their velocity."""
    plan = make_plan(cone)
    names = [launch.name for launch in plan.audited_step]
    assert [it for it in plan.audited_step if it.name != "kinetic_energy"] == plan.step
    first, second = (at for at, name in enumerate(names) if name == "kinetic_energy")
    assert first == 0
    assert names[second - 1] == "momentum"
