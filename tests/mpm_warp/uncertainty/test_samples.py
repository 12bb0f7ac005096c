"""What is stated of the error of samples in uniform clay: what a cone test there states."""

import math

import numpy as np
import pytest

from mpm_warp import Profile, Sounding
from mpm_warp.scenes.sounding.curves import error_of_samples
from mpm_warp.uncertainty.further_runs import CARRIED_ON
from mpm_warp.uncertainty.laws import (
    EFFECTS,
    growth_uncertainty,
    window_uncertainty,
)
from tests.mpm_warp.uncertainty.conftest import readings

FACTOR = 10.0
WIDEST = 0.025
"""Half width over the resistance, at most; 0.3 sqrt(h) over a factor of 11 alone is 0.016."""


def stated(sounding: Sounding) -> tuple[float, float]:
    """Correction and half width of one sample, over the strength, whatever its noise."""
    strength = sounding.undrained_shear_strength
    samples = np.full(1, FACTOR * strength)
    error = error_of_samples(sounding, np.array([sounding.from_depth]), samples)
    return float(error.correction[0]), float(error.half_width[0]) / strength


@pytest.mark.parametrize("name", ["domain_radius", "domain_above", "cells_per_radius"])
def test_a_smaller_window_or_wider_cells_are_less_certain_as_of_a_cone_test(name: str) -> None:
    default = Sounding()
    if name == "cells_per_radius":
        worse = Sounding(cells_per_radius=2.4)
        sizes = (np.sqrt(3.0) / 4.0, np.sqrt(3.0) / 5.0)
        expected = EFFECTS["mesh"].half_width ** 2 * (sizes[0] ** 2 - sizes[1] ** 2)
        expected += np.subtract(*(growth_uncertainty(it, 0.4) ** 2 for it in sizes))
    else:
        worse = Sounding(**{name: 0.75 * default.default_extents[name]})
        of_default = EFFECTS["domain"].half_width
        expected = (of_default + window_uncertainty(1.0 / 0.75)) ** 2 - of_default**2
    # The window ends at the nearest row, so its extents differ a little.
    assert stated(worse)[1] ** 2 - stated(default)[1] ** 2 == pytest.approx(expected, rel=0.01)


def test_beyond_the_anisotropy_measured_the_reason_is_told_with_its_depths() -> None:
    """Ground whose Delta grows with depth, as under K0: it is beyond 0.95 from 2 m on."""
    depth = np.array([0.0, 2.0, 4.0])
    ground = Profile(
        depth=depth,
        strength=np.full(3, 20e3),
        shear_modulus=np.full(3, 2e6),
        unit_weight=np.full(3, 16e3),
        stress_anisotropy=np.array([0.3, 0.95, 0.99]),
    )
    sounding = Sounding(profile=ground.text, from_depth=1.5, to_depth=2.5)
    places = np.array([1.5, 1.9, 2.1, 2.4])
    error = error_of_samples(sounding, places, np.full(4, FACTOR * 20e3))
    assert np.isnan(error.half_width).tolist() == [False, False, True, True]
    assert (error.correction > 0.24).all()
    reason = f"Delta: the stress anisotropy is beyond 0.95, from 2.1 to 2.4 m: {CARRIED_ON}"
    assert error.reason == reason


@pytest.mark.parametrize("index", [100, 50])
def test_near_borders_nothing_is_known_and_the_depths_are_told(index: float) -> None:
    """Of strength, and of stiffness beside it; two equal rows are no border."""
    upper = "0, 10, 100; 6, 10, 100; 6, 10, 100; 8, 10, 100"
    lower = f"8, 30, {index}; 9, 30, {index}; 9, 10, {index}"
    head = "depth [m], strength [kPa], rigidity_index [1]"
    sounding = Sounding(profile=f"{head}; {upper}; {lower}", from_depth=5.0)
    radius = sounding.cone_radius
    places = np.concatenate([[6.0], *(b + radius * np.arange(-14.5, 20.0) for b in (8.0, 9.0))])
    error = error_of_samples(sounding, places, np.full(len(places), FACTOR * 20e3))
    way = (places - 8.0) / radius
    near = (way > -10.0) & (way < 16.0)
    np.testing.assert_array_equal(np.isnan(error.half_width)[places < 8.5], near[places < 8.5])
    assert (error.correction > 0.24).all()  # so the curve has no jump
    assert error.reason.startswith("border: the resistance feels another layer")
    assert error.reason.count(" to ") == 2


