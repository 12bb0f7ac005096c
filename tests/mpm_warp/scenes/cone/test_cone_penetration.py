"""The cone penetration test: what must hold whatever the cone factor turns out to be."""

import dataclasses
import math

import numpy as np
import pytest
import xarray as xr

from mpm_warp import Snapshots
from mpm_warp.errors import InaccurateRun
from mpm_warp.parts.window import Window
from mpm_warp.sampling import ContactForces, transferred_energy
from mpm_warp.scenes.cone import penetration
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.cone_self_similar import ConeSelfSimilar
from mpm_warp.scenes.cone.pore_pressure import PLACES
from mpm_warp.scenes.limits import LARGEST_LACK
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import SMALL_WINDOW
from tests.mpm_warp.scenes.cone.conftest import LONGER as SHORT

pytestmark = pytest.mark.slow

ROUNDING = 1e-9
"""What sums over samples and nodes are exact to, generously."""


def run(**changes: float | str) -> xr.Dataset:
    return dataclasses.replace(SHORT, **changes).run()


@pytest.mark.parametrize("apex_angle", [30.0, 60.0, 90.0, 150.0])
def test_shear_part_of_every_apex_angle_obeys_statics(apex_angle: float) -> None:
    result = run(apex_angle=apex_angle, penetration=1.0, adhesion_factor=0.5)
    exact = 0.5 / math.tan(math.radians(0.5 * apex_angle))
    assert float(result.cone_factor_shear) == pytest.approx(exact, rel=ROUNDING)


def test_poissons_ratio_is_simulated_up_to_its_bound() -> None:
    bounded, lower = (
        run(penetration=2.0, poissons_ratio=ratio, poissons_ratio_bound=0.3)
        for ratio in (0.49, 0.3)
    )
    unbounded = run(penetration=2.0, poissons_ratio=0.3)
    for same in (bounded, lower):
        xr.testing.assert_equal(
            same[["penetration_resistance", "time_step"]],
            unbounded[["penetration_resistance", "time_step"]],
        )


def test_shaft_friction_is_the_adhesion_once_the_shaft_slips(rough: xr.Dataset) -> None:
    adhesion = 0.5 * SHORT.undrained_shear_strength
    assert float(rough.shaft_friction[-1]) == pytest.approx(adhesion, rel=ROUNDING)


def test_friction_shears_a_cone_by_no_more_than_the_strength_of_its_clay() -> None:
    """By statics su / tan 30 degrees: soil of no in-situ stress presses with some 10 su."""
    result = run(friction_coefficient=1.0, in_situ_stress=0.0, penetration=2.0)
    exact = 1.0 / math.tan(math.radians(30.0))
    assert float(result.cone_factor_shear) == pytest.approx(exact, rel=ROUNDING)


def test_a_cone_that_soil_shears_beside_rather_than_slides_along_is_a_rough_one() -> None:
    """Where the ground presses with 20 su, by friction of 0.05 and more; its error is known."""
    clay = {"in_situ_stress": 20.0 * SHORT.undrained_shear_strength, "adhesion_factor": 0.3}
    slides, shears = (
        ConePenetration(friction_coefficient=friction, **clay) for friction in (0.049, 0.051)
    )
    rough = ConePenetration(**clay | {"adhesion_factor": 1.0})
    assert slides.interface == (0.3, 0.3, 0.049)
    faster = dataclasses.replace(shears, rate_factor=0.1, reference_strain_rate=1e-5)
    assert faster.interface.friction == 0.051  # the soil beside it is stronger than at rest
    assert shears.laws(penetration=30.0).correction == rough.laws(penetration=30.0).correction
    assert shears.interface == rough.interface
    lower = dataclasses.replace(shears, stress_anisotropy=0.5)
    assert lower.interface.friction == 0.051  # less presses on the shaft


def test_sleeve_friction_is_the_adhesion_of_the_shaft_once_it_slips() -> None:
    """Whatever that of the face; over the area of the sleeve, 15 times that of the cone."""
    result = run(adhesion_factor=0.2, shaft_adhesion_factor=0.5, penetration=1.0, domain_above=9.0)
    assert float(result.sleeve_friction_factor) == pytest.approx(0.5, rel=ROUNDING)
    assert float(result.sleeve_friction_factor_uncertainty) < ROUNDING
    # No error of u2 was measured where the shaft has another adhesion than the face.
    assert np.isnan(result.pore_pressure_factor_shoulder_uncertainty)
    of_face = 0.2 / math.tan(math.radians(30.0))
    assert float(result.cone_factor_shear) == pytest.approx(of_face, rel=ROUNDING)
    adhesion = 0.5 * SHORT.undrained_shear_strength
    np.testing.assert_allclose(result.sleeve_friction[-5:], adhesion, rtol=ROUNDING)
    sleeve_area = 15.0 * math.pi * SHORT.cone_radius**2
    np.testing.assert_allclose(result.sleeve_force[-5:], adhesion * sleeve_area, rtol=2e-3)


