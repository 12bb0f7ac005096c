"""The ground by depth: what a table says, and what is wrong with it in one line."""

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from mpm_warp import Anisotropic, ParameterError, Profile
from mpm_warp.fields.flat import flat_values
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


DIRECTED = (
    "depth [m], strength_compression [kPa], strength_extension [kPa], strength_simple_shear [kPa]; "
    "0, 20, 10, 15; 4, 20, 10, 15; 4, 40, 24, 30; 12, 50, 30, 40"
)


def test_strengths_by_direction_vary_with_depth() -> None:
    sounding = offered(material="anisotropic", profile=DIRECTED, from_depth=2.0, to_depth=5.0)
    material, ground = sounding.build().material, sounding.ground_passed
    assert isinstance(material, Anisotropic)
    assert material.strength == ground.strength.max()
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
    profile = f"{DIRECTED.split(';', maxsplit=1)[0]}; 0, 20, 10, 15; 9, 20, 10, 15"
    material = offered(material="anisotropic", profile=profile).build().material
    assert isinstance(material, Anisotropic)
    assert material.variation is None
    assert material.undrained_strength("triaxial_extension") == pytest.approx(10e3)


CAM = "depth [m], mean_effective_stress [kPa], overconsolidation_ratio [1]; 0, 10, 8; 2, 22, 2; "
CAM += "10, 70, 1.2"


def test_cam_clay_by_depth_has_the_strength_and_the_state_of_its_place() -> None:
    """Su = M p0' / sqrt(3) (R / 2)^Lam; p0' and R are linear between the rows of the table.

    So p_c is curved: a chord over 0.8 m is below it by at most 4.8 kPa 0.08 / 4, 1.8e-3 of it.
    """
    sounding = offered(material="modified_cam_clay", profile=CAM, from_depth=3.0, to_depth=6.0)
    material, share = sounding.build().material, 0.8
    assert material.pressure_wave_speed >= sounding.test.soil.pressure_wave_speed
    for depth, p, ratio in ((3.0, 28e3, 1.9), (5.2, 41.2e3, 1.68)):
        place = np.array([0.0, sounding.start_depth - depth])
        state = material.state_at(np.zeros(4), place)
        np.testing.assert_allclose(state, [p, ratio * p, 0.0], rtol=1.8e-3)
        su = p / math.sqrt(3.0) * (0.5 * ratio) ** share
        assert float(sounding.ground.strength_at(np.array(depth))) == pytest.approx(su, rel=1.8e-3)
        at_place = sounding.test.undrained_shear_strength * material.ratio_at(
            place, "strength_ratio"
        )
        assert float(at_place) == pytest.approx(su, rel=1.8e-3)
        stiffness = material.ground_shear_modulus * material.ratio_at(place, "stiffness_ratio")
        assert float(stiffness) == pytest.approx(0.6 * 50.0 * p, rel=1e-9)


def test_friction_and_slopes_by_depth_are_those_of_their_rows() -> None:
    """At a row of the table strength and stiffness are those of the law with its numbers."""
    names = "critical_state_ratio [1], compression_slope [1], swelling_slope [1]"
    profile = f"depth [m], mean_effective_stress [kPa], {names}; 0, 50, 1.2, 0.3, 0.03; "
    profile += "4, 50, 0.8, 0.2, 0.05; 8, 50, 0.8, 0.2, 0.05"
    sounding = offered(material="modified_cam_clay", profile=profile, from_depth=1.0, to_depth=5.0)
    for depth, ratio, compression, swelling in ((0.0, 1.2, 0.3, 0.03), (4.0, 0.8, 0.2, 0.05)):
        su = ratio * 50e3 / math.sqrt(3.0) * 0.5 ** (1.0 - swelling / compression)
        assert float(sounding.ground.strength_at(np.array(depth))) == pytest.approx(su, rel=1e-9)
        modulus = float(sounding.ground.shear_modulus_at(np.array(depth)))
        assert modulus == pytest.approx(0.6 * 2.0 * 50e3 / swelling, rel=1e-9)
    at = sounding.build().material.properties_at(np.array([0.0, sounding.start_depth - 4.0]))
    own: dict[str, Any] = {"critical_state_ratio": 0.8, "compression_slope": 0.2}
    own |= {"swelling_slope": 0.05, "mean_effective_stress": 50e3}
    own = {"material": {"law": "modified_cam_clay", **own}}
    of_row = offered(**own).build()
    np.testing.assert_allclose(at, of_row.material.properties, rtol=1e-12)


