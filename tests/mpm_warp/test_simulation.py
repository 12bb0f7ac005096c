"""The time loop: time, steps and looks of the watch, on scenes of a few cells."""

import numpy as np
import pytest

from mpm_warp.scene import Scene
from mpm_warp.simulation import CHECK_INTERVAL, Simulation


def test_the_same_scene_gives_the_same_bits(cone: Scene) -> None:
    stresses = []
    for _ in range(2):
        simulation = Simulation(cone)
        simulation.travel_to(0.6)
        stresses.append(simulation.array("particle.stress").copy())
    np.testing.assert_array_equal(*stresses)


def test_steps_time_and_updates_are_counted(floating: Scene) -> None:
    simulation = Simulation(floating)
    assert simulation.step_count == simulation.particle_updates == 0
    assert simulation.time == 0.0
    simulation.advance(3)
    simulation.advance_to_step(10)
    assert simulation.step_count == 10
    assert simulation.time == pytest.approx(10 * simulation.plan.time_step, rel=1e-14)
    assert simulation.particle_updates == 10 * simulation.plan.particle_count
    assert simulation.particle_count == simulation.plan.particle_count


def test_a_time_is_reached_to_the_nearest_step_and_never_gone_back_from(floating: Scene) -> None:
    simulation = Simulation(floating)
    step = simulation.plan.time_step
    for time, expected in ((10.4, 10), (10.6, 11), (3.0, 11), (1200.0, 1200)):
        simulation.advance_to(time * step)
        assert simulation.step_count == expected
    simulation.advance_to_step(7)
    assert simulation.step_count == 1200


def test_the_watch_looks_every_so_many_steps_however_they_are_parted(
    floating: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = Simulation(floating)
    looked_at: list[int] = []
    monkeypatch.setattr(simulation._watch, "look", lambda: looked_at.append(simulation.step_count))
    for steps in (1, CHECK_INTERVAL - 2, 1, 2 * CHECK_INTERVAL + 3):
        simulation.advance(steps)
    assert looked_at == [CHECK_INTERVAL, 2 * CHECK_INTERVAL, 3 * CHECK_INTERVAL]
    simulation.check()
    simulation.advance(CHECK_INTERVAL)
    assert looked_at[3:] == [3 * CHECK_INTERVAL + 3, 4 * CHECK_INTERVAL + 3]


def test_arrays_are_seen_and_given_values_by_name(floating: Scene) -> None:
    simulation = Simulation(floating)
    stress = simulation.array("particle.stress")
    assert stress.dtype == np.float64
    assert stress.shape == (simulation.plan.particle_count, 4)
    values = np.random.default_rng(8).normal(size=stress.shape)
    simulation.assign("particle.stress", values)
    np.testing.assert_array_equal(simulation.array("particle.stress"), values)
    simulation.assign("particle.stress", 3.0)
    np.testing.assert_array_equal(simulation.array("particle.stress"), 3.0)
    with pytest.raises(KeyError):
        simulation.array("particle.colour")
