"""The motion of the window, and the bound of what points carry in it."""

import dataclasses

import numpy as np
import pytest

from mpm_warp import Approach, ConePenetration, Scene, Simulation, Window
from mpm_warp.parts.inflow import OVER_WINDOW, VELOCITY_BOUND

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


def test_a_distance_that_is_behind_is_not_travelled_nor_any_without_a_window(
    hurried: Scene, floating: Scene
) -> None:
    simulation, windowless = Simulation(hurried), Simulation(floating)
    simulation.travel_to(0.5)
    steps = simulation.step_count
    simulation.travel_to(0.4)
    simulation.travel_to(simulation.travel)
    assert simulation.step_count == steps
    for do in (lambda: windowless.travel_to(1.0), lambda: windowless.travel):
        with pytest.raises(ValueError, match="the scene has no window: nothing travels"):
            do()


def test_a_point_is_at_most_as_much_faster_than_the_soil_as_the_bound(cone: Scene) -> None:
    """The soil moves as a whole; points have velocities of their own, below and above the bound."""
    simulation = Simulation(cone)
    of_soil = np.array([0.3, -0.7])
    simulation.array("node.velocities")[:, :2] = of_soil
    present = simulation.array("particle.cell")[:, 0] >= 0
    bound = OVER_WINDOW * cone[Window].first_speed
    angle = np.linspace(0.0, 6.0, present.sum())
    excess = np.linspace(0.0, 2.0 * bound, present.sum())
    of_points = of_soil + excess[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    velocity = simulation.array("particle.velocity")
    velocity[present] = of_points
    velocity[~present] = 1e3 * bound
    simulation.launch(simulation.plan.between_steps[VELOCITY_BOUND])
    within = excess < 0.999 * bound
    np.testing.assert_array_equal(velocity[present][within], of_points[within])
    direction = (of_points - of_soil)[~within] / excess[~within, None]
    beyond = velocity[present][excess > bound] - of_soil
    np.testing.assert_allclose(beyond, bound * direction[-len(beyond) :], atol=1e-12 * bound)
    assert (velocity[~present] == 1e3 * bound).all()


@pytest.mark.parametrize(("differ", "bound"), [(0.0, 1.0), (0.4, 1.0), (0.7, 1.4), (9.0, 4.0)])
def test_a_closer_bound_leaves_what_sound_soil_has_within_a_cell(
    cone: Scene, differ: float, bound: float
) -> None:
    """Where the soil moves evenly it is the one given, else twice what a cell's velocities differ.

    It is never above that of every window. Velocities are over a quarter of that bound; points are
    so fast across that it hardly matters how fast the soil moves up.
    """
    window = cone[Window]
    simulation = Simulation(
        cone.with_parts(dataclasses.replace(window, stray_speed=window.first_speed))
    )
    grid, unit = cone.grid, window.first_speed
    column = np.arange(grid.node_count) % (grid.column_count + 1)
    of_soil = simulation.array("node.velocities")
    of_soil[:, 1] = unit * differ * (column % 2)
    present = np.flatnonzero(simulation.array("particle.cell")[:, 0] >= 0)
    velocity = simulation.array("particle.velocity")
    velocity[present] = np.array([50.0 * unit, 0.0])
    simulation.launch(simulation.plan.between_steps[VELOCITY_BOUND])
    np.testing.assert_allclose(velocity[present, 0], bound * unit, rtol=0.02)


def test_no_point_at_the_tip_outruns_waves_where_a_cone_is_fast_in_soft_soil() -> None:
    """Ir 7.7 at 0.42 of the shear wave's speed: without the bound a point reaches the wave's."""
    test = ConePenetration(
        rigidity_index=7.7,
        poissons_ratio=0.04,
        adhesion_factor=0.4,
        friction_coefficient=0.67,
        in_situ_stress=0.0,
        speed_ratio=0.42,
        time_step_fraction=0.26,
        particles_per_cell=16,
        cells_per_radius=1.38,
        domain_radius=20,
        domain_above=10.9,
        domain_below=8.9,
        penetration=12,
        steady_tolerance=0,
    )
    assert float(test.run().cone_factor) > 0.0
