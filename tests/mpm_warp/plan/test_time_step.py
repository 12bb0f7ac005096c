"""The time step follows the critical one where that changes during a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from mpm_warp.execution.batch import Batch
from mpm_warp.execution.batched_plan import batch_key
from mpm_warp.plan.time_step import SLACK, TimeStepControl
from mpm_warp.planning import make_plan
from mpm_warp.scenes.cavity_cylinder import CavityCylinder
from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.scenes.stretched_bar import StretchedBar
from mpm_warp.simulation import CHECK_INTERVAL, Simulation, TimeLoop
from mpm_warp.watch.health import Fault


def following(now: float, critical: float, fraction: float = 0.8) -> float:
    control = TimeStepControl(
        first=0.8, fraction=fraction, critical=lambda array: critical, replan=pytest.fail
    )
    return control.following(now, np.zeros)


def test_the_time_step_stays_while_it_is_nearly_right() -> None:
    assert following(0.8, critical=1.0) == 0.8
    assert following(0.8, critical=1.0 / 1.02) == 0.8


def test_the_time_step_is_ready_for_the_critical_one_to_fall_on() -> None:
    assert following(0.8, critical=1.0 / 1.06) == pytest.approx(0.8 / 1.06**2)


def test_the_time_step_rises_again_up_to_the_first_one() -> None:
    control = TimeStepControl(
        first=0.8, fraction=0.8, critical=lambda array: float(array("")), replan=pytest.fail
    )
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


def test_only_what_can_change_is_looked_at() -> None:
    assert make_plan(ConePenetration(cells_per_radius=1.0).build()[0]).control is None
    assert make_plan(CavityCylinder().simulated_scene()).control is not None


def test_a_plan_with_another_time_step_is_the_same_but_for_numbers() -> None:
    for plan in (StretchedBar().plan(), make_plan(CavityCylinder().simulated_scene())):
        assert plan.control is not None
        other = plan.control.replan(0.3 * plan.time_step)
        assert other.time_step == 0.3 * plan.time_step
        assert batch_key(other) == batch_key(plan)


def test_a_bar_that_is_drawn_out_takes_shorter_steps_and_no_more_than_it_needs() -> None:
    """Its viscous stress bounds them, in proportion to its density: to a third in the end."""
    bar = StretchedBar(stretch=3.0, cell_count=2)
    plan = bar.plan()
    first = plan.time_step
    result = bar.run()
    last = float(result.time_step)
    critical = plan.scene.bodies[0].critical_time_step(bar.cell_size, thinning=3.0)
    # As wanted, or less because the critical one falls by a tenth between two looks.
    assert 0.8 / 1.1 / SLACK < last / critical < 0.8 * SLACK
    assert bar.duration / first < float(result.step_count) < bar.duration / last
    assert float(result.error) < 0.01
    np.testing.assert_allclose(
        result.stretch_exact[-1], 3.0, rtol=2.0 * first / bar.duration * np.log(3.0) * 3.0
    )


def test_a_wall_that_squeezes_its_cells_to_a_half(monkeypatch: pytest.MonkeyPatch) -> None:
    """It goes on with steps that fit them, at the same time to the same place."""
    monkeypatch.setattr(CavityCylinder, "plastic_radius", 1.5)
    cavity = CavityCylinder(expansion=2.0, cells_per_radius=2, rigidity_index=100.0)
    scene = cavity.simulated_scene()
    assert scene.moving_wall is not None
    wall = scene.moving_wall
    end = (1.0 + wall.ramp_travel) / wall.speed
    simulation = Simulation(scene)
    simulation.advance_to(end)
    plan = simulation.plan
    assert plan.control is not None
    assert plan.time_step < 0.7 * plan.control.first
    critical = plan.control.critical(simulation.array)
    assert plan.control.first > 1.2 * critical
    assert plan.time_step / critical == pytest.approx(scene.time_step_fraction, rel=SLACK - 1.0)
    assert simulation.time == pytest.approx(end, abs=0.5 * plan.time_step)
    radius = simulation.array("wall.motion")[0, 2]
    assert radius == pytest.approx(2.0, abs=wall.speed * plan.control.first)


def test_time_is_the_sum_of_the_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    factors = iter([0.5, 0.25, 0.5])

    def prescribed(control: TimeStepControl, step: float, array: Any) -> float:
        return control.first * next(factors, 0.5)

    monkeypatch.setattr(TimeStepControl, "following", prescribed)
    loop = TimeLoop(StretchedBar(stretch=1.5, cell_count=2).plan())
    first = loop.plan.time_step
    loop.advance(3 * CHECK_INTERVAL + 10)
    assert loop.time == pytest.approx((CHECK_INTERVAL * 1.75 + 10 * 0.5) * first)
    assert loop.array("load.time")[0] == pytest.approx(loop.time)
    loop.advance_to(2.5 * CHECK_INTERVAL * first)
    assert loop.time == pytest.approx(2.5 * CHECK_INTERVAL * first, abs=0.26 * first)


def test_bars_together_each_keep_their_own_time_step() -> None:
    bars = [StretchedBar(stretch=stretch, cell_count=2) for stretch in (1.5, 2.0, 1.5)]
    batch, together = Batch(), {}

    def work(number: int) -> Callable[[], None]:
        def run() -> None:
            together[number] = bars[number].run(execution=batch)

        return run

    batch.run([work(number) for number in range(len(bars))])
    for number, bar in enumerate(bars):
        alone = bar.run()
        for name in ("time_step", "step_count", "stretch", "stress_greatest"):
            np.testing.assert_array_equal(together[number][name], alone[name])