@pytest.mark.parametrize(
    ("strengths", "thickness", "before", "behind"),
    [
        ([80.0, 30.0], 1.1, 10.0, 16.0),
        ([80.0, 15.0], 1.1, 16.0, 30.0),  # a change by more than a factor of four
        (np.geomspace(80.0, 10.0, 20), 3.0, 10.0, 16.0),  # in rows that differ little
        ([80.0, 60.0], 1.1, -50.0, -50.0),  # little, as rows of a measured profile differ
        ([80.0, 30.0], 11.0, -50.0, -50.0),  # over many radii
    ],
)
def test_a_change_within_a_few_radii_is_a_border(
    strengths: list[float], thickness: float, before: float, behind: float
) -> None:
    """It is told to the way within which it changes, a radius and a half."""
    radius = Sounding().cone_radius
    depths = 8.0 + radius * np.linspace(0.0, thickness, len(strengths))
    rows = [(0.0, strengths[0]), *zip(depths, strengths, strict=True)]
    table = "; ".join(f"{depth:.9f}, {strength}, 100" for depth, strength in rows)
    head = "depth [m], strength [kPa], rigidity_index [1]"
    sounding = Sounding(profile=f"{head}; {table}", from_depth=5.0)
    way = np.arange(-50.25, 50.0)
    near = sounding.ground.near_border(8.0 / radius + way, radius)
    assert near[(way > -before) & (way < behind + thickness)].all()
    assert not near[(way < -before - 1.5) | (way > behind + thickness + 1.5)].any()


@pytest.mark.parametrize(
    ("column", "first", "second"),
    [
        ("stress_anisotropy [1]", 0.01, -0.01),
        ("adhesion_factor [1]", 0.0, 0.01),
        ("unit_weight [kN/m3]", 10.0, 18.0),
    ],
)
def test_a_change_that_does_not_change_the_resistance_is_no_border(
    column: str, first: float, second: float
) -> None:
    rows = f"0, 20, {first}; 8, 20, {first}; 8.005, 20, {second}"
    sounding = Sounding(profile=f"depth [m], strength [kPa], {column}; {rows}", from_depth=5.0)
    radius = sounding.cone_radius
    assert not sounding.ground.near_border(np.arange(7.0, 9.0, 0.01) / radius, radius).any()


@pytest.mark.parametrize("index", [12.0, 24.0, 80.0])
def test_a_sounding_simulates_the_poissons_ratio_that_it_is_corrected_for(index: float) -> None:
    sounding = Sounding(rigidity_index=index, poissons_ratio=0.4999)
    assert sounding.test.laws(penetration=1.0).poissons_ratio_reduction == 0.0


def test_normally_consolidated_clay_under_k0_has_a_band_at_every_depth() -> None:
    """K0 0.6, 16 kN/m3, water to the surface: Delta is 0.5 at 2.2 m, and 0.75 at 20 m."""
    depth = np.linspace(0.0, 25.0, 101)
    strength = 2e3 + 1.5e3 * depth
    ground = Profile(
        depth=depth,
        strength=strength,
        shear_modulus=150.0 * strength,
        unit_weight=np.full(depth.size, 16e3),
        stress_anisotropy=0.4 * (16e3 - 9.81e3) * depth / (2.0 * strength),
    )
    sounding = Sounding(profile=ground.text, adhesion_factor=0.4, from_depth=2.0, to_depth=20.0)
    places = np.linspace(2.0, 20.0, 50)
    resistance = 11.0 * (2e3 + 1.5e3 * places)
    error = error_of_samples(sounding, places, resistance)
    assert error.reason == ""
    assert (error.half_width <= WIDEST * resistance).all()
    from_top = Sounding(profile=ground.text, adhesion_factor=0.4, from_depth=0.0, to_depth=20.0)
    below_top = (np.arange(1200) + 0.5) * from_top.spacing
    of_top = 11.0 * (2e3 + 1.5e3 * below_top)
    error = error_of_samples(from_top, below_top, of_top)
    assert np.isnan(error.half_width[0])
    assert error.reason.startswith("surface: the surface is in the window to a depth of ")
    is_deep = below_top > 2.0
    assert (error.half_width[is_deep] <= WIDEST * of_top[is_deep]).all()


@pytest.mark.parametrize("row", readings("sample_noise"), ids=lambda row: ", ".join(row.values()))
def test_the_noise_of_fast_soundings_in_compressible_clay_is_within_the_half_width(
    row: dict[str, str],
) -> None:
    index, adhesion, ratio, speed, factor, deviation = map(float, row.values())
    sounding = Sounding(
        rigidity_index=index, adhesion_factor=adhesion, poissons_ratio=ratio, speed_ratio=speed
    )
    strength = sounding.undrained_shear_strength
    error = error_of_samples(sounding, np.array([1.2]), np.array([factor * strength]))
    waves = math.sqrt((1.0 - 2.0 * ratio) / (2.0 * (1.0 - ratio)))
    of_sample, of_inflow = (EFFECTS[name].half_width for name in ("sample", "inflow"))
    noise = max(of_sample, of_inflow * factor * speed * waves)
    assert 1.9 * deviation <= noise <= float(error.half_width[0]) / strength
