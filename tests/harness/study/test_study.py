"""Studies: their cases, settings from the command line, and what of a base holds."""

import dataclasses
from pathlib import Path

import pytest

from harness.study.cases import Case
from harness.study.description import unusual_values
from harness.study.files import study_names
from harness.study.study import Study, load_study
from harness.study.tables import LONGEST_MESSAGE, StudyError
from tests.harness.conftest import Refusal, study_in, values


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


@pytest.mark.parametrize(
    ("settings", "name", "varied", "fixed"),
    [
        (["cells_per_radius=[1, 2]"], "cells_per_radius", (1, 2), None),
        (["adhesion_factor = 0.25"], "adhesion_factor", None, 0.25),
        (["material=von_mises"], "material", None, "von_mises"),  # a bare word is a text
        (["poissons_ratio=[0.3,0.4]", "poissons_ratio=0.2"], "poissons_ratio", None, 0.2),
    ],
)
def test_a_list_varies_and_a_value_fixes_and_the_last_holds(
    settings: list[str], name: str, varied: object, fixed: object, small_file: Path
) -> None:
    (part,) = load_study(str(small_file), settings).parts
    assert (part.varied.get(name), part.fixed.get(name)) == (varied, fixed)


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


LISTED = """title = "t"
scene = "cone_penetration"
design = "list"
[fixed]
adhesion_factor = 0.5
[[case]]
rigidity_index = 50
cells_per_radius = 2
[[case]]
rigidity_index = 70
adhesion_factor = 1
"""
IN_TURN = """title = "t"
scene = "cone_penetration"
design = "one_at_a_time"
[fixed]
cells_per_radius = 2
[vary]
adhesion_factor = [0.5, 1]
"""
TWO_SCENES = """title = "t"
scene = ["thick_cylinder", "sliding_block"]
[scenes.thick_cylinder.vary]
cell_count = [10, 20]
[scenes.thick_cylinder.fixed]
radius_ratio = 2
"""


def test_a_setting_holds_in_every_case_of_a_list(tmp_path: Path) -> None:
    names = "rigidity_index", "adhesion_factor", "cells_per_radius"
    study = study_in(tmp_path, LISTED, "cells_per_radius=1", "adhesion_factor=0")
    assert values(study, *names) == [(50, 0, 1), (70, 0, 1)]
    assert [case.label for case in study.cases] == ["rigidity_index=50.0", "rigidity_index=70.0"]


def test_cases_of_a_list_that_a_setting_makes_alike_are_one(tmp_path: Path) -> None:
    settings = "rigidity_index=60", "cells_per_radius=1", "adhesion_factor=0"
    study = study_in(tmp_path, LISTED, *settings)
    assert values(study, "rigidity_index", "cells_per_radius") == [(60, 1)]


@pytest.mark.parametrize("value", ["[50, 60]", "{from = 50, to = 60, count = 2}"])
def test_a_setting_that_varies_does_not_go_with_a_list(tmp_path: Path, value: str) -> None:
    with pytest.raises(StudyError, match=r'^--set rigidity_index = .* design = "list" .* a number'):
        study_in(tmp_path, LISTED, f"rigidity_index={value}")


def test_what_is_varied_beside_a_list_is_told_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match=r"s.toml: \[vary\] density = \[1\]: does not go with"):
        study_in(tmp_path, LISTED.replace("[fixed]", "[vary]\ndensity = [1]\n[fixed]"), "density=1")


def test_a_setting_that_varies_leaves_what_one_at_a_time_begins_with(tmp_path: Path) -> None:
    study = study_in(tmp_path, IN_TURN, "cells_per_radius=[1, 3]")
    expected = [(0, 2), (0.5, 2), (1, 2), (0, 1), (0, 3)]
    assert values(study, "adhesion_factor", "cells_per_radius") == expected


def test_a_study_that_varies_leaves_what_its_base_begins_with(tmp_path: Path) -> None:
    study_in(tmp_path, IN_TURN, name="base")
    text = 'base = "base.toml"\n[vary]\ncells_per_radius = [1, 3]\n'
    study = study_in(tmp_path, text)
    expected = [(0, 2), (0.5, 2), (1, 2), (0, 1), (0, 3)]
    assert values(study, "adhesion_factor", "cells_per_radius") == expected
    (part,) = study_in(tmp_path, 'design = "full"\n' + text).parts
    assert part.fixed == {}


def test_a_scene_that_varies_leaves_what_all_begin_with(tmp_path: Path) -> None:
    own = "[scenes.cone_penetration.vary]\ncells_per_radius = [1, 3]\n"
    (part,) = study_in(tmp_path, IN_TURN + own).parts
    assert part.fixed == {"cells_per_radius": 2}


def test_what_stands_under_a_scene_is_joined_key_by_key(tmp_path: Path) -> None:
    study_in(tmp_path, TWO_SCENES, name="base")
    part, _ = study_in(
        tmp_path, 'base = "base.toml"\n[scenes.thick_cylinder.fixed]\nsection = "plane_strain"\n'
    ).parts
    assert part.fixed == {"radius_ratio": 2, "section": "plane_strain"}
    assert part.varied == {"cell_count": (10, 20)}


def test_a_setting_is_for_the_scenes_that_have_the_parameter(tmp_path: Path) -> None:
    study = study_in(tmp_path, TWO_SCENES, "cell_count=5", "grid_angle=[0, 20]")
    assert [case.scene for case in study.cases] == [
        "thick_cylinder",
        "sliding_block",
        "sliding_block",
    ]
    assert values(study, "cell_count", "grid_angle") == [(5, None), (None, 0), (None, 20)]


def test_a_setting_of_no_scene_is_answered_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match=r"^--set cell_cuont = 5: .* did you mean 'cell_count'"):
        study_in(tmp_path, TWO_SCENES, "cell_cuont=5")


def test_a_name_that_is_a_file_here_is_told_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refusal: Refusal
) -> None:
    study_in(tmp_path, IN_TURN, name="mine")
    with pytest.raises(StudyError, match=r"base = 'mine': .*; a file here is called mine\.toml$"):
        study_in(tmp_path, 'base = "mine"\n')
    assert "called" not in refusal(["status", "mine"])
    monkeypatch.chdir(tmp_path)
    assert refusal(["status", "mine"]).endswith("; a file here is called mine.toml")
