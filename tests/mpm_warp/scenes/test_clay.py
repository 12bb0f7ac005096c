"""The clay of a scene: what is chosen and given together, and factors by mode of strength."""

from functools import partial

import numpy as np
import pytest
import xarray as xr

from mpm_warp import EinavRandolph, ParameterError, Tresca
from mpm_warp.materials.anisotropic import Anisotropic
from mpm_warp.scenes.material.material_point import MaterialPoint
from mpm_warp.scenes.strength_modes import by_mode, cone_factors_by_mode, rigidity_of_law
from tests.mpm_warp.conftest import DIRECTED, STRENGTHS, refused
from tests.mpm_warp.scenes.conftest import scene

cone_test = partial(scene, "cone_penetration")
SU = {"undrained_shear_strength": 1e4}
REST = np.zeros(4)


def test_clay_whose_strength_nothing_changes_is_perfectly_plastic() -> None:
    """Whatever reference and ductility are: they belong to nothing then."""
    point = MaterialPoint(reference_strain_rate=0.1, ductility=10.0, **SU)
    expected = Tresca(shear_modulus=1e6, poissons_ratio=0.49, density=1700.0, strength=1e4)
    assert point.clay.built(speed_up=3.0, density=1700.0, stress_at_rest=REST) == expected


def test_strain_rates_are_those_of_reality() -> None:
    """A run that is three times as fast takes three times the rate for that of reference."""
    point = MaterialPoint(rate_factor=0.1, reference_strain_rate=0.1, **SU)
    clay = point.clay.built(speed_up=3.0, density=1700.0, stress_at_rest=REST)
    assert isinstance(clay, EinavRandolph)
    assert clay.reference_strain_rate == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"rate_factor": 0.1}, "rate_factor = 0.1 needs reference_strain_rate, in 1/s: give both"),
        ({"remoulded_strength_ratio": 0.2}, "remoulded_strength_ratio = 0.2 needs ductility, the"),
        ({"remoulded_strength_ratio": 0.2, "ductility": 0.01}, "ductility = 0.01 is too brittle"),
    ],
)
def test_what_no_clay_is_like_is_refused_in_one_line(given: dict[str, float], message: str) -> None:
    refused(lambda: MaterialPoint(**given), ParameterError, message)


FACTOR = xr.Variable((), 9.0, {"long_name": "cone factor"})
CONE = xr.Dataset({"cone_factor": FACTOR, "pore_pressure_factor_shoulder": ((), 4.5)})


def test_a_cone_factor_is_given_over_each_strength_and_over_their_mean() -> None:
    found = by_mode(cone_test(**DIRECTED).clay, cone_factor=FACTOR)
    factors = {name: float(it) for name, it in found.items() if name.startswith("cone_factor")}
    assert factors == pytest.approx(
        {
            "cone_factor": 9.0,
            "cone_factor_by_compression": 9.0,
            "cone_factor_by_simple_shear": 12.0,
            "cone_factor_by_extension": 18.0,
            "cone_factor_by_average": 12.0,
        }
    )
    assert found["cone_factor"].attrs["long_name"] == "cone factor, compression"
    assert float(found["strength_by_extension"]) == pytest.approx(10e3)
    assert FACTOR.attrs["long_name"] == "cone factor"


def test_a_factor_over_an_su_that_is_given_says_so() -> None:
    own = cone_test(**DIRECTED)
    for su, said in ((1.0, "compression"), (1.25, "by the su given")):
        given = cone_test(**DIRECTED, undrained_shear_strength=su * own.undrained_shear_strength)
        found = by_mode(given.clay, cone_factor=FACTOR)
        assert found["cone_factor"].attrs["long_name"] == f"cone factor, {said}"
        assert float(found["cone_factor_by_compression"]) == pytest.approx(9.0 * su)


def test_clay_that_softens_has_the_factors_of_intact_clay() -> None:
    strong = {name: 10.0 * su for name, su in STRENGTHS.items()}
    test = cone_test(material=Anisotropic(**strong), remoulded_strength_ratio=0.5, ductility=10.0)
    found = by_mode(test.clay, cone_factor=FACTOR)
    assert float(found["cone_factor_by_extension"]) == pytest.approx(18.0)
    assert test.soil.strength == test.undrained_shear_strength == 200e3


def test_clay_whose_strength_the_scene_gives_has_one_factor() -> None:
    for material in ("tresca", "von_mises"):
        test = cone_test(material=material)
        assert not by_mode(test.clay, cone_factor=FACTOR)
        assert not rigidity_of_law(test.clay, test.soil)


def test_pore_pressure_has_factors_by_mode_and_bq_has_none() -> None:
    """N_ke = (qnet + sigma'_v0 - (u2 - u0)) / su, where the law knows an effective stress."""
    directed = cone_factors_by_mode(cone_test(**DIRECTED), CONE)
    assert "N_ke" not in directed
    assert float(directed["Bq"]) == pytest.approx(0.5)
    assert float(directed["N_du"]) == pytest.approx(4.5)
    assert float(directed["N_du_by_extension"]) == pytest.approx(9.0)
    assert directed["N_du"].attrs["long_name"] == "pore pressure factor N_du, compression"
    for anisotropy in (0.0, 0.4):
        test = cone_test(
            material={"law": "modified_cam_clay", "isotropic_overconsolidation_ratio": 1.5},
            stress_anisotropy=anisotropy,
        )
        su = test.undrained_shear_strength
        vertical = 50e3 + 2.0 / 3.0 * 2.0 * anisotropy * su
        found = cone_factors_by_mode(test, CONE)
        assert float(found["N_ke"]) == pytest.approx(4.5 + vertical / su)
        of_compression = (4.5 * su + vertical) / float(found["strength_by_compression"])
        assert float(found["N_ke_by_compression"]) == pytest.approx(of_compression)
    assert not cone_factors_by_mode(cone_test(material="tresca"), CONE)


def test_a_t_bar_and_a_ball_have_factors_by_mode() -> None:
    for name in ("t_bar_penetration", "ball_penetration"):
        found = by_mode(scene(name, **DIRECTED).clay, resistance_factor=FACTOR)
        assert float(found["resistance_factor_by_simple_shear"]) == pytest.approx(12.0)


def test_a_linear_law_has_one_rigidity_index() -> None:
    test = cone_test(**DIRECTED, rigidity_index=80.0)
    found = rigidity_of_law(test.clay, test.soil)
    assert [float(it) for it in found.values()] == pytest.approx([80.0, 80.0])


def test_a_law_without_a_constant_stiffness_has_that_of_its_element_test() -> None:
    test = cone_test(material="modified_cam_clay")
    found = rigidity_of_law(test.clay, test.soil)
    known = scene("element_test", material="modified_cam_clay", test="simple_shear").run()
    for name, variable in found.items():
        assert float(variable) == pytest.approx(float(known[name]), rel=1e-2)
    assert float(found["half_strength_rigidity_index"]) < float(
        found["small_strain_rigidity_index"]
    )
