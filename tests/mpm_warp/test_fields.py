"""Definitions of parameters: what is refused, and what the refusal says."""

import dataclasses

import numpy as np
import pytest
import xarray as xr

from mpm_warp import ConePenetration, ParameterError, parameter, scene_class, scene_names
from mpm_warp.fields.checked import check_fields
from mpm_warp.fields.declaration import Derived
from mpm_warp.fields.flat import parameters_of
from mpm_warp.fields.names import did_you_mean, known_names, nearest_name


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("adhesion_facto", 1, "did you mean 'adhesion_factor'"),
        ("su", 20, "unknown parameter 'su'; give 'undrained_shear_strength', in Pa"),
        ("adhesion_factor", 1.5, "must be a number >= 0 and <= 1"),
        ("adhesion_factor", -0.1, "must be a number >= 0 and <= 1"),
        ("adhesion_factor", "1", "must be a number"),
        ("adhesion_factor", True, "must be a number"),
        ("adhesion_factor", None, "must be a number"),
        ("poissons_ratio", 0.5, "<= 0.4999"),
        ("rigidity_index", float("nan"), "must be a number"),
        ("cone_radius", float("inf"), "must be a number"),
        ("cone_radius", 10**400, "must be a number"),
        ("cone_radius", xr.DataArray(1.0), "Size: 8B array(1.) is not allowed"),
        ("particles_per_cell", 5, "one of 4, 9, 16, 25"),
        ("particles_per_cell", 4.5, "one of 4, 9, 16, 25"),
        ("material", "tresk", "did you mean 'tresca'"),
        (
            "material.swelling_slope",
            0.1,
            "; give it with its law, material = {'law': .., 'swelling_slope': ..}",
        ),
        ("material.swelling_slop", 0.1, "did you mean 'material.swelling_slope'"),
        ("cone_radius", 1e300, "must be a number >= 1e-06 and <= 1000; meaning"),
        ("material", 3, "one of 'tresca', 'von_mises'"),
    ],
)
def test_refusals_name_key_value_and_what_is_allowed(key: str, value: object, said: str) -> None:
    with pytest.raises(ParameterError) as refusal:
        ConePenetration(**{key: value})
    message = str(refusal.value)
    assert refusal.value.key == key
    assert key in message
    assert said in message
    assert "\n" not in message


def test_numbers_those_of_numpy_too_take_the_type_of_the_parameter() -> None:
    for kind in (int, float, np.int64, np.float32, np.float64):
        cone = ConePenetration(rigidity_index=kind(120), particles_per_cell=kind(9))
        assert (cone.rigidity_index, type(cone.rigidity_index)) == (120.0, float)
        assert (cone.particles_per_cell, type(cone.particles_per_cell)) == (9, int)


def test_every_parameter_of_every_scene_is_explained_and_accepts_its_default() -> None:
    for name in scene_names():
        for definition in parameters_of(scene_class(name)).values():
            assert definition.meaning
            assert definition.unit
            assert definition.checked(definition.default) == definition.default


def test_what_is_derived_follows_what_it_is_derived_from() -> None:
    """Also where a scene is made from another; what was given stays as it was given."""
    smooth = ConePenetration()
    assert smooth.shaft_adhesion_factor == 0.0
    assert isinstance(smooth.shaft_adhesion_factor, Derived)
    assert dataclasses.replace(smooth, adhesion_factor=0.5).shaft_adhesion_factor == 0.5
    given = ConePenetration(shaft_adhesion_factor=0.0)
    assert dataclasses.replace(given, adhesion_factor=0.5).shaft_adhesion_factor == 0.0
    kept = dataclasses.replace(
        smooth, adhesion_factor=0.5, shaft_adhesion_factor=float(smooth.shaft_adhesion_factor)
    )
    assert kept.shaft_adhesion_factor == 0.0
    assert smooth == given  # a derived value is a number like any other


def test_what_is_derived_is_checked() -> None:
    with pytest.raises(ParameterError, match=r"half = 6\.0 is not allowed: must be a number <= 5"):
        Halved(whole=12.0)
    assert Halved(whole=4.0).half == 2.0
    assert Halved(whole=12.0, half=1.0).half == 1.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Halved:
    whole: float = parameter(1.0, unit="m", meaning="a length")
    half: float | None = parameter(None, unit="m", meaning="default: half of it", maximum=5)

    def __post_init__(self) -> None:
        check_fields(self, lambda: {"half": 0.5 * self.whole})


def test_the_nearest_name_and_where_none_is_near_all_of_them() -> None:
    assert did_you_mean("eror", ["error", "stress"]) == "; did you mean 'error'?"
    assert did_you_mean("eror", ["error"], likeness=0.9) == ""
    assert did_you_mean("depth", ["error", "stress"]) == ""
    longer = ["speed", "friction_coefficient"]
    assert nearest_name("friction", longer) == "; did you mean 'friction_coefficient'?"
    assert nearest_name("fric", longer) == known_names(longer)
    assert known_names(["error", "stress"]) == "; known: error, stress"
    assert nearest_name("eror", ["error", "stress"]) == "; did you mean 'error'?"
    assert nearest_name("depth", ["error", "stress"]) == "; known: error, stress"
    assert did_you_mean("error", []) == known_names([]) == nearest_name("error", []) == ""
