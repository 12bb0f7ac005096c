"""Nodes that body and axis hold: the body bears the whole force of the soil."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mpm_warp.parts.boundaries import FarField
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.window import Window
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation

PRESSURE = 1e3


def impulse_at_the_tip(cone: Scene, share: float, *, held: bool) -> tuple[float, float]:
    """Normal impulse of one step under a uniform pressure, and time step, with so much soil left.

    Args:
        cone: with contact; its tip is the first of the nodes.
        share: of its mass that every particle keeps, in a stress that stays.
        held: whether the tip is a node that is held.
    """
    numbers = np.arange(int(held), dtype=np.int32)
    contact = dataclasses.replace(
        cone[SurfaceContact], speed=0.0, in_situ_stress=1e9, on_axis=numbers
    )
    simulation = Simulation(cone.without(Window, FarField).with_parts(contact))
    simulation.assign("particle.mass", share * simulation.array("particle.mass"))
    pressed = np.zeros((len(simulation.array("particle.mass")), 4))
    pressed[:, [0, 1, 3]] = -PRESSURE
    simulation.assign("particle.stress", pressed)
    simulation.advance(1)
    return float(simulation.array("contact.impulse")[0, 0]), simulation.plan.time_step


@pytest.mark.parametrize("share", [1.0, 0.5, 0.1])
def test_the_body_bears_what_the_least_mass_keeps_from_the_node(cone: Scene, share: float) -> None:
    """The force of the stress does not depend on how much soil there is to give it."""
    full, time_step = impulse_at_the_tip(cone, 1.0, held=True)
    assert full > 0.1 * PRESSURE * cone[SurfaceContact].normal_areas[0] * time_step
    assert impulse_at_the_tip(cone, share, held=True)[0] == pytest.approx(full, rel=1e-9)


def test_where_nothing_is_held_little_soil_gives_little_force(cone: Scene) -> None:
    full, _ = impulse_at_the_tip(cone, 1.0, held=False)
    assert full == impulse_at_the_tip(cone, 1.0, held=True)[0]
    assert impulse_at_the_tip(cone, 0.1, held=False)[0] < 0.3 * full
