"""The ground by depth: what a table says, and what is wrong with it in one line."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mpm_warp.errors import ParameterError
from mpm_warp.materials.anisotropic import Anisotropic
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.sounding import Sounding

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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "header: must name columns"),
        ("0, 40; 2, 10", "must name columns with units"),
        ("depth, strength [kPa]; 0, 1", "column depth has no unit, must have [m] or [cm] or [mm]"),
        ("depth [m], strength [kg]; 0, 1", "column strength has the unit [kg], must have [Pa]"),
        ("depth [m], strenght [kPa]; 0, 1", "unknown column 'strenght'; did you mean 'strength'?"),
        ("depth [m], depth [m]; 0, 1", "column depth is there twice"),
        ("depth [m]; 0", "column strength is missing"),
        ("depth [m], strength [kPa]", "has no rows below its header"),
        ("depth [m], strength [kPa]; 0, 1, 2", "row 1 '0, 1, 2' has 3 values, must have 2"),
        ("depth [m], strength [kPa]; 0, stiff", "row 1 '0, stiff': must be numbers"),
        ("depth [m], strength [kPa]; 0, 1; 2, -3", "strength in row 2 is -3000, must be > 0"),
        ("depth [m], strength [kPa]; 0, nan", "strength in row 1 is nan, must be > 0"),
        ("depth [m], strength [kPa]; 3, 1; 2, 1", "depth in row 2 is 2 m, must not be above"),
        ("depth [m], strength [kPa]; 1, 1; 1, 2; 1, 3", "depth 1 m is in three rows"),
        (
            "depth [m], strength [Pa], rigidity_index [1], shear_modulus [Pa]; 0, 1, 1, 1",
            "has rigidity_index and shear_modulus; keep one of them",
        ),
    ],
)
def test_what_is_wrong_is_told_in_one_line(text: str, message: str) -> None:
    with pytest.raises(ParameterError, match=re.escape(message)) as refusal:
        Profile.read(text)
    assert "\n" not in str(refusal.value)
    assert str(refusal.value).startswith("profile: ")


def test_arrays_of_different_lengths_are_refused(profile: Profile) -> None:
    with pytest.raises(ParameterError, match="strength has shape"):
        replace(profile, strength=np.ones(2))


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
    assert variation is not None
    place = np.array([[1.0, 0.0], [1.0, 2.0]])  # 3 m and 1 m deep
    np.testing.assert_allclose(variation.strength_ratio_at(place), [25.0 / 40.0] * 2)
    np.testing.assert_allclose(variation.stiffness_ratio_at(place), [1.25 / 4.0, 2.5 / 4.0])


def test_uniform_ground_has_no_variation() -> None:
    assert Sounding().ground.variation(origin_depth=0.0) is None
    assert Sounding(layer_top=4.0).ground.variation(origin_depth=0.0) is None


@pytest.mark.parametrize(
    ("thickness", "strength"), [(2.0, [20e3, 75e3, 40e3]), (None, [20e3, 75e3, 120e3])]
)
def test_a_layer_multiplies_the_strength_within_it(
    thickness: float | None, strength: list[float]
) -> None:
    ground = Sounding(
        undrained_shear_strength=10e3,
        strength_gradient=10e3 / 3,
        layer_top=4.0,
        layer_thickness=thickness,
        layer_strength_ratio=3.0,
    ).ground
    at = ground.strength_at(np.array([3.0, 4.5, 9.0]))
    np.testing.assert_allclose(at, strength)
    assert ground.thinnest_layer == (2.0 if thickness else np.inf)


def test_a_part_of_the_ground_is_the_same_there_and_goes_on_beyond(profile: Profile) -> None:
    part = profile.between(1.0, 3.0)
    depth = np.array([1.0, 1.7, 2.0, 2.9])
    for name in ("strength_at", "shear_modulus_at"):
        np.testing.assert_allclose(getattr(part, name)(depth), getattr(profile, name)(depth))
    np.testing.assert_allclose(part.strength_at(np.array([0.0, 5.0])), [25e3, 25e3])
    assert part.strength.max() == 25e3  # less than in the crust


DIRECTED = (
    "depth [m], strength_compression [kPa], strength_extension [kPa], strength_simple_shear [kPa]; "
    "0, 20, 10, 15; 4, 20, 10, 15; 4, 40, 24, 30; 12, 50, 30, 40"
)


def test_strengths_by_direction_vary_with_depth() -> None:
    sounding = Sounding(profile=DIRECTED, from_depth=2.0, to_depth=5.0)
    material, ground = sounding.build().material, sounding.ground_passed
    assert isinstance(material, Anisotropic)
    strengths = ground.strengths_in_row(int(ground.strength.argmax()))
    assert material.strength == strengths["strength_compression"]
    for depth, compression, extension, simple_shear in ((3.0, 20, 10, 15), (4.0, 40, 24, 30)):
        at = material.properties_at(np.array([0.0, sounding.start_depth - depth]))
        of_place = replace(
            material,
            strength_compression=1e3 * compression,
            strength_extension=1e3 * extension,
            strength_simple_shear=1e3 * simple_shear,
            strength_horizontal=None,
            variation=None,
        )
        np.testing.assert_allclose(at[2:], of_place.properties[2:], rtol=1e-12)


def test_uniform_ground_has_the_strengths_of_its_rows() -> None:
    profile = "depth [m], strength [kPa], strength_extension [kPa], strength_simple_shear [kPa]; "
    material = Sounding(profile=f"{profile} 0, 20, 10, 15; 9, 20, 10, 15").build().material
    assert isinstance(material, Anisotropic)
    assert material.variation is None
    assert material.undrained_strength("triaxial_extension") == pytest.approx(10e3)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("strength_extension", "strength_horizontal", "needs strength_extension and strength_simp"),
        ("24, 30", "24, 5", r"row 3: Anisotropic: strength_extension = 24000 Pa must be > 30000"),
        ("40, 24", "40, 0", r"strength_extension in row 3 is 0, must be > 0"),
    ],
)
def test_strengths_that_are_not_possible_are_told_with_their_row(
    old: str, new: str, message: str
) -> None:
    with pytest.raises(ParameterError, match=message):
        Profile.read(DIRECTED.replace(old, new))
