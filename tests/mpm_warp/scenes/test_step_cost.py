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
