"""The cone penetration test: what must hold whatever the cone factor turns out to be."""

from __future__ import annotations

import dataclasses
import math

import pytest
import xarray as xr

from mpm_warp.scenes.cone_penetration import ConePenetration
from mpm_warp.simulation import Simulation
from mpm_warp.travel import Travel

SHORT = ConePenetration(
    cells_per_radius=2, penetration=3, domain_radius=20, domain_above=6, domain_below=6
)


def run(**changes: float | str) -> xr.Dataset:
    return dataclasses.replace(SHORT, **changes).run()


@pytest.fixture(scope="module")
def rough() -> xr.Dataset:
    """A cone with some adhesion, slipping everywhere."""
    return run(adhesion_factor=0.5)


def test_shear_part_obeys_statics(rough: xr.Dataset) -> None:
    """alpha / tan(half angle), less the share of the tip, 1 / (3 n^2) with n rows on the face."""
    rows_on_face = round(2.0 / math.tan(math.radians(30.0)))
    exact = 0.5 / math.tan(math.radians(30.0)) * (1.0 - 1.0 / (3.0 * rows_on_face**2))
    assert float(rough.cone_factor_shear) == pytest.approx(exact, rel=1e-6)


def test_parts_add_up(rough: xr.Dataset) -> None:
    parts = float(rough.cone_factor_normal) + float(rough.cone_factor_shear)
    assert float(rough.cone_factor) == pytest.approx(parts, rel=1e-12)


def test_shaft_friction_is_the_adhesion_once_the_shaft_slips(rough: xr.Dataset) -> None:
    adhesion = 0.5 * SHORT.undrained_shear_strength
    assert float(rough.shaft_friction[-1]) == pytest.approx(adhesion, rel=0.01)


def test_soil_touches_some_of_face_and_shaft_and_at_most_all(rough: xr.Dataset) -> None:
    assert ((rough.contact_share > 0.0) & (rough.contact_share <= 1.0)).all()


def test_the_face_feels_its_own_adhesion_and_not_the_shafts() -> None:
    smooth_face = run(adhesion_factor=0.0, shaft_adhesion_factor=0.5)
    assert float(smooth_face.cone_factor_shear) == pytest.approx(0.0, abs=1e-9)
    assert float(smooth_face.shaft_friction[-1]) > 0.0


@pytest.mark.parametrize(
    "changes",
    [
        {"undrained_shear_strength": 1.0, "in_situ_stress": 20.0},
        {"cone_radius": 10.0},
        {"density": 1e6},
        {"in_situ_stress": 20e6},
    ],
)
def test_the_cone_factor_has_no_units(rough: xr.Dataset, changes: dict[str, float]) -> None:
    """Strength, size, density and in-situ stress only scale the problem: equal but for rounding."""
    scaled = run(adhesion_factor=0.5, **changes)
    # Rounding grows where particles cross cells a step earlier or later; 1e-3 is asked for.
    assert float(scaled.cone_factor) == pytest.approx(float(rough.cone_factor), rel=1e-3)


def test_von_mises_resists_less_than_tresca_of_the_same_shear_strength(rough: xr.Dataset) -> None:
    von_mises = run(adhesion_factor=0.5, material="von_mises")
    assert float(von_mises.cone_factor) < float(rough.cone_factor)


@pytest.mark.parametrize(("in_situ_stress", "pulls"), [(0.0, False), (400e3, True)])
def test_soil_pulls_no_more_than_the_ground_presses(in_situ_stress: float, pulls: bool) -> None:
    """Without in-situ stress no tension is carried anywhere on face and shaft."""
    test = dataclasses.replace(SHORT, in_situ_stress=in_situ_stress)
    simulation = Simulation(test.build()[0])
    travel = Travel(simulation)
    least = []
    for radii in (0.5, 1.0, 1.5, 2.0):
        travel.advance_to(radii * test.cone_radius)
        least.append(simulation.take_contact_forces()[:, 0].min())
    assert (min(least) < 0.0) == pulls


@pytest.mark.parametrize("apex_angle", [30.0, 60.0, 90.0, 150.0])
def test_every_apex_angle_runs(apex_angle: float) -> None:
    assert math.isfinite(float(run(apex_angle=apex_angle, penetration=1.0).cone_factor))


def test_every_variable_has_a_unit_and_a_name(rough: xr.Dataset) -> None:
    for variable in rough.variables.values():
        assert variable.attrs["units"]
        assert variable.attrs["long_name"]


def test_progress_rises_to_one() -> None:
    told: list[float] = []
    dataclasses.replace(SHORT, penetration=1.0).run(told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0


@pytest.mark.slow
def test_steady_cone_factor_of_smooth_and_rough_cones() -> None:
    """Bounds around the one analysis for Tresca, Lu et al. 2004: 10.77 and 12.07."""
    factors = [
        ConePenetration(cells_per_radius=3, adhesion_factor=adhesion_factor).run()
        for adhesion_factor in (0.0, 1.0)
    ]
    smooth, rough = (float(dataset.cone_factor) for dataset in factors)
    assert 10.0 < smooth < 11.1
    assert 11.8 < rough < 13.0
    assert all(float(dataset.cone_factor_variation) < 0.01 for dataset in factors)


@pytest.mark.parametrize(
    "other",
    [
        {"in_situ_stress": 1000 * 20e3},
        {"undrained_shear_strength": 1.0, "in_situ_stress": 20.0},
        {"undrained_shear_strength": 1e7, "in_situ_stress": 20e7},
        {"cone_radius": 1e-3},
        {"cone_radius": 10.0},
        {"density": 3000.0},
    ],
)
@pytest.mark.parametrize(("precision", "rounding"), [("float64", 1e-9), ("float32", 5e-3)])
def test_cone_factor_does_not_depend_on_units(
    other: dict[str, float], precision: str, rounding: float
) -> None:
    """Strength, stress, length and mass only scale the problem: equal but for rounding."""
    short = ConePenetration(cells_per_radius=2.0, penetration=1.0, in_situ_stress=20 * 20e3)
    expected = float(short.run().cone_factor)
    scaled = float(dataclasses.replace(short, precision=precision, **other).run().cone_factor)
    assert scaled == pytest.approx(expected, rel=rounding)
