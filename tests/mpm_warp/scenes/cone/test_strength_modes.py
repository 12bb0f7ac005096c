"""Cone factors by the test that su is from, and the rigidity index that goes with it."""

from typing import Any

import pytest
import xarray as xr

from mpm_warp.scenes.catalogue import scene_class
from mpm_warp.scenes.cone.strength_modes import factors_by_mode, rigidity_of_law

FACTOR = xr.Dataset({"cone_factor": ((), 9.0, {"long_name": "cone factor"})})
DIRECTED = {
    "material": "anisotropic",
    "strength_compression": 20e3,
    "strength_extension": 10e3,
    "strength_simple_shear": 15e3,
}


def cone_test(**given: Any) -> Any:
    test: Any = scene_class("cone_penetration")
    return test(**given)


def test_a_cone_factor_is_given_over_each_strength_and_over_their_mean() -> None:
    found = factors_by_mode(cone_test(**DIRECTED), FACTOR)
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
    assert FACTOR.cone_factor.attrs["long_name"] == "cone factor"


def test_clay_that_softens_has_the_factors_of_intact_clay() -> None:
    strong = {name: 10.0 * su for name, su in DIRECTED.items() if isinstance(su, float)}
    test = cone_test(material="anisotropic", **strong, remoulded_strength_ratio=0.5, ductility=10.0)
    found = factors_by_mode(test, FACTOR)
    assert float(found["cone_factor_by_extension"]) == pytest.approx(18.0)
    assert test.clay.strength == test.undrained_shear_strength == 200e3


def test_clay_whose_strength_the_scene_gives_has_one_factor() -> None:
    for material in ("tresca", "von_mises"):
        test = cone_test(material=material)
        assert not factors_by_mode(test, FACTOR)
        assert not rigidity_of_law(test)


def test_a_linear_law_has_one_rigidity_index() -> None:
    found = rigidity_of_law(cone_test(**DIRECTED, rigidity_index=80.0))
    assert [float(it) for it in found.values()] == pytest.approx([80.0, 80.0])


def test_a_law_without_a_constant_stiffness_has_that_of_its_element_test() -> None:
    test = cone_test(material="modified_cam_clay")
    found = rigidity_of_law(test)
    element: Any = scene_class("element_test")
    known = element(
        material="modified_cam_clay",
        test="simple_shear",
    ).run()
    for name, variable in found.items():
        assert float(variable) == pytest.approx(float(known[name]), rel=1e-2)
    assert float(found["half_strength_rigidity_index"]) < float(
        found["small_strain_rigidity_index"]
    )
