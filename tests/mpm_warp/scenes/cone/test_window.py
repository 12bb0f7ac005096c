"""The window of a cone penetration test: how long it takes, and what its approach leaves behind."""

import dataclasses

import pytest

from mpm_warp.parts.window import Approach, Window
from mpm_warp.scenes.cone.cone_penetration import ConePenetration

pytestmark = pytest.mark.slow


def test_a_run_takes_the_steps_that_its_plan_says() -> None:
    """But for two: in a step the speed is that at its begin.

    That costs half a step where the speed rises, gains 0.5 ln 4 where it falls to a quarter; and
    either number is a whole one.
    """
    cone = ConePenetration(
        cells_per_radius=1.5,
        domain_radius=10,
        domain_above=5,
        domain_below=5,
        penetration=12,
        steady_tolerance=0,
    )
    result = cone.run()
    assert abs(int(result.step_count) - int(result.step_count_bound)) <= 2
    assert cone.step_count_bound(cone.plan()) == int(result.step_count_bound)


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
def test_a_hurried_approach_ends_at_the_same_cone_factor(adhesion_factor: float) -> None:
    """After the same way; both are steady to 0.3 %, so they may differ by twice as much."""
    cone = ConePenetration(
        cells_per_radius=2, adhesion_factor=adhesion_factor, penetration=20, steady_tolerance=0
    )
    slow = float(dataclasses.replace(cone, approach=0.0).run().cone_factor)
    assert float(cone.run().cone_factor) == pytest.approx(slow, rel=0.006)


def test_an_approach_that_nothing_is_left_of_is_left_out() -> None:
    def approach(**changes: float) -> Approach | None:
        return ConePenetration(**changes).build()[Window].approach

    assert approach() is not None
    assert approach(penetration=7) is None  # its last five radii are at the final speed
    assert approach(approach=0) is None
    assert approach(speed_ratio=0.2, approach_speed_ratio=0.1) is None


def test_no_resistance_is_given_where_the_penetrometer_slows_down() -> None:
    """Two radii until the end of the approach, and half a radius after it."""
    cone = ConePenetration(
        cells_per_radius=1,
        domain_radius=10,
        domain_above=3,
        domain_below=3,
        approach=5,
        penetration=12,
        steady_tolerance=0,
    )
    result = cone.run()
    slowed = (result.penetration > 3.0) & (result.penetration < 5.5)
    for curve in ("penetration_resistance", "excess_pore_pressure_face"):
        assert (result[curve].isnull() == slowed).all()