K0 = "depth [m], unit_weight [kN/m3], K0 [1], ground_water [m]; 1, 17, 0.8, 1; 3, 17, 0.8, 1; "
K0 += "11, 17, 0.6, 1"
P0 = "mean_effective_stress [kPa]"


def test_k0_and_ground_water_give_the_effective_stress_of_cam_clay() -> None:
    """Both effective stresses are linear between the rows; the vertical ratio goes by their K0."""
    own: dict[str, Any] = {
        "material": "modified_cam_clay",
        "material.vertical_overconsolidation_ratio": 3.0,
    }
    sounding = offered(profile=K0, from_depth=4.0, to_depth=6.0, **own)
    at = np.array([3.0, 7.0, 11.0])
    vertical = 17e3 * at - 9.81e3 * (at - 1.0)
    horizontal = np.interp(at, at[[0, 2]], np.array([0.8, 0.6]) * vertical[[0, 2]])
    mean, ground = (vertical + 2.0 * horizontal) / 3.0, sounding.ground
    rows = np.searchsorted(ground.depth, at)
    np.testing.assert_allclose(ground.depth[rows], at)
    np.testing.assert_allclose(ground.of_law["mean_effective_stress"][rows], mean, rtol=1e-12)
    delta = (vertical - horizontal) / (2.0 * ground.strength[rows])
    np.testing.assert_allclose(ground.stress_anisotropy[rows], delta, rtol=1e-12)
    clay = {
        "material.mean_effective_stress": mean[1],
        "material.earth_pressure_at_rest": (horizontal / vertical)[1],
    }
    test = scene("cone_penetration", **own, **clay)
    assert ground.strength[rows[1]] == pytest.approx(test.undrained_shear_strength, rel=1e-12)
    assert ground.stress_anisotropy[rows[1]] == pytest.approx(test.stress_anisotropy, rel=1e-12)


def test_normally_consolidated_cam_clay_may_change_its_k0() -> None:
    """Its yield surface goes through the stress at rest, wherever the stretch begins and ends."""
    own: dict[str, Any] = {
        "material": "modified_cam_clay",
        "material.vertical_overconsolidation_ratio": 1.0,
    }
    sounding = offered(profile=K0.replace("0.8", "0.3"), from_depth=4.03, to_depth=6.0, **own)
    ground = sounding.ground_passed
    at_rest, mean = ground.of_law["earth_pressure_at_rest"], ground.of_law["mean_effective_stress"]
    deviator = 2.0 * ground.stress_anisotropy * ground.strength
    np.testing.assert_allclose(
        deviator, 3.0 * mean * (1.0 - at_rest) / (1.0 + 2.0 * at_rest), rtol=1e-12
    )


def test_k0_and_ground_water_give_the_stress_anisotropy_of_strengths_by_direction() -> None:
    own = {"strength_compression": 50e3, "strength_extension": 30e3, "strength_simple_shear": 40e3}
    material = {"law": "anisotropic", **own}
    vertical = 11.0 * 17e3 - 10.0 * 9.81e3
    found = offered(material=material, profile=K0, from_depth=3.0).ground.stress_anisotropy[-1]
    assert found == pytest.approx(0.4 * vertical / (2.0 * 50e3), rel=1e-12)


@pytest.mark.parametrize("ratio", ["isotropic", "vertical"])
def test_uniform_cam_clay_is_that_of_the_cone(ratio: str) -> None:
    """To the bit; what the ground says is in the parameters of the sounding too."""
    given: dict[str, Any] = {f"material.{ratio}_overconsolidation_ratio": 3.0}
    sounding = offered(material="modified_cam_clay", **given)
    test = scene("cone_penetration", material="modified_cam_clay", **given)
    assert sounding.undrained_shear_strength == test.undrained_shear_strength
    assert sounding.stress_anisotropy == test.stress_anisotropy
    built, expected = sounding.build().material, test.soil
    assert (built.properties, built.variation) == (expected.properties, None)
    values = {name: value for name, (_, value) in flat_values(sounding).items()}
    stored = {name: float(it) if isinstance(it, float) else it for name, it in values.items()}
    assert offered(**stored) == sounding


