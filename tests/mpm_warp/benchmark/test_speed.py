"""How fast a run is: what is measured of it."""

from __future__ import annotations

import threading
from itertools import count

import pytest

from mpm_warp.benchmark.clocks import StageClock
from mpm_warp.benchmark.speed import Run, Sample, ThreadGain
from mpm_warp.scenes.benchmark.step_cost import StepCost
from mpm_warp.simulation import Simulation


def test_gains_are_over_one_thread_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = Simulation(StepCost(physics="elastic", size=600).build())
    run = Run(simulation, simulation.advance)
    number, meeting = count(), threading.Barrier(2)

    def sample(self: Run, step_count: int) -> Sample:
        updates = (100, 70, 80)[(this := next(number))]
        if this > 0:  # two runs, at the same time
            meeting.wait(timeout=60.0)
        return Sample(steps=step_count, updates=updates, seconds=1.0)

    monkeypatch.setattr(Run, "sample", sample)
    companion = ThreadGain([run, run])
    companion.after_sample(Sample(steps=10, updates=130, seconds=1.0))
    gains = companion.dataset()
    assert float(gains.thread_gain) == 1.3
    assert float(gains.core_gain) == 1.5


def test_less_physics_has_fewer_stages() -> None:
    stages = {
        physics: {launch.name for launch in StepCost(physics=physics, size=600).plan().step}
        for physics in ("cone", "plastic", "elastic")
    }
    left_out = {"surface_contact", "moving_side", "moving_ends", "advance_window"}
    assert stages["cone"] - stages["plastic"] == left_out
    assert stages["plastic"] == stages["elastic"]


def test_the_clock_tells_where_the_time_of_a_step_goes() -> None:
    simulation = Simulation(StepCost(physics="elastic", size=5000).build())
    before = simulation.array("particle.position").copy()
    times = StageClock(simulation).time_steps(20)
    stages = times.stages
    assert list(stages) == [it.name for it in simulation.plan.step]
    assert 0 < times.launching < sum(stages.values())
    assert (simulation.array("particle.position") == before).all()  # at rest


def test_cases_that_are_computed_together_are_measured_together() -> None:
    result = StepCost(size=600, cases=3, samples=2, sample_time=0.01).run()
    assert float(result.update_rate) > 0
    # Of one of them; no stage is clocked, because other cases share its launches.
    assert float(result.particle_updates) < 3 * float(result.particle_count * result.step_count)
    assert "stage_time" not in result
    assert "thread_gain" not in result
