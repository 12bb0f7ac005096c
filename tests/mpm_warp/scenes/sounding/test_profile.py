"""The ground by depth: what a table says, and what is wrong with it in one line."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from mpm_warp import ParameterError, Profile
from mpm_warp.scenes.sounding.sounding import Sounding
from tests.mpm_warp.conftest import refused
from tests.mpm_warp.scenes.conftest import scene

offered = partial(scene, "sounding")
HEAD = "depth [m], strength [kPa]"
TEXT = """
depth [m], strength [kPa], rigidity_index [1], unit_weight [kN/m3]
0, 40, 100, 18
2, 10, 100, 17
2, 20, 50, 16
4, 30, 50, 16
"""


@pytest.fixture
def profile() -> Profile:
    """A crust that weakens with depth, and a layer that grows stronger."""
    return Profile.read(TEXT)


def test_a_table_is_read_in_its_units(profile: Profile) -> None:
    np.testing.assert_array_equal(profile.depth, [0.0, 2.0, 2.0, 4.0])
    np.testing.assert_allclose(profile.strength, [40e3, 10e3, 20e3, 30e3])
    np.testing.assert_allclose(profile.shear_modulus, [4e6, 1e6, 1e6, 1.5e6])
    np.testing.assert_allclose(profile.unit_weight, [18e3, 17e3, 16e3, 16e3])


def test_its_text_gives_the_same_profile(profile: Profile) -> None:
    again = Profile.read(profile.text)
    for name in vars(profile):
        np.testing.assert_array_equal(getattr(again, name), getattr(profile, name))
    assert "\n" not in profile.text


def test_columns_that_are_left_out_have_their_defaults() -> None:
    short = Profile.read("depth [m], strength [kPa]; 0, 10; 5, 20")
    np.testing.assert_allclose(short.shear_modulus, 100.0 * short.strength)
    np.testing.assert_allclose(short.unit_weight, 17e3)
    assert Profile.read("strength [MPa], depth [mm]; 1, 0").strength == [1e6]


LIMITED = (
    "depth [m], strength [Pa], shear_modulus [Pa], unit_weight [N/m3]; "
    "0, 2e4, 2e6, 17e3; 9, {}, 2e6, {}"
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "header: must name columns"),
        ("0, 40; 2, 10", "header: must name columns with units"),
        ("depth, strength [kPa]; 0, 1", "column depth has no unit, must have [m] or [cm] or [mm]"),
        ("depth [m], strength [kg]; 0, 1", "column strength has the unit [kg], must have [Pa]"),
        ("depth [m], strenght [kPa]; 0, 1", "unknown column 'strenght'; did you mean 'strength'?"),
        ("depth [m], su [kPa]; 0, 1", "unknown column 'su'; give 'strength'"),
        ("z [m], strength [kPa]; 0, 1", "unknown column 'z'; give 'depth'"),
        ("depth [m], k0 [1]; 0, 1", "unknown column 'k0'; give 'K0', or 'stress_anisotropy', (1 -"),
        ("depth [m], depth [m]; 0, 1", "column depth is there twice"),
        ("depth [m]; 0", "column strength is missing"),
        (HEAD, "has no rows below its header"),
        (f"{HEAD}; 0, 1, 2", "row 1 '0, 1, 2' has 3 values, must have 2"),
        (f"{HEAD}; 0, stiff", "row 1 '0, stiff': must be numbers"),
        (f"{HEAD}; 0, 1; 2, -3", "strength in row 2 is -3000, must be > 0"),
        (f"{HEAD}; 0, nan", "row 1 '0, nan': must be numbers, as 1.5 or 1.5e-3"),
        (f"{HEAD}; 3, 1; 2, 1", "depth in row 2 is 2 m, must not be above"),
        (f"{HEAD}; 1, 1; 1, 2; 1, 3", "depth 1 m is in three rows"),
        (
            "depth [m], strength [Pa], rigidity_index [1], shear_modulus [Pa]; 0, 1, 1, 1",
            "has rigidity_index and shear_modulus; keep one of them",
        ),
        (f"{HEAD}, K0 [1]; 0, 1, 1", "column ground_water is missing"),
        (
            f"{HEAD}, K0 [1], ground_water [m]; 9, 10, 0.4, 0",
            "stress_anisotropy by K0 in row 1 is 1.9413, must be > -1 and < 1",
        ),
        (
            f"{HEAD}, unit_weight [kN/m3], K0 [1], ground_water [m]; 0, 9, 7, 1, 0; 9, 9, 7, 1, 0",
            "u0 is above sigma_v0 at 9 m; unit_weight is that of soil with its water, 14 to 22",
        ),
    ],
)
def test_what_is_wrong_is_told_in_one_line(text: str, message: str) -> None:
    refused(lambda: Profile.read(text), ParameterError, f"profile: {message}")


def test_k0_and_ground_water_give_the_stress_anisotropy() -> None:
    """The worked example of the guide: 5 m deep, K0 0.6, 16.5 kN/m3, water at 1 m, su 25 kPa."""
    head = "depth [m], strength [kPa], unit_weight [kN/m3], K0 [1], ground_water [m]"
    ground = Profile.read(
        f"{head}; 0, 25, 16.5, 0.6, 1; 0.5, 25, 16.5, 0.6, 1; 5, 25, 16.5, 0.6, 1"
    )
    expected = 0.4 * np.array([0.0, 0.5 * 16.5, 16.5, 5 * 16.5 - 4 * 9.81]) / 50.0
    np.testing.assert_allclose(ground.stress_anisotropy, expected)
    again = Profile.read(ground.text)
    np.testing.assert_array_equal(again.stress_anisotropy, ground.stress_anisotropy)


def test_a_water_table_between_two_rows_is_a_row() -> None:
    """Whose stiffness is linear between them, though the rigidity index is not."""
    head = "depth [m], strength [kPa], rigidity_index [1], K0 [1], ground_water [m]"
    ground = Profile.read(f"{head}; 0, 10, 50, 0.5, 2; 6, 40, 200, 0.8, 2")
    np.testing.assert_array_equal(ground.depth, [0.0, 2.0, 6.0])
    np.testing.assert_allclose(ground.strength, [10e3, 20e3, 40e3])
    np.testing.assert_allclose(ground.shear_modulus, [0.5e6, 3e6, 8e6])
    vertical = np.array([0.0, 2 * 17e3, 6 * 17e3 - 4 * 9.81e3])
    delta = np.array([0.5, 0.4, 0.2]) * vertical / (2.0 * ground.strength)
    np.testing.assert_allclose(ground.stress_anisotropy, delta)


def test_arrays_of_different_lengths_are_refused(profile: Profile) -> None:
    refused(lambda: replace(profile, strength=np.ones(2)), ParameterError, "strength has shape")


def test_means_and_stresses_are_exact_integrals(profile: Profile) -> None:
    """Of what is linear between the rows, over a border, and beyond the last row."""
    depth = np.array([1.0, 2.0, 4.0])
    # From 0.5 to 1.5 m: 25 kPa in the middle; from 1.5 to 2.5: half of 13.75 and of 21.25 kPa.
    expected = [25e3, 0.5 * (13.75e3 + 21.25e3), 0.5 * (28.75e3 + 30e3)]
    np.testing.assert_allclose(profile.mean_strength_around(depth, 0.5), expected, rtol=1e-12)
    expected = [17.75e3, 35e3, 35e3 + 32e3]
    np.testing.assert_allclose(profile.vertical_stress_at(depth), expected, rtol=1e-12)


def test_ratios_are_those_to_the_strongest_and_the_stiffest(profile: Profile) -> None:
    variation = profile.variation(origin_depth=3.0)
    place = np.array([[1.0, 0.0], [1.0, 2.0]])  # 3 m and 1 m deep
    np.testing.assert_allclose(variation.at(place, variation.strength_ratio), [25.0 / 40.0] * 2)
    np.testing.assert_allclose(
        variation.at(place, variation.stiffness_ratio), [1.25 / 4.0, 2.5 / 4.0]
    )


def test_uniform_ground_has_no_variation() -> None:
    assert Sounding().ground.variation(origin_depth=0.0) is None
    assert Sounding(layer_top=4.0).ground.variation(origin_depth=0.0) is None


@pytest.mark.parametrize(
    ("thickness", "strength"), [(2.0, [20e3, 75e3, 40e3]), (None, [20e3, 75e3, 120e3])]
)
def test_a_layer_multiplies_the_strength(thickness: float | None, strength: list[float]) -> None:
    ground = Sounding(
        undrained_shear_strength=10e3,
        strength_gradient=10e3 / 3,
        layer_top=4.0,
        layer_thickness=thickness,
        layer_strength_ratio=3.0,
    ).ground
    np.testing.assert_allclose(ground.strength_at(np.array([3.0, 4.5, 9.0])), strength)
    assert ground.thinnest_layer == (2.0 if thickness else np.inf)


def test_a_part_of_the_ground_is_the_same_there_and_goes_on_beyond(profile: Profile) -> None:
    part = profile.between(1.0, 3.0)
    depth = np.array([1.0, 1.7, 2.0, 2.9])
    for name in ("strength_at", "shear_modulus_at"):
        np.testing.assert_allclose(getattr(part, name)(depth), getattr(profile, name)(depth))
    np.testing.assert_allclose(part.strength_at(np.array([0.0, 5.0])), [25e3, 25e3])
    assert part.strength.max() == 25e3  # less than in the crust
