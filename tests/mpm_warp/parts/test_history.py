"""What soil has gone through since it entered; what the records of audited steps add to a run."""

import numpy as np
import pytest

from mpm_warp import EnergyBalance, History, Isotropic, Part, Scene, Simulation
from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.history import PLASTIC_STRAIN, displacement
from mpm_warp.plan.plan import AUDIT_INTERVAL
from tests.mpm_warp.conftest import assert_same_bits, cells_of


@pytest.mark.parametrize("part", [History(), EnergyBalance()])
def test_a_record_changes_no_bit_of_a_run(cone: Scene, part: Part) -> None:
    bare, kept = Simulation(cone), Simulation(cone.with_parts(part))
    for simulation in (bare, kept):
        simulation.advance(700)
    assert kept.travel > 0.2  # soil has entered
    assert_same_bits(bare, kept)
    used = {array for launch in kept.plan.launches for array in launch.arrays}
    assert set(kept.plan.arrays) == used
    # An ordinary step is the same, kernel by kernel: it has nothing to do for a record.
    assert [it.kernel for it in kept.plan.step] == [it.kernel for it in bare.plan.step]


def test_soil_enters_without_displacement_and_plastic_strain(cone: Scene) -> None:
    simulation = Simulation(cone.with_parts(History()))
    simulation.assign(PLASTIC_STRAIN, 1.0)
    before = simulation.array("layer.position").copy()
    while np.array_equal(simulation.array("layer.position"), before):
        simulation.advance(1)
    entered = simulation.array("layer.slots")
    moved = displacement(simulation, simulation.travel)
    # Of heights of some meters two roundings are left.
    np.testing.assert_allclose(moved[entered], 0.0, atol=1e-14)
    np.testing.assert_array_equal(simulation.array(PLASTIC_STRAIN)[entered], 0.0)
    present = simulation.array("particle.cell")[:, 0] >= 0
    present[entered] = False
    assert simulation.array(PLASTIC_STRAIN)[present].min() >= 1.0


def elastic_trial(stress: Floats, motion: Floats, clay: Isotropic) -> Floats:
    """R sigma R' + K tr e + 2 G dev e, by matrices."""
    cosine = np.sqrt(0.5 + 0.5 * motion[:, 6])
    sine = 0.5 * motion[:, 5] / cosine
    rotation = np.stack([np.stack([cosine, sine], -1), np.stack([-sine, cosine], -1)], -2)
    plane = np.stack([stress[:, [0, 2]], stress[:, [2, 1]]], axis=-2)
    turned = rotation @ plane @ np.swapaxes(rotation, -1, -2)
    parts = [turned[:, 0, 0], turned[:, 1, 1], turned[:, 0, 1], stress[:, 3]]
    volume = motion[:, 0] + motion[:, 1] + motion[:, 3]
    trial: Floats = np.stack(parts, axis=-1) + 2.0 * clay.shear_modulus * motion[:, :4]
    mean = (clay.bulk_modulus - 2.0 / 3.0 * clay.shear_modulus) * volume
    trial[:, [0, 1, 3]] += mean[:, None]
    return trial


def test_plastic_strain_is_a_sample_of_what_the_law_takes_from_the_trial_stress(
    cone: Scene,
) -> None:
    """Of every 16th step from the first, as many times over: by hand, in soil that stays."""
    simulation = Simulation(cone.with_parts(History()))
    clay = cone.material
    assert isinstance(clay, Isotropic)
    simulation.advance(480)  # so that soil yields
    expected = simulation.array(PLASTIC_STRAIN).copy()
    here = np.flatnonzero(simulation.array("particle.cell")[:, 1] > 2)
    for step in range(480, 480 + 2 * AUDIT_INTERVAL):
        stress, cell = simulation.array("particle.stress").copy(), cells_of(simulation)
        simulation.advance(1)
        if step % AUDIT_INTERVAL == 0:
            motion = simulation.array("cell.motion")[cell[here]]
            trial = elastic_trial(stress[here], motion, clay)
            change = trial - simulation.array("particle.stress")[here]
            normal = change[:, [0, 1, 3]] - change[:, [0, 1, 3]].mean(axis=1, keepdims=True)
            square = 0.5 * np.sum(normal**2, axis=1) + change[:, 2] ** 2
            expected[here] += AUDIT_INTERVAL * np.sqrt(square) / clay.shear_modulus
    stayed = here[simulation.array("particle.cell")[here, 1] > 2]
    recorded = simulation.array(PLASTIC_STRAIN)[stayed]
    assert recorded.max() > 0.01
    # Roundings of the stress, some 10 su, over G, in each of the records.
    np.testing.assert_allclose(recorded, expected[stayed], atol=1e-12)


def test_a_cavity_has_the_plastic_strain_of_its_expansion(cavity: Scene) -> None:
    """A cylinder in soil of constant volume: gamma = 2 ln(r / r0), less su / G, which is elastic.

    The volume between a point and the wall, of radius a, stays: r^2 - a^2 = r0^2 - 1. A velocity as
    1 / r, linear between nodes w apart, is too large by (w / 2 r)^2 at most, a strain of one cell
    off by a third of that: here w = r / 2 at the wall.
    """
    simulation = Simulation(cavity.with_parts(History()))
    simulation.advance_to(40.0)
    moved = displacement(simulation, 0.0)[:, 0]
    radius = simulation.array("particle.position")[:, 0]
    exact = 2.0 * np.log(radius / (radius - moved)) - 0.01
    column = simulation.array("particle.cell")[:, 0]
    wall = simulation.array("wall.motion")[0, 2]
    near = column < 2
    freed = radius[near] ** 2 - (radius - moved)[near] ** 2
    assert freed.mean() == pytest.approx(wall**2 - 1.0, rel=1.0 / 16.0)
    recorded = simulation.array(PLASTIC_STRAIN)
    for cell in range(2):
        there = column == cell
        assert recorded[there].mean() == pytest.approx(exact[there].mean(), rel=1.0 / 48.0)
