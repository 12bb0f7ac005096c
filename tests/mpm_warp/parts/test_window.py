"""The motion of the window: ramp, approach and final speed."""

import dataclasses

import numpy as np
import pytest

from mpm_warp.parts.window import Approach, Window
from mpm_warp.scene import Scene
from mpm_warp.simulation import Simulation

HURRIED = Window(
    speed=1.0,
    ramp_travel=1.0,
    spare_fraction=0.1,
    approach=Approach(speed=4.0, travel=8.0, slowing_travel=2.0),
)


def speed_at(window: Window, travel: float) -> float:
    """By travel: the square root of it in the ramp, linear in it where the speed falls."""
    fast = window.first_speed
    risen = fast * min(1.0, np.sqrt(travel / window.ramp_travel))
    if window.approach is None:
        return float(risen)
    left = (window.approach.travel - travel) / window.approach.slowing_travel
    return float(min(risen, window.speed + np.clip(left, 0, 1) * (fast - window.speed)))


@pytest.mark.parametrize("window", [HURRIED, dataclasses.replace(HURRIED, approach=None)])
@pytest.mark.parametrize("travel", [0.5, 1.0, 3.0, 7.0, 8.0, 12.0])
def test_time_to_a_travel_is_the_integral_of_one_over_the_speed(
    window: Window, travel: float
) -> None:
    # Over the root of the travel, in which the speed of the ramp is linear.
    roots = (np.arange(10_000) + 0.5) / 10_000
    expected = np.mean([2 * root * travel / speed_at(window, travel * root**2) for root in roots])
    assert window.time_to(travel) == pytest.approx(expected, rel=1e-3)


def test_no_speed_is_above_the_highest_beyond_a_travel() -> None:
    for travel in np.linspace(0.01, 12, 50):
        ahead = [speed_at(HURRIED, place) for place in np.linspace(travel, 12, 100)]
        assert max(ahead) <= HURRIED.highest_speed_from(travel)


@pytest.fixture
def hurried(cone: Scene) -> Scene:
    """The cone of unit radius, with an approach at three times its speed."""
    approach = Approach(speed=3.0, travel=2.0, slowing_travel=1.0)
    return cone.with_parts(dataclasses.replace(cone[Window], approach=approach))


def test_a_run_takes_the_time_that_its_window_says(hurried: Scene) -> None:
    """But for two steps: in a step the speed is that at its begin."""
    simulation = Simulation(hurried)
    simulation.travel_to(4.0)
    steps = hurried[Window].time_to(4.0) / simulation.plan.time_step
    assert abs(simulation.step_count - steps) <= 2.0


def test_the_window_stops_at_the_first_step_beyond_a_distance(
    hurried: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And takes its steps in one go wherever its speed is the final one."""
    simulation = Simulation(hurried)
    window = hurried[Window]
    assert window is not None
    assert window.approach is not None
    goes: list[int] = []
    advance = simulation.advance
    monkeypatch.setattr(simulation, "advance", lambda count: (goes.append(count), advance(count)))
    for distance in np.linspace(0.25, 5.75, 23):
        goes.clear()
        simulation.travel_to(distance)
        # Of all speeds that it may have had in its last step, the highest.
        last = window.highest_speed_from(distance - 0.1) * simulation.plan.time_step
        assert distance <= simulation.travel < distance + last
        if distance > window.approach.travel + 0.5:
            assert len(goes) == 1


def test_a_distance_that_is_behind_is_not_travelled(hurried: Scene) -> None:
    simulation = Simulation(hurried)
    simulation.travel_to(0.5)
    steps = simulation.step_count
    simulation.travel_to(0.4)
    simulation.travel_to(simulation.travel)
    assert simulation.step_count == steps


def test_a_scene_without_a_window_does_not_travel(floating: Scene) -> None:
    simulation = Simulation(floating)
    with pytest.raises(ValueError, match="the scene has no window: nothing travels"):
        simulation.travel_to(1.0)
    with pytest.raises(ValueError, match="the scene has no window: nothing travels"):
        _ = simulation.travel
