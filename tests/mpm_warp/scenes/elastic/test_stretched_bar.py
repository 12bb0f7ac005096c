"""A bar that is drawn out, less than in `harness verify --extreme`: its stress, its time step."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from mpm_warp.execution.execution import Batch
from mpm_warp.plan.time_step import SLACK
from mpm_warp.planning import make_plan
from mpm_warp.scenes.elastic import stretched_bar
from mpm_warp.scenes.elastic.stretched_bar import StretchedBar

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("stretch", [1.5, 4.0])
def test_bar_that_is_drawn_out(stretch: float) -> None:
    bar = StretchedBar(stretch=stretch)
    result = bar.run()
    # Inertia takes rho L^2 / 8 times the growth of the stretch rate from the force in the middle.
    assert float(result.error) <= (math.log(stretch) / stretched_bar.SLOWNESS) ** 2 / 8 + spread(
        bar
    )
    assert float(result.stress_error) <= spread(bar)


def spread(bar: StretchedBar) -> float:
    """A quadratic spline spreads by half a cell: second order in that over the bar's length."""
    return (0.5 / bar.cell_count) ** 2


def test_its_plan_with_another_time_step_is_the_same_but_for_numbers() -> None:
    plan = StretchedBar().plan()
    assert plan.control is not None
    other = make_plan(StretchedBar().build(), time_step=0.3 * plan.time_step)
    assert other.time_step == 0.3 * plan.time_step
    assert [launch.kernel for launch in other.step] == [launch.kernel for launch in plan.step]


def test_a_bar_that_is_drawn_out_takes_shorter_steps_and_no_more_than_it_needs() -> None:
    """Its viscous stress bounds them, in proportion to its density: to a third in the end."""
    bar = StretchedBar(stretch=3.0, cell_count=2)
    first = bar.plan().time_step
    result = bar.run()
    last = float(result.time_step)
    critical = bar.build().bodies[0].critical_time_step(bar.cell_size, thinning=3.0)
    # As wanted, or less because the critical one falls by a tenth between two looks.
    assert 0.8 / 1.1 / SLACK < last / critical < 0.8 * SLACK
    assert bar.duration / first < float(result.step_count) < bar.duration / last
    assert float(result.error) < 0.01
    np.testing.assert_allclose(
        result.stretch_exact[-1], 3.0, rtol=2.0 * first / bar.duration * np.log(3.0) * 3.0
    )


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
