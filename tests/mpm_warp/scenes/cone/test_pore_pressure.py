"""Excess pore pressure on a penetrometer: where it is read, relative to what, and what is given."""

import dataclasses
import math

import numpy as np
import pytest
import xarray as xr

from mpm_warp.sampling import excess_pore_pressure, soil_scene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.penetrometer import PenetrometerContact
from mpm_warp.scenes.cone.pore_pressure import (
    LOG_OFFSET,
    PLACES,
    RADIAL_FROM,
    RADIAL_TO,
    SHAFT_FILTER,
    SHOULDER_FILTER,
    pore_pressure_curves,
    pore_pressure_factors,
)
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.further_runs import REASON
from mpm_warp.uncertainty.shoulder import RADIAL_FACTOR, RADIAL_STRESS

ROUNDING = 1e-12
TEST = ConePenetration(
    cells_per_radius=2, domain_radius=10, domain_above=10, domain_below=4, stress_anisotropy=0.3
)
SHOULDER = np.sqrt(3.0)
"""Its height above the tip, over the radius."""
FALL, INWARD, LOWER = 4e4, 3e5, 2e4
"""Of the pressure: with the logarithm of the height behind the shoulder and linear before it [Pa],
away from the surface [Pa/m], and in the first column behind the shoulder [Pa]."""
WITHOUT_PRESSURE = np.array([4e3, -6e3, 7e3, 2e3])
"""Stress of no mean, which is added [Pa]."""


def pressures_in(test: ConePenetration, simulation: Simulation) -> np.ndarray:
    """A field that each reading has the exact value of, shape [cell_count]."""
    grid = soil_scene(simulation).grid
    middles = 0.5 * (grid.rows[:-1] + grid.rows[1:]) / test.cone_radius - SHOULDER
    behind = middles > 0.0
    by_height = np.where(behind, -np.log(np.abs(middles) + LOG_OFFSET), 1.0 - middles)
    columns = 0.5 * (grid.columns[:-1] + grid.columns[1:])
    in_row = np.outer(~behind, -INWARD * columns) - np.outer(behind, LOWER * (columns < columns[1]))
    field: np.ndarray = 1e5 + FALL * by_height[:, None] + in_row
    # What the shoulder smears must not be read.
    first = int(np.argmax(behind))
    field[first : first + 2] = 1e9
    return field.ravel()


def pressures_read() -> np.ndarray:
    """What is to be read in that field, at each of the places."""
    filter_heights = SHOULDER_FILTER + np.linspace(-0.14, 0.14, 2001)
    logarithms = np.log([*filter_heights + LOG_OFFSET, SHAFT_FILTER + LOG_OFFSET])
    shoulder = 1e5 - FALL * logarithms[:-1].mean() - LOWER
    return np.array(
        [1e5 + FALL * (1.0 + 0.5 * SHOULDER), shoulder, 1e5 - FALL * logarithms[-1] - LOWER]
    )


def sampled(test: ConePenetration, times: int) -> xr.Dataset:
    simulation = Simulation(test.build())
    # Shear has no part in it, and a shift of stress from one direction to another none either.
    change = np.outer(pressures_in(test, simulation), [-1.0, -1.0, 0.0, -1.0]) + WITHOUT_PRESSURE
    curves = pore_pressure_curves(simulation, test.cone.penetrometer)
    simulation.assign("cell.stress", soil_scene(simulation).stress_at_rest + change)
    for _ in range(times):
        curves.sample()
    return curves.dataset()


def test_ground_as_it_was_has_no_excess_pore_pressure() -> None:
    simulation = Simulation(TEST.build())
    simulation.advance(1)
    np.testing.assert_allclose(excess_pore_pressure(simulation), 0.0, atol=1e-6)


def test_pressures_are_of_the_places_and_begin_at_0() -> None:
    """u3 is linear between rows: off by their distance squared over 8, times the curvature."""
    cell = TEST.cone.penetrometer.cone_height / TEST.cone_radius / 3
    off = FALL * (cell / (SHAFT_FILTER - cell)) ** 2 / 8
    dataset = sampled(TEST, 3)
    for name, pressure in zip(PLACES, pressures_read(), strict=True):
        curve = dataset[f"excess_pore_pressure_{name}"]
        np.testing.assert_allclose(curve, [0.5 * pressure, pressure, pressure], atol=off)
        assert PLACES[name] in curve.attrs["description"]


