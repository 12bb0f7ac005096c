"""The time loop, and from a run to its dataset."""

from typing import NoReturn

import numpy as np
import pytest
import xarray as xr

from mpm_warp import Samples, Scene, Simulation, SimulationDiverged, WindowOverfull, follow
from mpm_warp.execution.replay import DeviceRun
from mpm_warp.grid.fitted import Floats
from mpm_warp.results import variable
from mpm_warp.sampling import ContactForces, even_steps
from mpm_warp.simulation import CHECK_INTERVAL


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


def steps_of(simulation: Simulation, name: str = "steps") -> Samples:
    """Takes down the steps taken by then."""

    def curve(steps: Floats) -> xr.Dataset:
        return xr.Dataset({name: variable(steps, meaning="steps taken", dims=("sample",))})

    return Samples(lambda: [simulation.step_count], curve)


def test_every_sampler_takes_a_sample_at_every_moment(floating: Scene) -> None:
    simulation = Simulation(floating)
    samplers = [steps_of(simulation, name) for name in ("first", "second")]
    told = list[float]()
    result = follow(simulation, [5, 7, 7, 20], simulation.advance_to_step, samplers, told.append)
    assert told == [0.25, 0.5, 0.75, 1.0]
    assert result.first.values.tolist() == result.second.values.tolist() == [5, 7, 7, 20]
    assert result.first.attrs == {"units": "1", "long_name": "steps taken"}


def test_a_run_that_is_over_goes_no_further_and_is_done(floating: Scene) -> None:
    simulation, told = Simulation(floating), list[float]()
    sampler = steps_of(simulation)
    follow(
        simulation,
        [5, 10, 15, 20],
        simulation.advance_to_step,
        [sampler],
        told.append,
        is_over=lambda: simulation.step_count >= 10,
    )
    assert sampler.dataset().steps.values.tolist() == [5, 10]
    assert told == [0.25, 0.5, 1.0]


@pytest.mark.parametrize(
    ("wrong_at", "is_noticed", "samples"),
    [(15, True, [5, 10]), (20, False, [5, 10, 15, 20])],
    ids=["by the watch", "by the last look"],
)
def test_a_run_that_diverges_leaves_its_curves_up_to_there(
    floating: Scene, wrong_at: int, is_noticed: bool, samples: list[int]
) -> None:
    """It is looked at once more before its results are given."""
    simulation, told = Simulation(floating), list[float]()

    def reach(step: float) -> None:
        simulation.advance_to_step(int(step))
        if step == wrong_at:
            simulation.array("particle.stress")[3] = np.nan
            if is_noticed:
                simulation.check()

    with pytest.raises(SimulationDiverged, match="stress of particle 3") as end:
        follow(simulation, [5, 10, 15, 20], reach, [steps_of(simulation)], told.append)
    assert end.value.curves.steps.values.tolist() == samples
    assert told == [0.25, 0.5, 0.75][: len(samples)]


def test_a_run_that_was_interrupted_in_its_steps_does_not_go_on(
    floating: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its threads, or soil that enters, may have stopped anywhere; it can still be looked at."""
    simulation = Simulation(floating)
    simulation.advance(5)
    with monkeypatch.context() as patch:
        patch.setattr(DeviceRun, "replay", interrupted)
        with pytest.raises(KeyboardInterrupt):
            simulation.advance(5)
    with pytest.raises(RuntimeError, match="interrupted in its steps and cannot go on"):
        simulation.advance(1)
    assert simulation.step_count == 5
    assert np.isfinite(simulation.array("particle.position")).all()


def interrupted(run: DeviceRun, steps: range, threads: int) -> NoReturn:
    raise KeyboardInterrupt


def test_soil_that_piles_up_ends_the_run_and_leaves_its_curves(cone: Scene) -> None:
    simulation = Simulation(cone)
    spare = simulation.array("particle.cell")[:, 0] < 0
    for name in ("cell", "position", "mass"):  # as if every slot were taken
        values = simulation.array(f"particle.{name}")
        values[spare] = values[~spare][: spare.sum()]
    sampler = steps_of(simulation)
    with pytest.raises(WindowOverfull, match="more soil has stayed in the window") as end:
        follow(simulation, np.linspace(0.01, 5.0, 500).tolist(), simulation.travel_to, [sampler])
    assert end.value.status == "diverged"
    assert "more spare slots" in simulation.plan.remedy
    assert str(end.value).endswith(simulation.plan.remedy)
    assert "\n" not in str(end.value)
    assert end.value.curves.sizes["sample"] == sampler.dataset().sizes["sample"] > 0


def test_contact_forces_are_means_since_they_were_last_taken(cone: Scene) -> None:
    """Impulses of all steps in between over their time."""
    simulation, other = Simulation(cone), Simulation(cone)
    forces = ContactForces(simulation)
    for steps in (100, 30):
        ContactForces(simulation)  # takes nothing from others
        simulation.advance(steps)
        impulse = np.zeros_like(other.array("contact.impulse"))
        for _ in range(steps):
            other.assign("contact.impulse", 0.0)
            other.advance(1)
            impulse += other.array("contact.impulse")
        expected = impulse / (steps * simulation.plan.time_step)
        scale = np.abs(expected).max()
        assert scale > 0.0
        np.testing.assert_allclose(forces.take(), expected, rtol=1e-9, atol=1e-12 * scale)


@pytest.mark.parametrize(
    ("step_count", "expected"),
    [(100, [*range(5, 101, 5)]), (21, [*range(1, 11), *range(12, 22)]), (3, [1, 2, 3]), (1, [1])],
)
def test_even_steps_end_with_the_last_one(step_count: int, expected: list[int]) -> None:
    assert even_steps(step_count) == expected
