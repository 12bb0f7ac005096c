"""The motion of the window: ramp, approach and final speed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mpm_warp.watch.health import WindowOverfull
from mpm_warp.penetration import Penetration
from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.simulation import Simulation
from mpm_warp.travel import Travel
from mpm_warp.parts.window import Approach, Window

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


def test_a_run_takes_the_steps_that_its_plan_says() -> None:
    """But for two: in a step the speed is that at its begin.

    That costs half a step where the speed rises, gains 0.5 ln 4 where it falls to a quarter; and
    either number is a whole one.
    """
    cone = ConePenetration(
        cells_per_radius=1.5, domain_radius=10, domain_above=5, domain_below=5, penetration=12,
        steady_tolerance=0,
    )  # fmt: skip
    result = cone.run()
    assert abs(int(result.step_count) - int(result.step_count_bound)) <= 2
    assert cone.step_count_bound(cone.plan()) == int(result.step_count_bound)  # type: ignore[arg-type]


def test_the_window_stops_at_the_first_step_beyond_a_distance(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And takes its steps in one go wherever its speed is the final one."""
    cone = ConePenetration(
        cells_per_radius=1.5, domain_radius=10, domain_above=4, domain_below=4, penetration=12
    )
    simulation = Simulation(cone.build()[0])
    window = simulation.scene.window
    assert window is not None
    assert window.approach is not None
    travel, goes = Travel(simulation), []
    advance = simulation.advance
    monkeypatch.setattr(simulation, "advance", lambda count: (goes.append(count), advance(count)))
    radius = cone.cone_radius
    for distance in np.linspace(0.5, 11.5, 23) * radius:
        goes.clear()
        layers = travel._layer_count
        travel.advance_to(distance)
        # Of all speeds that it may have had in its last step, the highest.
        last = window.highest_speed_from(distance - 0.1 * radius) * simulation.plan.time_step
        assert distance <= travel.distance < distance + last
        if distance > window.approach.travel + 0.5 * radius:
            assert len(goes) <= travel._layer_count - layers + 1


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
def test_a_hurried_approach_ends_at_the_same_cone_factor(adhesion_factor: float) -> None:
    """Both end where they are steady to 0.3 %, so they may differ by twice as much."""
    cone = ConePenetration(cells_per_radius=2, adhesion_factor=adhesion_factor)
    slow = float(dataclasses.replace(cone, approach=0.0).run().cone_factor)
    assert float(cone.run().cone_factor) == pytest.approx(slow, rel=0.006)


def test_an_approach_that_nothing_is_left_of_is_left_out() -> None:
    def approach(**changes: float) -> Approach | None:
        window = ConePenetration(**changes).build()[0].window  # type: ignore[arg-type]
        assert window is not None
        return window.approach

    assert approach() is not None
    assert approach(penetration=7) is None  # its last five radii are at the final speed
    assert approach(approach=0) is None
    assert approach(speed_ratio=0.2, approach_speed_ratio=0.1) is None


def test_soil_that_piles_up_ends_the_run_and_leaves_its_curves() -> None:
    cone = ConePenetration(
        cells_per_radius=2, domain_radius=10, domain_above=4, domain_below=4, penetration=5
    )
    scene, surface = cone.build()
    simulation = Simulation(scene)
    spare = simulation.array("particle.cell")[:, 0] < 0
    for name in ("cell", "position", "mass"):  # as if every place were taken
        values = simulation.array(f"particle.{name}")
        values[spare] = values[~spare][: spare.sum()]
    penetration = Penetration(surface=surface, greatest=5.0, unsteady=2.0, tolerance=0.0)
    with pytest.raises(WindowOverfull, match="more soil has stayed in the window") as end:
        penetration.run(simulation, progress=None)
    assert end.value.status == "diverged"
    assert end.value.history is not None
    assert end.value.history.sizes["penetration"] == len(penetration.forces) > 0