def test_the_radial_stress_is_that_of_the_ground_and_its_change() -> None:
    """Over the mean at rest; the deviator there is (sigma_v - sigma_h) / 3 = 2 Delta su / 3."""
    test = dataclasses.replace(TEST, cells_per_radius=6.0)
    pressures = 1e5 - LOWER - FALL * np.log(np.linspace(RADIAL_FROM, RADIAL_TO, 1000) + LOG_OFFSET)
    at_rest = 2.0 * test.stress_anisotropy * test.undrained_shear_strength / 3.0
    expected = pressures.mean() - WITHOUT_PRESSURE[0] - at_rest
    # Mean over rows of their middles: off by the width squared over 24, times the mean curvature.
    curvature = (1.0 / (RADIAL_FROM + LOG_OFFSET) - 1.0 / (RADIAL_TO + LOG_OFFSET)) / (
        RADIAL_TO - RADIAL_FROM
    )
    off = FALL * curvature * (0.5 / 6.0) ** 2
    radial = sampled(test, 2)[RADIAL_STRESS]
    assert float(radial[-1]) == pytest.approx(expected, abs=off)


def test_there_is_no_pressure_above_the_window() -> None:
    dataset = sampled(dataclasses.replace(TEST, domain_above=8.0), 1)
    assert dataset.excess_pore_pressure_shaft.isnull().all()
    assert dataset.excess_pore_pressure_shoulder.notnull().all()


def test_factors_are_means_over_the_last_two_radii() -> None:
    values = np.append(np.full(30, 7e4), np.full(20, 5e4))
    recorded = xr.Dataset(
        {f"excess_pore_pressure_{name}": ("penetration", values) for name in PLACES}
        | {RADIAL_STRESS: ("penetration", 0.4 * values)}
    )
    factors = pore_pressure_factors(recorded, strength=2e4)
    assert [float(it) for it in factors.values()] == pytest.approx([2.5] * len(PLACES) + [1.0])
    assert "last 2 radii" in factors["pore_pressure_factor_face"].attrs["description"]


RECORDED = xr.Dataset(
    {f"excess_pore_pressure_{it}": ("penetration", np.full(40, 1e5)) for it in PLACES}
    | {f"pore_pressure_factor_{it}": 5.0 for it in PLACES}
    | {RADIAL_STRESS: ("penetration", np.full(40, 1e5)), RADIAL_FACTOR: 5.0}
    | {"sleeve_friction_factor": 0.4, REASON: ""}
)


def test_how_far_sleeve_friction_may_be_lower_is_by_what_was_built() -> None:
    """The parameters of a scene that is derived from this one may say another clay or contact."""
    test = ConePenetration(adhesion_factor=0.5)
    scene, told = test.build(), []
    softer = ConePenetration(remoulded_strength_ratio=0.2, ductility=30.0).soil
    rated = ConePenetration(rate_factor=0.1, reference_strain_rate=1.0).soil
    contact = scene[PenetrometerContact]
    for built in (
        scene,
        dataclasses.replace(scene, material=softer),
        dataclasses.replace(scene, material=rated),
        scene.with_parts(dataclasses.replace(contact, friction=0.2)),
        scene.with_parts(dataclasses.replace(contact, shaft_adhesion=1e3)),
    ):
        stated = test.beside_shaft(RECORDED, built)
        told.append(float(stated["sleeve_friction_factor_uncertainty"].values))
    np.testing.assert_allclose(told, [0.1, 0.3, math.nan, math.nan, math.nan])


def test_u1_and_u2_are_less_certain_in_a_small_window() -> None:
    """A radius of 10 instead of 40, each by default otherwise."""
    half_widths = []
    for radius in (40.0, 10.0):
        test = ConePenetration(domain_radius=radius)
        stated = test.beside_shaft(RECORDED, test.build())
        names = [f"pore_pressure_factor_{it}_uncertainty" for it in ("face", "shoulder")]
        half_widths.append(np.array([float(stated[name].values) for name in names]))
    default, small = half_widths
    np.testing.assert_allclose(small, np.hypot(default, 0.035 * (4.0**2 - 1.0)))
