"""The time step follows the critical one where that changes during a run."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from mpm_warp.errors import Fault
from mpm_warp.execution.batched import batch_key
from mpm_warp.plan.time_step import TimeStepControl
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.scene import Scene
from mpm_warp.simulation import CHECK_INTERVAL, Simulation


def following(now: float, critical: float, fraction: float = 0.8) -> float:
    control = TimeStepControl(first=0.8, fraction=fraction, critical=lambda array: critical)
    return control.following(now, np.zeros)


def test_the_time_step_stays_while_it_is_nearly_right() -> None:
    assert following(0.8, critical=1.0) == 0.8
    assert following(0.8, critical=1.0 / 1.02) == 0.8


def test_the_time_step_is_ready_for_the_critical_one_to_fall_on() -> None:
    assert following(0.8, critical=1.0 / 1.06) == pytest.approx(0.8 / 1.06**2)


def test_the_time_step_rises_again_up_to_the_first_one() -> None:
    control = TimeStepControl(first=0.8, fraction=0.8, critical=lambda array: float(array("")))
    found = iter([0.5, 0.5, 0.5 * 1.04, 0.5 * 1.06, 5.0])

    def array(name: str) -> NDArray[Any]:
        return np.array(next(found))

    steps = [control.following(step, array) for step in (0.4, 0.4, 0.4, 0.4, 0.4)]
    np.testing.assert_allclose(steps, [0.2, 0.4, 0.4, 0.4 * 1.06, 0.8])
    assert following(0.8, critical=5.0) == 0.8


def test_a_time_step_beyond_the_critical_one_is_a_fault() -> None:
    with pytest.raises(Fault, match=r"time step of 0\.8 s is beyond the stable 0\.79 s"):
        following(0.8, critical=0.79)
    # Where the scene asks for the critical one itself, small changes are followed.
    assert following(0.8, critical=0.75, fraction=1.0) == pytest.approx(0.75**2 / 0.8)


def test_only_what_can_change_is_looked_at(cone: Scene, cavity: Scene) -> None:
    assert make_plan(cone).control is None
    assert make_plan(cavity).control is not None


def test_a_plan_with_another_time_step_is_the_same_but_for_numbers(cavity: Scene) -> None:
    plan = make_plan(cavity)
    assert plan.control is not None
    other = make_plan(cavity, SHARE_COUNT, 0.3 * plan.time_step)
    assert other.time_step == 0.3 * plan.time_step
    assert batch_key(other) == batch_key(plan)


def test_time_is_the_sum_of_the_steps(cavity: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    factors = iter([0.5, 0.25, 0.5])

    def prescribed(control: TimeStepControl, step: float, array: Any) -> float:
        return control.first * next(factors, 0.5)

    monkeypatch.setattr(TimeStepControl, "following", prescribed)
    simulation = Simulation(cavity)
    first = simulation.plan.time_step
    simulation.advance(3 * CHECK_INTERVAL + 10)
    assert simulation.time == pytest.approx((CHECK_INTERVAL * 1.75 + 10 * 0.5) * first)
    assert simulation.array("wall.motion")[0, 0] == pytest.approx(simulation.time)
    simulation.advance_to(2.5 * CHECK_INTERVAL * first)
    assert simulation.time == pytest.approx(2.5 * CHECK_INTERVAL * first, abs=0.26 * first)
