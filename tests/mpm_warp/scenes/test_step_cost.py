"""How fast a run is: what is measured of it."""

from types import SimpleNamespace
from typing import Any

import pytest

from mpm_warp import SceneError, StepCost
from mpm_warp.scenes.step_cost import stage_bytes


def test_less_physics_has_fewer_stages() -> None:
    stages = {
        physics: {launch.name for launch in StepCost(physics=physics, size=600).plan().step}
        for physics in ("cone", "plastic", "elastic")
    }
    left_out = {"surface_contact", "moving_side", "moving_ends", "advance_window"}
    assert stages["cone"] - stages["plastic"] == left_out
    assert stages["plastic"] == stages["elastic"]


def test_threads_are_not_compared_with_a_gpu() -> None:
    gpu: Any = SimpleNamespace(device="cuda:0")
    with pytest.raises(SceneError, match="threads = 2 must be 1 on a GPU"):
        StepCost(threads=2).compute(lambda _: None, gpu)


def test_a_stage_moves_each_array_once_and_of_an_array_only_what_its_threads_reach() -> None:
    plan = StepCost(size=5000).plan()
    launches = {launch.name: launch for launch in plan.step}
    moved = stage_bytes(plan)
    each = {plan.arrays[name].byte_count for name in launches["cell_stress"].arrays}
    whole = sum(plan.arrays[name].byte_count for name in launches["cell_stress"].arrays)
    assert len(each) > 1
    assert moved["cell_stress"] == whole
    assert moved["advance_window"] < 0.1 * whole
