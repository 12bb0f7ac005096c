"""A penetrometer that is pushed in: what it takes, and when its resistance counts as steady."""

import numpy as np
import pytest

from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.sampling import ContactForces
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.penetration import PenetrationCurves
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING, is_steady

ROUNDING = 1e-12
SMOOTH = ConePenetration(
    cells_per_radius=2, penetration=1, domain_radius=10, domain_above=4, domain_below=4
)


def test_forces_and_work_are_those_of_the_nodes_along_the_axis(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of a smooth cone: normal forces times the upward part of their normals, times the way."""
    scene = SMOOTH.build()
    simulation = Simulation(scene)
    taken: list[Floats] = []
    take = ContactForces.take

    def noted(forces: ContactForces) -> Floats:
        taken.append(take(forces))
        return taken[-1]

    monkeypatch.setattr(ContactForces, "take", noted)
    curves = PenetrationCurves(simulation, radius=SMOOTH.cone_radius)
    way, work = 0.0, 0.0
    for number in range(1, 11):
        simulation.travel_to(number * SAMPLE_SPACING * SMOOTH.cone_radius)
        curves.sample()
        upward = float(taken[-1][:, 0] @ scene[SurfaceContact].normals[:, 1])
        assert curves.forces[-1].upward == pytest.approx(upward, rel=ROUNDING)
        work += upward * (simulation.travel - way)
        way = simulation.travel
    assert way == pytest.approx(10 * SAMPLE_SPACING * SMOOTH.cone_radius, rel=0.01)
    assert len(taken) == 10
    assert curves.work == pytest.approx(work, rel=ROUNDING)
    resistance = curves.dataset().penetration_resistance * 0.5 * SMOOTH.cone_radius**2
    np.testing.assert_allclose(resistance, [it.upward for it in curves.forces], rtol=ROUNDING)
    assert work > 0.0


def test_a_step_past_several_samples_gives_each_the_same_forces() -> None:
    simulation = Simulation(SMOOTH.build())
    curves = PenetrationCurves(simulation, radius=SMOOTH.cone_radius)
    simulation.travel_to(SAMPLE_SPACING * SMOOTH.cone_radius)
    curves.sample()
    curves.sample()
    assert curves.forces[0].upward == curves.forces[1].upward
    assert curves.work == pytest.approx(curves.forces[0].upward * simulation.travel)


def first_steady(curve: list[float], span: int, tolerance: float) -> int:
    return next(n for n in range(len(curve)) if is_steady(curve[:n], span, tolerance))


@pytest.mark.parametrize("halving", [10, 20, 40])
def test_what_is_left_of_an_exponential_is_what_its_decay_says(halving: int) -> None:
    """No more than that at the first value that counts as steady, and more at the one before."""
    span, tolerance = 20, 0.003
    curve = [1.0 - 0.5 ** (n / halving) for n in range(1000)]
    stop = first_steady(curve, span, tolerance)
    decay = 0.5 ** (span / halving)
    left = 1.0 - np.mean(curve[stop - span : stop])
    # Of the last mean, 1 less what is left; and that mean differs by left (1 / decay - 1).
    most = 1.0 / (1.0 + (1.0 - decay) / (decay * tolerance))
    assert 0.5 ** (1 / halving) * most <= left < most


def test_nothing_is_steady_before_two_spans_or_without_tolerance() -> None:
    assert not is_steady([1.0] * 39, 20, 0.1)
    assert is_steady([1.0] * 40, 20, 0.1)
    assert not is_steady([1.0] * 40, 20, 0.0)
