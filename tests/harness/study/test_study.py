import dataclasses
from pathlib import Path

import pytest

from harness.study.cases import Case
from harness.study.description import unusual_values
from harness.study.files import study_names
from harness.study.study import Study, load_study
from harness.study.tables import LONGEST_MESSAGE, StudyError
from tests.harness.conftest import values


@pytest.mark.parametrize("name", study_names())
def test_a_study_that_ships_is_valid_and_has_no_value_that_looks_like_a_slip(name: str) -> None:
    study = load_study(name)
    assert study.name == name
    assert study.cases
    assert unusual_values(study) == []


def test_values_have_the_type_of_the_parameter(small: Study) -> None:
    assert small.parts[0].varied == {"adhesion_factor": (0.0, 0.5, 1.0)}
    assert all(type(value) is float for value in small.parts[0].varied["adhesion_factor"])
    assert type(small.parts[0].fixed["penetration"]) is float
    assert type(small.parts[0].fixed["particles_per_cell"]) is int


def test_a_list_varies_what_was_fixed(small_file: Path) -> None:
    study = load_study(str(small_file), ["cells_per_radius=[1, 2]"])
    assert study.parts[0].varied == {"adhesion_factor": (0, 0.5, 1), "cells_per_radius": (1, 2)}
    assert "cells_per_radius" not in study.parts[0].fixed


def test_a_scalar_fixes_what_varied(small_file: Path) -> None:
    study = load_study(str(small_file), ["adhesion_factor = 0.25"])
    assert study.parts[0].varied == {}
    assert study.parts[0].fixed["adhesion_factor"] == 0.25


def test_a_bare_word_is_a_text(small_file: Path) -> None:
    (part,) = load_study(str(small_file), ["material=von_mises"]).parts
    assert part.fixed["material"] == "von_mises"


def test_of_two_settings_of_one_key_the_last_holds(small_file: Path) -> None:
    study = load_study(str(small_file), ["poissons_ratio=[0.3,0.4]", "poissons_ratio=0.2"])
    assert study.parts[0].fixed["poissons_ratio"] == 0.2
    assert "poissons_ratio" not in study.parts[0].varied


def test_a_message_is_one_bounded_line_and_keeps_its_end() -> None:
    message = str(StudyError("a\nb\x1b" + "x" * 5000 + "; the remedy"))
    assert message.isprintable()
    assert len(message) < LONGEST_MESSAGE + 10
    assert message.startswith(r"a\nb\x1b")
    assert message.endswith("; the remedy")


def test_all_combinations_in_the_order_of_the_study(small_file: Path) -> None:
    study = load_study(str(small_file), ["rigidity_index=[200, 100]"])
    expected = [(0, 200), (0, 100), (0.5, 200), (0.5, 100), (1, 200), (1, 100)]
    assert values(study, "adhesion_factor", "rigidity_index") == expected


def test_a_study_that_varies_nothing_is_one_case(small_file: Path) -> None:
    (case,) = load_study(str(small_file), ["adhesion_factor=0"]).cases
    assert case.label == "cone_penetration"


def test_parameters_are_complete(small: Study) -> None:
    parameters = small.cases[0].parameters
    assert parameters["poissons_ratio"] == 0.49
    assert parameters["material"] == "tresca"


def test_the_key_tells_parameters_scene_and_version_apart(small: Study) -> None:
    case = small.cases[0]
    others = [
        dataclasses.replace(case, scene="other"),
        dataclasses.replace(case, scene_version=case.scene_version + 1),
        dataclasses.replace(case, parameters={**case.parameters, "density": 1700.0000001}),
    ]
    assert len({case.key, *(other.key for other in others)}) == 4


def test_the_key_depends_on_nothing_else(small: Study) -> None:
    case = small.cases[0]
    order = dict(reversed(case.parameters.items()))
    assert dataclasses.replace(case, label="", parameters=order).key == case.key


def test_the_key_is_that_of_earlier_archives() -> None:
    parameters = {"adhesion_factor": 0.5, "shaft_adhesion_factor": None, "material": "tresca"}
    case = Case(scene="cone_penetration", scene_version=1, parameters=parameters, label="")
    assert case.key == "74da9a8e7f348ce3"
