"""The ground by depth of other laws than Tresca: strengths by direction, and modified Cam clay."""

import math
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from mpm_warp import Anisotropic, ParameterError
from mpm_warp.fields.flat import flat_values
from tests.mpm_warp.scenes.conftest import scene
from tests.mpm_warp.scenes.sounding.test_profile import LIMITED, TEXT

offered = partial(scene, "sounding")
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
