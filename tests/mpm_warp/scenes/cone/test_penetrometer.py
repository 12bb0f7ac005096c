"""The penetrometer: areas, normals, forces, where it measures; what it takes to push it in, and
when its resistance counts as steady.
"""

import math

import numpy as np
import pytest

from mpm_warp import Grid, Simulation, SurfaceContact
from mpm_warp.grid.fitted import Floats
from mpm_warp.sampling import ContactForces
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.penetration import PenetrationCurves
from mpm_warp.scenes.cone.penetrometer import (
    SLEEVE_BEGIN,
    SLEEVE_LENGTH,
    Penetrometer,
    PenetrometerContact,
    sleeve_mean,
)
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING, is_steady

ROUNDING = 1e-12
HALF_ANGLE = np.radians(30.0)


def test_areas_of_face_and_shaft_are_exact(
    contact: PenetrometerContact, penetrometer: Penetrometer, fitted: Grid
) -> None:
    face, shaft = contact.face_areas, contact.shaft_areas
    slant = 1.0 / np.sin(HALF_ANGLE)
    assert face.sum() == pytest.approx(0.5 * slant, rel=ROUNDING)  # pi R l over 2 pi
    assert shaft.sum() == pytest.approx(fitted.rows[-1] - penetrometer.cone_height, rel=ROUNDING)


def test_nothing_flows_through_the_surface_on_the_whole(contact: PenetrometerContact) -> None:
    """Uniform flow along z through the closed tip: the z areas sum to the base, less none."""
    vectors = contact.normals * contact.normal_areas[:, None]
    assert vectors[:, 1].sum() == pytest.approx(0.5, rel=ROUNDING)  # R^2 / 2, the base
    np.testing.assert_allclose(np.linalg.norm(contact.normals, axis=1), 1.0, rtol=ROUNDING)


def test_shoulder_has_a_mean_normal_and_the_tip_a_vertical(contact: PenetrometerContact) -> None:
    normals, face, shaft = contact.normals, contact.face_areas, contact.shaft_areas
    shoulder = int(np.flatnonzero((face > 0.0) & (shaft > 0.0))[0])
    expected = face[shoulder] * np.array([-np.cos(HALF_ANGLE), np.sin(HALF_ANGLE)])
    expected += shaft[shoulder] * np.array([-1.0, 0.0])
    np.testing.assert_allclose(
        normals[shoulder], expected / np.linalg.norm(expected), rtol=ROUNDING
    )
    np.testing.assert_allclose(normals[0], [0.0, 1.0], atol=ROUNDING)


def _uniform_traction(contact: PenetrometerContact, pressure: float) -> Floats:
    """Nodal forces of a uniform normal traction and of full adhesion, but none at the fixed tip."""
    shear = contact.adhesion_forces.copy()
    shear[0] = 0.0
    return np.stack([pressure * contact.normal_areas, shear], axis=-1)


def test_a_uniform_pressure_gives_its_value_times_the_base(contact: PenetrometerContact) -> None:
    forces = contact.forces(_uniform_traction(contact, 7.0) * [1.0, 0.0])
    assert forces.face_normal == pytest.approx(7.0 * 0.5, rel=ROUNDING)


@pytest.mark.parametrize("mobilised", [1.0, 0.25])
def test_adhesion_gives_the_exact_shear_on_face_and_shaft(
    contact: PenetrometerContact, mobilised: float
) -> None:
    """2 F / R^2 = a / tan(half angle), the tip included, which takes as much as its neighbour.

    The stress on the shaft is that of its own adhesion, at the shoulder too, which is of both.
    """
    nodal = _uniform_traction(contact, 7.0)
    nodal[:, 1] *= mobilised
    forces = contact.forces(nodal)
    exact = mobilised * 3.0 / np.tan(HALF_ANGLE)
    assert 2.0 * forces.face_shear == pytest.approx(exact, rel=ROUNDING)
    assert forces.shaft_shear == pytest.approx(mobilised * contact.shaft_areas.sum(), rel=ROUNDING)
    on_shaft = np.where(contact.shaft_areas > 0.0, mobilised * 1.0, 0.0)
    np.testing.assert_allclose(contact.shaft_shear_stress(nodal), on_shaft, rtol=ROUNDING)


