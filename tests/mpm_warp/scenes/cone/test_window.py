"""The window of a cone penetration test: its way, and when it has no room left."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mpm_warp.errors import WindowOverfull
from mpm_warp.parts.window import Approach
from mpm_warp.sampling import soil_scene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.simulation import Simulation


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
    """And takes its steps in one go wherever its speed is the final one, but for soil and watch."""
    cone = ConePenetration(
        cells_per_radius=1.5, domain_radius=10, domain_above=4, domain_below=4, penetration=12
    )
    simulation = Simulation(cone.build())
    window = soil_scene(simulation).window
    assert window is not None
    assert window.approach is not None
    goes: list[int] = []
    advance = simulation.advance

    def counted(count: int) -> None:
        goes.append(count)
        advance(count)

    monkeypatch.setattr(simulation, "advance", counted)
    radius = cone.cone_radius
    for distance in np.linspace(0.5, 11.5, 23) * radius:
        goes.clear()
        simulation.travel_to(distance)
        # Of all speeds that it may have had in its last step, the highest.
        last = window.highest_speed_from(distance - 0.1 * radius) * simulation.plan.time_step
        assert distance <= simulation.travel < distance + last
        if distance > window.approach.travel + 0.5 * radius:
            assert len(goes) <= 1


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
def test_a_hurried_approach_ends_at_the_same_cone_factor(adhesion_factor: float) -> None:
    """Both end where they are steady to 0.3 %, so they may differ by twice as much."""
    cone = ConePenetration(cells_per_radius=2, adhesion_factor=adhesion_factor)
    slow = float(dataclasses.replace(cone, approach=0.0).run().cone_factor)
    assert float(cone.run().cone_factor) == pytest.approx(slow, rel=0.006)


def test_an_approach_that_nothing_is_left_of_is_left_out() -> None:
    def approach(**changes: float) -> Approach | None:
        window = ConePenetration(**changes).build().window  # type: ignore[arg-type]
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
    simulation = Simulation(cone.build())
    spare = simulation.array("particle.cell")[:, 0] < 0
    for name in ("cell", "position", "mass"):  # as if every slot were taken
        values = simulation.array(f"particle.{name}")
        values[spare] = values[~spare][: spare.sum()]
    with pytest.raises(WindowOverfull, match="more soil has stayed in the window") as end:
        cone.record(simulation, lambda fraction: None)
    assert end.value.status == "diverged"
    assert end.value.curves is not None
    assert end.value.curves.sizes["penetration"] > 0
