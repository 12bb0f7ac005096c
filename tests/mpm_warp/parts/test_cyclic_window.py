"""The cyclic window: its motion, and the ground that rests outside the grid."""

import dataclasses
import functools

import numpy as np
import pytest

from mpm_warp import CyclicWindow, Grid, LinearElastic, Scene, SceneError, Simulation
from tests.mpm_warp.conftest import refused

WINDOW = CyclicWindow(speed=2.0, ramp_travel=0.25, stroke=1.1)
ROUNDING = 1e-12


@pytest.fixture
def travelling(elastic: LinearElastic) -> Scene:
    """A grid that goes down and up through soil at rest."""
    grid = Grid(
        columns=np.linspace(0.0, 1.0, 4),
        rows=np.linspace(0.0, 1.6, 9),
        surface_radius=np.zeros(9),
        fitted_radius=1.0,
    )
    return Scene(
        grid=grid, material=elastic, particles_per_side=2, time_step_fraction=0.5, parts=(WINDOW,)
    )


@pytest.mark.parametrize("way", [0.1, 0.25, 0.6, 1.0, 1.1, 1.3, 2.2, 3.0])
def test_time_to_a_way_is_the_integral_of_one_over_the_speed(way: float) -> None:
    """Of steps so short that the way in one of them is 1e-5 of a passage."""
    step = WINDOW.passage_time * 1e-5
    since_turn = np.mod((np.arange(400_000) + 0.5) * step, WINDOW.passage_time)
    to_turn = WINDOW.passage_time - since_turn
    speed = WINDOW.speed * np.minimum(1.0, np.minimum(since_turn, to_turn) / WINDOW.ramp_time)
    gone = np.cumsum(speed) * step
    # At a turn the time to a way changes as its root.
    assert WINDOW.time_to(way) == pytest.approx(np.searchsorted(gone, way) * step, rel=2e-3)


def test_the_grid_is_where_the_window_says_and_returns(travelling: Scene) -> None:
    simulation = Simulation(travelling)
    step = simulation.plan.time_step
    # Half a step by the time, half by a speed that is that of the begin of a step while it rises;
    # and where it begins or ends to rise, what it rises by in a step.
    in_a_step, kink = WINDOW.speed * step, WINDOW.speed / WINDOW.ramp_time * step**2
    for way in (0.3, 0.7, 1.1, 1.6, 2.2, 3.3, 4.4):
        simulation.advance_to(WINDOW.time_to(way))
        passages, since = divmod(way, WINDOW.stroke)
        expected = since if passages % 2 == 0 else WINDOW.stroke - since
        error = in_a_step + 4.0 * (passages + 1.0) * kink
        assert simulation.travel == pytest.approx(expected, abs=error)


def test_soil_that_leaves_rests_and_is_back_where_it_was(travelling: Scene) -> None:
    simulation = Simulation(travelling)
    first = simulation.array("particle.position").copy()
    layer = 2 * travelling.grid.column_count
    outside = []
    for way in np.linspace(0.1, 4.4, 44):
        simulation.advance_to(WINDOW.time_to(float(way)))
        position = simulation.array("particle.position")
        in_ground = position - np.array([0.0, simulation.travel])
        np.testing.assert_allclose(in_ground, first, rtol=0.0, atol=1e3 * ROUNDING)
        is_outside = simulation.array("particle.cell")[:, 0] < 0
        column = simulation.array("particle.resting_column")
        np.testing.assert_array_equal(is_outside, column >= 0)
        height = position[~is_outside, 1]
        assert height.min() >= 0.0
        assert height.max() < travelling.grid.rows[-1] + 0.05  # half a layer
        outside.append(int(is_outside.sum()))
    assert max(outside) - min(outside) <= layer


def test_resting_soil_has_the_mass_of_the_stroke_and_keeps_its_stress(travelling: Scene) -> None:
    simulation = Simulation(travelling)
    grid, rows_below = travelling.grid, 6  # of 0.2 m, to fill 1.1 m
    per_radian = 0.5 * grid.outer_radius**2 * (grid.rows[-1] + 0.2 * rows_below)
    mass = simulation.array("particle.mass").sum()
    assert mass == pytest.approx(travelling.material.density * per_radian, rel=ROUNDING)
    rests = simulation.array("particle.cell")[:, 0] < 0
    stress = simulation.array("particle.stress").copy()
    stress[rests] = np.arange(rests.sum())[:, None]
    simulation.assign("particle.stress", stress)
    simulation.advance_to(WINDOW.time_to(0.3))
    still = simulation.array("particle.cell")[:, 0] < 0
    assert 0 < still.sum() < rests.sum() + 12
    both = rests & still
    np.testing.assert_array_equal(simulation.array("particle.stress")[both], stress[both])


def test_soil_is_set_at_rest_at_a_turn(travelling: Scene) -> None:
    simulation = Simulation(travelling)
    step = simulation.plan.time_step
    simulation.advance_to(WINDOW.passage_time - 3.0 * step)
    simulation.assign("particle.velocity", 1e-6)
    simulation.advance_to(WINDOW.passage_time - step)
    assert simulation.array("particle.velocity").any()
    simulation.advance_to(WINDOW.passage_time + step)
    assert not simulation.array("particle.velocity").any()


def test_what_does_not_go_with_a_cyclic_window_is_refused(travelling: Scene) -> None:
    for values, word in (
        ({"speed": 0.0}, "speed"),
        ({"ramp_travel": -1.0}, "ramp_travel"),
        ({"stroke": 0.4}, "stroke"),
    ):
        refused(functools.partial(dataclasses.replace, WINDOW, **values), SceneError, word)
    refused(lambda: Simulation(travelling).travel_to(1.0), ValueError, "advance to a time")
