"""How fast a run is: what is measured of it."""

from mpm_warp.scenes.step_cost import StepCost


def test_less_physics_has_fewer_stages() -> None:
    stages = {
        physics: {launch.name for launch in StepCost(physics=physics, size=600).plan().step}
        for physics in ("cone", "plastic", "elastic")
    }
    left_out = {"surface_contact", "moving_side", "moving_ends", "advance_window"}
    assert stages["cone"] - stages["plastic"] == left_out
    assert stages["plastic"] == stages["elastic"]


def test_cases_that_are_computed_together_are_measured_together() -> None:
    result = StepCost(size=600, cases=3, samples=2, sample_time=0.01).run()
    assert float(result.update_rate) > 0
    # Of one of them; no stage is clocked, because other cases share its launches.
    assert float(result.particle_updates) < 3 * float(result.particle_count * result.step_count)
    assert "stage_time" not in result
    assert "thread_gain" not in result
