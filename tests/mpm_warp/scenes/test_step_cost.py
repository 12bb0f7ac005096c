"""How fast a run is: what is measured of it."""

from types import SimpleNamespace
from typing import Any

import pytest

from mpm_warp import SceneError, StepCost


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