def test_shear_at_the_tip_is_taken_from_its_normal_force(contact: PenetrometerContact) -> None:
    nodal = _uniform_traction(contact, 7.0)
    forces = contact.forces(nodal)
    vertical = nodal[:, 0] * contact.normals[:, 1]
    along_face = nodal[:, 1] * contact.face_areas / (contact.face_areas + contact.shaft_areas / 3.0)
    expected = vertical.sum() + np.cos(HALF_ANGLE) * along_face.sum()
    assert forces.face_normal + forces.face_shear == pytest.approx(expected, rel=ROUNDING)


def test_friction_shares_the_shoulder_by_the_total_normal_traction(
    penetrometer: Penetrometer, fitted: Grid
) -> None:
    rubbing = PenetrometerContact.of(
        penetrometer, fitted, face_adhesion=0.0, friction=0.5, in_situ_stress=10.0
    )
    face, shaft = rubbing.face_areas, rubbing.shaft_areas
    nodal = np.zeros((len(face), 2))
    shoulder = int(np.flatnonzero((face > 0.0) & (shaft > 0.0))[0])
    nodal[shoulder, 1] = 1.0
    forces = rubbing.forces(nodal)
    share = face[shoulder] / (face[shoulder] + shaft[shoulder])
    assert forces.face_shear == pytest.approx(share * np.cos(HALF_ANGLE), rel=ROUNDING)
    assert forces.shaft_shear == pytest.approx(1.0 - share, rel=ROUNDING)


@pytest.mark.parametrize("in_situ_stress", [0.0, 10.0])
def test_the_share_in_touch_is_of_the_area_that_something_presses(in_situ_stress: float) -> None:
    """Of areas 1, 2, 4 and 8: pressed, just still pressed, parted, and parted but for rounding."""
    areas = np.array([1.0, 2.0, 4.0, 8.0])
    contact = SurfaceContact(
        nodes=np.arange(4, dtype=np.int32),
        normals=np.tile([-1.0, 0.0], (4, 1)),
        normal_areas=areas,
        adhesion_forces=np.zeros(4),
        in_situ_stress=in_situ_stress,
    )
    parted = -in_situ_stress * areas
    still = np.array([5.0, 0.01, 0.0, 0.0]) * areas * max(1.0, in_situ_stress)
    rounding = ROUNDING * parted * [0.0, 0.0, 1.0, -1.0]
    assert contact.share_in_touch(parted + still + rounding) == 3.0 / 15.0
    assert contact.share_in_touch(parted) == 0.0
    assert contact.share_in_touch(np.ones(4)) == 1.0


def test_the_sleeve_of_a_cone_of_10_cm2_has_150_cm2() -> None:
    assert 2.0 * math.pi * SLEEVE_LENGTH * 1.785**2 == pytest.approx(150.0, rel=1e-3)


MIDDLE, END = SLEEVE_BEGIN + 0.5 * SLEEVE_LENGTH, SLEEVE_BEGIN + SLEEVE_LENGTH


@pytest.mark.parametrize(
    ("heights", "values", "mean"),
    [
        # What is linear has the mean of its middle, whatever the heights.
        *(
            (np.linspace(-1.0, 9.0, n), np.linspace(5.0, -15.0, n), 3.0 - 2.0 * MIDDLE)
            for n in (3, 8, 40)
        ),
        # Nothing up to the height of 4, from there on a slope of 1.
        ([0.0, 4.0, 9.0], [0.0, 0.0, 5.0], 0.5 * (END - 4.0) ** 2 / SLEEVE_LENGTH),
        # The sleeve ends higher.
        (np.linspace(-1.0, 8.0, 10), np.ones(10), math.nan),
    ],
)
def test_mean_over_the_sleeve(heights: Floats, values: Floats, mean: float) -> None:
    """What is beside the sleeve does not count."""
    assert sleeve_mean(np.array(heights), np.array(values)) == pytest.approx(mean, nan_ok=True)


SMOOTH = ConePenetration(
    cells_per_radius=2, penetration=1, domain_radius=10, domain_above=4, domain_below=4
)


def test_forces_and_work_are_those_of_nodes_along_the_axis(monkeypatch: pytest.MonkeyPatch) -> None:
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