def test_what_is_above_the_window_is_not_measured(rough: xr.Dataset) -> None:
    """The shaft ends 6 radii above the shoulder; the sleeve would end at 8."""
    for name in ("sleeve_friction_factor", "pore_pressure_factor_shaft"):
        assert rough[name].isnull()
    assert rough.pore_pressure_factor_face > rough.pore_pressure_factor_shoulder > 0.0


@pytest.mark.parametrize(("in_situ_stress", "pulls"), [(0.0, False), (400e3, True)])
def test_soil_pulls_no_more_than_the_ground_presses(in_situ_stress: float, pulls: bool) -> None:
    """Without in-situ stress no tension is carried anywhere on face and shaft."""
    test = dataclasses.replace(SHORT, in_situ_stress=in_situ_stress)
    simulation = Simulation(test.build())
    forces = ContactForces(simulation)
    least = []
    for radii in (0.5, 1.0, 1.5, 2.0):
        simulation.travel_to(radii * test.cone_radius)
        least.append(forces.take()[:, 0].min())
    assert (min(least) < 0.0) == pulls


def test_the_energy_error_is_what_the_transfers_made_of_the_penetrometers_work(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """They dissipate noise, create nothing."""
    expected: list[float] = []

    class Noted(penetration.PenetrationCurves):
        def dataset(self) -> xr.Dataset:
            expected.append(transferred_energy(self.simulation) / self.work)
            return super().dataset()

    monkeypatch.setattr(penetration, "PenetrationCurves", Noted)
    result = ConePenetration(cells_per_radius=2.0, penetration=2.0, steady_tolerance=0).run()
    assert [float(result.energy_error)] == expected
    assert -LARGEST_LACK < expected[0] < 0.0
    assert result.energy_error.attrs["limit"] == LARGEST_LACK


def test_a_blunt_rough_cone_throws_no_soil_off() -> None:
    """Points that rest before it are not as fast of their own as would push like the strength."""
    blunt = ConePenetration(
        apex_angle=120.0,
        adhesion_factor=1.0,
        cells_per_radius=12.0,
        cell_growth=1.5,
        domain_radius=8.0,
        domain_above=2.0,
        domain_below=4.0,
        speed_ratio=0.25,
        approach=0.0,
        penetration=6.0,
        steady_tolerance=0.0,
    )
    scene = blunt.build()
    window = scene[Window]
    assert window.stray_speed == pytest.approx(
        math.sqrt(blunt.undrained_shear_strength / blunt.density)
    )
    Simulation(scene).travel_to(6.0 * blunt.cone_radius)
    assert ConePenetration().window.stray_speed is None


@pytest.mark.parametrize(
    "given",
    [
        {"approach": 0.0},
        {"approach": 2.0},
        {"penetration": 8.0},  # its last five radii are at the final speed
        {"speed_ratio": 0.5},
    ],
)
def test_an_approach_that_is_not_made_has_no_inertia(given: dict[str, float]) -> None:
    cone = ConePenetration(rigidity_index=20, approach_speed_ratio=0.5)
    assert cone.build()[Window].approach is not None
    without = dataclasses.replace(cone, **given)
    assert without.build()[Window].approach is None
    assert without.approach_inertia == 0.0


def test_an_inaccurate_run_says_so_and_leaves_its_curves() -> None:
    hasty = ConePenetration(
        **SMALL_WINDOW, cells_per_radius=1.5, penetration=1, speed_ratio=0.5, approach=0
    )
    with pytest.raises(InaccurateRun, match=r"grid took is 0\.\d+, more than 0\.05") as end:
        hasty.run()
    assert end.value.status == "inaccurate"
    assert str(end.value).endswith("or more cells_per_radius or penetration")
    assert end.value.curves.sizes["penetration"] == 10
    assert end.value.curves.cone_factor > 0.0


@pytest.mark.parametrize(
    ("adhesion_factor", "default", "half_width"), [(0.0, 10.710, 0.057), (1.0, 12.159, 0.060)]
)
def test_quick_cone_factor_agrees_with_the_default_one(
    adhesion_factor: float, default: float, half_width: float
) -> None:
    """By the root of the squares of their U."""
    quick = ConePenetration(accuracy="quick", adhesion_factor=adhesion_factor).run()
    agreed = math.hypot(float(quick.cone_factor_uncertainty), half_width)
    assert agreed < 0.02 * default
    assert abs(float(quick.cone_factor) - default) <= agreed


@pytest.fixture(scope="module")
def shortest() -> tuple[ConePenetration, xr.Dataset]:
    """A penetration by one radius, without an approach, and its result."""
    scene = ConePenetration(
        cells_per_radius=2.0, penetration=1.0, in_situ_stress=20 * 20e3, steady_tolerance=0
    )
    return scene, scene.run()


@pytest.mark.parametrize(
    "other",
    [
        {"in_situ_stress": 1000 * 20e3},
        {"undrained_shear_strength": 1.0, "in_situ_stress": 20.0},
        {"undrained_shear_strength": 1e7, "in_situ_stress": 20e7},
        {"cone_radius": 1e-3},
        {"cone_radius": 10.0},
        {"density": 3000.0},
        {"density": 1e6},
    ],
)
def test_cone_factor_does_not_depend_on_units(
    other: dict[str, float], shortest: tuple[ConePenetration, xr.Dataset]
) -> None:
    """Strength, stress, length and mass only scale the problem: equal but for rounding.

    Rounding a speed v by its share eps changes the pressure by rho c v eps, c the speed of the
    pressure wave, and adds up as the root of the number of steps.
    """
    scene, result = shortest
    expected = float(result.cone_factor)
    soil = scene.build().material
    pressure = soil.density * soil.pressure_wave_speed * scene.speed_ratio * soil.shear_wave_speed
    steps = math.sqrt(float(result.step_count))
    rounding = steps * float(np.finfo(float).eps) * pressure / scene.undrained_shear_strength
    scaled = float(dataclasses.replace(scene, **other).run().cone_factor)
    assert scaled == pytest.approx(expected, abs=rounding)


def test_a_run_takes_the_steps_that_its_plan_says() -> None:
    """But for two: in a step the speed is that at its begin.

    That costs half a step where the speed rises, gains 0.5 ln 4 where it falls to a quarter; and
    either number is a whole one.
    """
    cone = ConePenetration(**SMALL_WINDOW, cells_per_radius=1.5, penetration=12, steady_tolerance=0)
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


def test_nothing_is_given_where_the_penetrometer_slows_down() -> None:
    """Two radii until the end of the approach, and half a radius after it."""
    cone = dataclasses.replace(SHORT, cells_per_radius=1, domain_above=10, approach=5)
    result = dataclasses.replace(cone, penetration=12).run()
    slowed = (result.penetration > 3.0) & (result.penetration < 5.5)
    for curve in ("penetration_resistance", *(f"excess_pore_pressure_{it}" for it in PLACES)):
        assert (result[curve].isnull() == slowed).all()


WITHIN = 0.05
"""Error that is allowed of a displacement behind the cone."""
BEHIND = 1.0
"""Depth below the top of the window in which soil is taken, over the cone's radius."""


def test_soil_has_made_room_for_the_shaft_like_soil_around_a_cylinder() -> None:
    """Near the shaft, far behind the tip; no soil moves further than around an endless cylinder."""
    test = ConePenetration(accuracy="quick", penetration=22, steady_tolerance=0)
    snapshots = Snapshots([22])
    test.run(snapshots=snapshots)
    fields = snapshots.dataset().isel(penetration=-1)
    r, z, moved = (
        fields[name].values / test.cone_radius for name in ("point_r", "point_z", "displacement_r")
    )
    high = z > np.nanmax(z) - BEHIND
    beside = high & (r > 1.6) & (r < 2.4)
    of_cylinder = r - np.sqrt(np.maximum(r * r - 1.0, 0.0))
    assert beside.sum() >= 5
    assert abs(np.mean(moved[beside] / of_cylinder[beside]) - 1.0) < WITHIN
    assert np.all(moved[high & (r > 1.6)] < of_cylinder[high & (r > 1.6)])


def test_load_of_a_cone_from_first_touch() -> None:
    """The depth is known to a cell at worst, of the cells that the cone is in on average."""
    cells = 10
    mean_depth = 0.4 * cells * math.sqrt(3.0)
    assert float(ConeSelfSimilar(cells_per_radius=cells).run().error) <= 2.0 / mean_depth