def test_uniform_clay_with_strengths_by_direction_is_as_stiff_as_the_cone_has_it() -> None:
    own = {"strength_compression": 40e3, "strength_extension": 24e3, "strength_simple_shear": 32e3}
    material = {"law": "anisotropic", **own}
    clays = [
        scene(name, material=material, rigidity_index=250.0).build().material
        for name in ("sounding", "cone_penetration")
    ]
    assert clays[0].ground_shear_modulus == clays[1].ground_shear_modulus


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"profile": DIRECTED}, "column strength_.* is no parameter of material = 'tresca'"),
        ({"material": "anisotropic", "profile": TEXT}, "column strength: material = 'anisotropic'"),
        (
            {"material": "anisotropic", "profile": DIRECTED.replace("24, 30", "24, 5")},
            r"at 4 m: Anisotropic: strength_extension = 24000 Pa must be > 30000",
        ),
        (
            {"material": "anisotropic", "profile": DIRECTED.replace("40, 24", "40, 0")},
            "at 4 m: Anisotropic: strength_extension = 0 Pa must be > 0",
        ),
        (
            {"material": "anisotropic", "profile": DIRECTED, "stress_anisotropy": -0.55},
            "in the ground that the cone passes: .* differ by 22000 Pa, which must be <= 20000 Pa",
        ),
        (
            {"material": "modified_cam_clay", "profile": CAM.replace("1.2", "0.8")},
            "at 9.2 m: material.isotropic_overconsolidation_ratio = 0.92.* must be a number >= 1",
        ),
        (
            {"material": "modified_cam_clay", "profile": CAM, "stress_anisotropy": 0.9},
            "must be >= .* the stress of the ground is outside the yield surface",
        ),
        (
            {"material": {"law": "modified_cam_clay", "swelling_slope": 0.3}, "profile": CAM},
            "at 0 m: ModifiedCamClay: compression_slope = 0.2 must be > swelling_slope = 0.3",
        ),
        ({"material": "modified_cam_clay", "profile": TEXT}, "column strength: .* leave it out"),
        (
            {"material": "modified_cam_clay", "profile": K0.replace("; 1,", "; 0,")},
            "no effective vertical stress at 0 m, .* begin the ground deeper",
        ),
        (
            {"material": "modified_cam_clay", "profile": K0.replace("unit_weight [kN/m3]", P0)},
            "has K0 with ground_water and mean_effective_stress; keep one of them",
        ),
        ({"profile": K0}, "column strength is missing"),
        (
            {
                "material": {"law": "modified_cam_clay", "mean_effective_stress": 99e3},
                "profile": CAM,
            },
            "material.mean_effective_stress = 99000 is not allowed: the profile has it by depth",
        ),
        ({"material": "modified_cam_clay", "layer_top": 3.0}, "layer_top: .* in a profile"),
        (
            {"material": "modified_cam_clay", "layer_strength_ratio": 0.5},
            "layer_strength_ratio: .* in a profile",
        ),
        (
            {"material": "modified_cam_clay", "undrained_shear_strength": 9e3},
            "undrained_shear_strength: .* has its own strength; leave it out",
        ),
        (
            {
                "material": "modified_cam_clay",
                "material.vertical_overconsolidation_ratio": 2.0,
                "stress_anisotropy": 0.0,
            },
            "stress_anisotropy = 0 is not allowed: the law has it by K0",
        ),
        ({"material": "von_mises", "stress_anisotropy": 0.9}, "must be <= 34641 Pa in compression"),
        ({"profile": LIMITED.format(2e9, 17e3)}, "row 2: undrained_shear_strength = .*, in Pa"),
        ({"profile": LIMITED.format(2e4, 17e6)}, "row 2: unit_weight = .* <= 1e.06; .*, in N m-3"),
        (
            {"profile": LIMITED.format(3e2, 17e3)},
            "row 2: rigidity_index = .* <= 5000; mean",
        ),
    ],
)
def test_ground_that_its_law_does_not_allow_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message) as refusal:
        offered(**given)
    assert len(str(refusal.value).splitlines()) == 1
