"""A penetrometer that is pushed in: what it takes, against the forces and the way by hand."""

from __future__ import annotations

import numpy as np
import pytest
from mpm_warp.penetration import SAMPLE_SPACING, Penetration
from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.travel import Travel

from mpm_warp.grid.fitted import Floats
from mpm_warp.simulation import Simulation

ROUNDING = 1e-12
SMOOTH = ConePenetration(
    cells_per_radius=2, penetration=1, domain_radius=10, domain_above=4, domain_below=4
)


def test_forces_and_work_are_those_of_the_nodes_along_the_axis(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a smooth cone: normal forces times the upward part of their normals, times the way."""
    scene, surface = SMOOTH.build()
    simulation = Simulation(scene)
    taken: list[Floats] = []
    take = simulation.take_contact_forces

    def noted() -> Floats:
        taken.append(take())
        return taken[-1]

    monkeypatch.setattr(simulation, "take_contact_forces", noted)
    penetration = Penetration(surface=surface, greatest=1.0, unsteady=1.0, tolerance=0.0)
    travel, way, work = Travel(simulation), 0.0, 0.0
    for sample in range(1, 11):
        penetration.push_to(sample * SAMPLE_SPACING * SMOOTH.cone_radius, travel, simulation)
        upward = float(taken[-1][:, 0] @ surface.contact.normals[:, 1])
        assert penetration.forces[-1].upward == pytest.approx(upward, rel=ROUNDING)
        work += upward * (travel.distance - way)
        way = travel.distance
    assert len(taken) == 10
    assert penetration.work == pytest.approx(work, rel=ROUNDING)
    resistance = penetration.curves().penetration_resistance * 0.5 * SMOOTH.cone_radius**2
    np.testing.assert_allclose(resistance, [it.upward for it in penetration.forces], rtol=ROUNDING)
    assert work > 0.0
