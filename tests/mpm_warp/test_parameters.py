"""Definitions of parameters: what is refused, and what the refusal says."""

from __future__ import annotations

import pytest
from mpm_warp.scenes.cone_penetration import ConePenetration

from mpm_warp.parameters import (
    ParameterError,
    did_you_mean,
    from_mapping,
    known_names,
    nearest_name,
    parameters_of,
)
from mpm_warp.scenes import UnknownSceneError, scene_class, scene_names


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("adhesion_facto", 1, "did you mean 'adhesion_factor'"),
        ("adhesion_factor", 1.5, "must be a number >= 0 and <= 1"),
        ("adhesion_factor", -0.1, "must be a number >= 0 and <= 1"),
        ("adhesion_factor", "1", "must be a number"),
        ("adhesion_factor", True, "must be a number"),
        ("adhesion_factor", None, "must be a number"),
        ("poissons_ratio", 0.5, "<= 0.4999"),
        ("rigidity_index", float("nan"), "must be a number"),
        ("cone_radius", float("inf"), "must be a number"),
        ("cone_radius", 10**400, "must be a number"),
        ("particles_per_cell", 5, "one of 4, 9, 16, 25"),
        ("particles_per_cell", 4.5, "one of 4, 9, 16, 25"),
        ("material", "tresk", "did you mean 'tresca'"),
        ("material", 3, "one of 'tresca', 'von_mises'"),
    ],
)
def test_refusals_name_key_value_and_what_is_allowed(key: str, value: object, said: str) -> None:
    with pytest.raises(ParameterError) as refusal:
        from_mapping(ConePenetration, {key: value})
    message = str(refusal.value)
    assert refusal.value.key == key
    assert key in message
    assert said in message
    assert "\n" not in message


def test_values_take_the_type_of_the_parameter() -> None:
    scene = from_mapping(ConePenetration, {"rigidity_index": 50, "particles_per_cell": 9.0})
    assert isinstance(scene.rigidity_index, float)
    assert isinstance(scene.particles_per_cell, int)


def test_every_parameter_of_every_scene_is_explained_and_accepts_its_default() -> None:
    for name in scene_names():
        for definition in parameters_of(scene_class(name)).values():
            assert definition.meaning
            assert definition.unit
            assert definition.checked(definition.default) == definition.default


def test_an_unknown_scene_is_refused_by_name() -> None:
    with pytest.raises(UnknownSceneError, match="did you mean 'cone_penetration'"):
        scene_class("cone_penetraton")


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


def test_where_no_name_is_known_none_is_told() -> None:
    assert did_you_mean("error", []) == known_names([]) == nearest_name("error", []) == ""
