"""Excess pore pressure on a penetrometer: where it is read, relative to what, and what is given."""

import dataclasses

import numpy as np
import pytest
import xarray as xr

from mpm_warp.sampling import excess_pore_pressure, soil_scene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.penetration import PLACES, PorePressureCurves, pore_pressure_factors
from mpm_warp.scenes.cone.penetrometer import SHAFT_FILTER, SHOULDER_FILTER
from mpm_warp.simulation import Simulation

ROUNDING = 1e-12
TEST = ConePenetration(
    cells_per_radius=2, domain_radius=10, domain_above=10, domain_below=4, stress_anisotropy=0.3
)
HEIGHTS = np.sqrt(3.0) * np.array([0.5, 1.0, 1.0]) + [0.0, SHOULDER_FILTER, SHAFT_FILTER]
"""Of the places above the tip, over the radius."""


def sampled(
    test: ConePenetration, times: int, slowing: tuple[float, float] | None = None
) -> tuple[xr.Dataset, np.ndarray]:
    """Curves in ground whose pressure falls linearly with height, and the pressures expected."""
    simulation = Simulation(test.build())
    grid = soil_scene(simulation).grid
    middles = np.repeat(0.5 * (grid.rows[:-1] + grid.rows[1:]), grid.column_count)
    pressure = 1e5 - 2e6 * middles
    # Shear has no part in it, and a shift of stress from one direction to another none either.
    without_pressure = np.array([4e3, -6e3, 7e3, 2e3])
    change = np.outer(pressure, [-1.0, -1.0, 0.0, -1.0]) + without_pressure
    curves = PorePressureCurves(simulation, penetrometer=test.penetrometer, slowing=slowing)
    simulation.assign("cell.stress", soil_scene(simulation).stress_at_rest + change)
    for _ in range(times):
        curves.sample()
    return curves.dataset(), 1e5 - 2e6 * HEIGHTS * test.cone_radius


def test_ground_as_it_was_has_no_excess_pore_pressure() -> None:
    simulation = Simulation(TEST.build())
    simulation.advance(1)
    np.testing.assert_allclose(excess_pore_pressure(simulation), 0.0, atol=1e-6)


def test_pressures_are_those_of_the_places_and_begin_with_none() -> None:
    dataset, expected = sampled(TEST, 3)
    for name, pressure in zip(PLACES, expected, strict=True):
        curve = dataset[f"excess_pore_pressure_{name}"]
        np.testing.assert_allclose(curve, [0.5 * pressure, pressure, pressure], rtol=ROUNDING)
        assert PLACES[name] in curve.attrs["description"]


def test_there_is_no_pressure_above_the_window() -> None:
    dataset, _ = sampled(dataclasses.replace(TEST, domain_above=8.0), 1)
    assert dataset.excess_pore_pressure_shaft.isnull().all()
    assert dataset.excess_pore_pressure_shoulder.notnull().all()


def test_no_pressure_is_given_where_the_penetrometer_slows_down() -> None:
    dataset, _ = sampled(TEST, 5, slowing=(0.2, 0.4))
    for name in PLACES:
        given = dataset[f"excess_pore_pressure_{name}"].notnull()
        np.testing.assert_array_equal(given, [True, True, False, False, True])


def test_factors_are_means_over_the_last_two_radii() -> None:
    values = np.append(np.full(30, 7e4), np.full(20, 5e4))
    recorded = xr.Dataset(
        {f"excess_pore_pressure_{name}": ("penetration", values) for name in PLACES}
    )
    factors = pore_pressure_factors(recorded, strength=2e4)
    assert [float(it) for it in factors.values()] == pytest.approx([2.5] * len(PLACES))
    assert "last 2 radii" in factors["pore_pressure_factor_face"].attrs["description"]
