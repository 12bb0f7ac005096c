"""Limit loads of cylinder and sphere, and steady flow round ball and T-bar."""

from typing import Any

import pytest

from mpm_warp.scenes.full_flow.limit_load import FullFlow, FullFlowCylinder, FullFlowSphere
from mpm_warp.scenes.full_flow.penetration import BallPenetration, TBarPenetration

pytestmark = pytest.mark.slow

CELLS = 4
SHORT = {"cells_per_radius": CELLS, "particles_per_cell": 4, "penetration": 5.0}


@pytest.mark.parametrize(
    ("body", "changed"),
    [
        (FullFlowCylinder, {"adhesion_factor": 0.0}),
        (FullFlowCylinder, {"adhesion_factor": 1.0}),
        (FullFlowSphere, {"adhesion_factor": 0.0}),
        (FullFlowSphere, {"adhesion_factor": 1.0}),
        (FullFlowSphere, {"adhesion_factor": 1.0, "material": "von_mises"}),
    ],
)
def test_force_on_a_body_in_full_flow(body: type[FullFlow], changed: dict[str, Any]) -> None:
    """That which is known, or one within its bounds."""
    result = body(cells_per_radius=CELLS, **changed).run()
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    assert float(result.error) <= 1 / (CELLS * result.bearing_capacity)


def test_where_nothing_is_known_nothing_is_compared() -> None:
    result = FullFlowSphere(cells_per_radius=1, adhesion_factor=0.5, displacement=60.0).run()
    assert not {"error", "bearing_capacity_exact"} & set(result)


@pytest.mark.parametrize("adhesion_factor", [0.0, 0.5, 1.0])
def test_steady_flow_has_the_limit_load(adhesion_factor: float) -> None:
    result = TBarPenetration(adhesion_factor=adhesion_factor, **SHORT).run()
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    assert float(result.error) <= 1 / (CELLS * result.resistance_factor_exact)
    assert abs(float(result.energy_error)) < 0.02
    assert result.penetration.attrs["long_name"] == "penetration over radius of the body"
    assert result.resistance_factor_uncertainty.isnull()
    assert str(result.why_no_uncertainty.values).startswith("further runs: none were made")


def test_cells_too_wide_for_further_runs_are_why_there_is_no_uncertainty() -> None:
    result = TBarPenetration(**SHORT | {"cells_per_radius": 2}).run()
    assert str(result.why_no_uncertainty.values).startswith("further runs: cells_per_radius = 2")


def test_where_no_further_run_can_tell_the_error_none_is_advised() -> None:
    clay: Any = {"material": "modified_cam_clay"}
    result = TBarPenetration(**clay, **SHORT).run()
    reason = "law: the error is not known in modified_cam_clay: nothing is corrected"
    assert str(result.why_no_uncertainty.values) == reason


def test_half_the_speed_of_the_run_leaves_the_rates_of_the_real_one() -> None:
    """What is left of the speed is inertia, at most rho V^2."""
    factors = []
    for speed_ratio in (0.06, 0.03):
        bar = TBarPenetration(
            cells_per_radius=3,
            particles_per_cell=9,
            domain_extent=4,
            penetration=5.0,
            speed_ratio=speed_ratio,
            rate_factor=0.1,
            reference_strain_rate=3e-6,
        )
        result = bar.run()
        factors.append(float(result.resistance_factor))
        # In clay whose strength changes no limit load is known.
        assert not {"error", "resistance_factor_exact"} & set(result)
    inertia = bar.rigidity_index * 0.06**2  # rho V^2 over su
    assert factors[0] == pytest.approx(factors[1], abs=inertia)


def test_steady_flow_round_a_smooth_ball_has_its_limit_load() -> None:
    limit = float(FullFlowSphere(cells_per_radius=CELLS).run().bearing_capacity)
    ball = BallPenetration(shaft_radius_ratio=0.0, **SHORT)
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    assert float(ball.run().resistance_factor) == pytest.approx(limit, rel=1 / (CELLS * limit))


def test_a_shaft_bears_the_soil_from_the_area_that_it_covers() -> None:
    """It is a tenth of the ball's; soil that the shaft pushes aside gives some of it back."""
    ball = BallPenetration(cells_per_radius=3, penetration=5.0, adhesion_factor=1.0)
    result = ball.run()
    assert abs(float(result.energy_error)) < 0.02
    limit = float(FullFlowSphere(cells_per_radius=3, adhesion_factor=1.0).run().bearing_capacity)
    covered = ball.shaft_radius_ratio**2
    assert (1.0 - covered) * limit < float(result.resistance_factor) < limit
