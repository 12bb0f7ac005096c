"""Studies: their cases by design, settings from the command line, and what of a base holds."""

import dataclasses
from pathlib import Path

import pytest

from harness.study.cases import Case
from harness.study.description import unusual_values
from harness.study.files import study_names
from harness.study.study import Study, load_study
from harness.study.tables import LONGEST_MESSAGE, StudyError
from tests.harness.conftest import HEAD, Refusal, study_in, values


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


def test_a_study_that_varies_nothing_is_one_case(small_file: Path) -> None:
    (case,) = load_study(str(small_file), ["adhesion_factor=0"]).cases
    assert case.label == "cone_penetration"


def test_the_key_tells_parameters_scene_and_version_apart_and_nothing_else(small: Study) -> None:
    case = small.cases[0]
    others = [
        dataclasses.replace(case, scene="other"),
        dataclasses.replace(case, scene_version=case.scene_version + 1),
        dataclasses.replace(case, parameters={**case.parameters, "density": 1700.0000001}),
    ]
    assert len({case.key, *(other.key for other in others)}) == 4
    order = dict(reversed(case.parameters.items()))
    assert dataclasses.replace(case, label="", parameters=order).key == case.key


def test_the_key_is_that_of_earlier_archives() -> None:
    parameters = {"adhesion_factor": 0.5, "shaft_adhesion_factor": None, "material": "tresca"}
    case = Case(scene="cone_penetration", scene_version=1, parameters=parameters, label="")
    assert case.key == "74da9a8e7f348ce3"


COMBINED = HEAD + "vary = { adhesion_factor = [0, 0.5, 1] }"
LISTED = f"""{HEAD}
design = "list"
fixed = {{ adhesion_factor = 0.5 }}
[[case]]
rigidity_index = 50
cells_per_radius = 2
[[case]]
rigidity_index = 70
adhesion_factor = 1
"""
FROM_THE_FIXED = f"""{HEAD}
design = "one_at_a_time"
fixed = {{ rigidity_index = 50 }}
vary = {{ adhesion_factor = [0, 1], rigidity_index = [50, 200] }}
"""
IN_TURN = f"""{HEAD}
design = "one_at_a_time"
[fixed]
cells_per_radius = 2
[vary]
adhesion_factor = [0.5, 1]
"""
DERIVED = f"""{HEAD}
derived = {{ domain_radius = "6 * sqrt(rigidity_index)", domain_above = "domain_radius / 3" }}
vary = {{ rigidity_index = [25, 100] }}
"""
NEEDED = f"""{HEAD}
derived = {{ ductility = "20 * remoulded_strength_ratio" }}
vary = {{ remoulded_strength_ratio = [0.2, 0.5] }}
"""
EXCLUDING = f"""{HEAD}
exclude = ["rigidity_index > 100 and adhesion_factor == 1"]
vary = {{ adhesion_factor = [0, 1], rigidity_index = [50, 500] }}
"""
SEVERAL = """title = "t"
scene = ["strip_footing", "material_point"]
fixed = { rigidity_index = 200 }
[scenes]
strip_footing = { vary = { cells_per_radius = [4, 8] } }
material_point = { fixed = { rigidity_index = 100 } }
"""
TWO_SCENES = """title = "t"
scene = ["thick_cylinder", "sliding_block"]
[scenes.thick_cylinder.vary]
cell_count = [10, 20]
[scenes.thick_cylinder.fixed]
radius_ratio = 2
"""
BEGUN_WITH_TWO: dict[str, list[object]] = {
    "adhesion_factor": [0, 0.5, 1, 0, 0],
    "cells_per_radius": [2, 2, 2, 1, 3],
}
# Parameters of the cases, by design and settings.
CASES: dict[str, tuple[str, list[str], dict[str, list[object]]]] = {
    "all combinations in the order of the study": (
        COMBINED,
        ["rigidity_index=[200, 100]"],
        {
            "adhesion_factor": [0, 0, 0.5, 0.5, 1, 1],
            "rigidity_index": [200, 100, 200, 100, 200, 100],
        },
    ),
    "one at a time begins with the fixed values, which are there once": (
        FROM_THE_FIXED,
        [],
        {"adhesion_factor": [0, 1, 0], "rigidity_index": [50, 50, 200]},
    ),
    "one at a time of other values": (
        FROM_THE_FIXED.replace("[0, 1]", "[1]").replace("[50, ", "["),
        [],
        {"adhesion_factor": [0, 1, 0], "rigidity_index": [50, 50, 200]},
    ),
    "a list": (LISTED, [], {"rigidity_index": [50, 70], "adhesion_factor": [0.5, 1]}),
    "a setting holds in every case of a list": (
        LISTED,
        ["cells_per_radius=1", "adhesion_factor=0"],
        {"rigidity_index": [50, 70], "adhesion_factor": [0, 0], "cells_per_radius": [1, 1]},
    ),
    "cases of a list that a setting makes alike are one": (
        LISTED,
        ["rigidity_index=60", "cells_per_radius=1", "adhesion_factor=0"],
        {"rigidity_index": [60], "cells_per_radius": [1]},
    ),
    "a setting that varies leaves what one at a time begins with": (
        IN_TURN,
        ["cells_per_radius=[1, 3]"],
        BEGUN_WITH_TWO,
    ),
    "derived in their order": (DERIVED, [], {"domain_radius": [30, 60], "domain_above": [10, 20]}),
    "derived though others need it": (NEEDED, [], {"ductility": [4, 10]}),
    "exclusions": (EXCLUDING, [], {"adhesion_factor": [0, 0, 1], "rigidity_index": [50, 500, 50]}),
    "several scenes": (SEVERAL, [], {"rigidity_index": [200, 200, 100]}),
    "a setting is for the scenes that have the parameter": (
        TWO_SCENES,
        ["cell_count=5", "grid_angle=[0, 20]"],
        {"cell_count": [5, None, None], "grid_angle": [None, 0, 20]},
    ),
    "varied under a scene, which leaves what all begin with": (
        IN_TURN + "[scenes.cone_penetration.vary]\ncells_per_radius = [1, 3]\n",
        [],
        BEGUN_WITH_TWO,
    ),
}
ON_A_BASE: dict[str, tuple[str, str, dict[str, list[object]]]] = {
    "what is given anew": (
        HEAD + "[fixed]\npenetration = 3\n[vary]\nrigidity_index = [50, 60]\n",
        "[vary]\nadhesion_factor = [0, 1]\n[fixed]\nrigidity_index = 70\n",
        {"penetration": [3, 3], "rigidity_index": [70, 70], "adhesion_factor": [0, 1]},
    ),
    "what varies, which leaves what the base begins with": (
        IN_TURN,
        "[vary]\ncells_per_radius = [1, 3]\n",
        BEGUN_WITH_TWO,
    ),
    "another design": (
        IN_TURN,
        'design = "full"\n[vary]\ncells_per_radius = [1, 3]\n',
        {"adhesion_factor": [0.5, 0.5, 1, 1], "cells_per_radius": [1, 3, 1, 3]},
    ),
    "what stands under a scene, joined key by key": (
        TWO_SCENES,
        '[scenes.thick_cylinder.fixed]\nsection = "plane_strain"\n',
        {
            "radius_ratio": [2, 2, None],
            "section": ["plane_strain", "plane_strain", None],
            "cell_count": [10, 20, None],
        },
    ),
    "what is fixed for all scenes, before what the base says for one": (
        SEVERAL,
        "fixed = { rigidity_index = 300 }\n",
        {"rigidity_index": [300, 300, 300], "cells_per_radius": [4, 8, None]},
    ),
    "what varies in all scenes, before what the base says for one": (
        SEVERAL,
        "vary.rigidity_index = [300]\n",
        {"rigidity_index": [300, 300, 300], "cells_per_radius": [4, 8, None]},
    ),
    "what is said for one scene, before what is for all": (
        SEVERAL,
        "vary.rigidity_index = [300]\n[scenes.strip_footing.fixed]\nrigidity_index = 400\n",
        {"rigidity_index": [400, 400, 300]},
    ),
}
"""A base, what the study says beside it, and the parameters of its cases."""


@pytest.mark.parametrize(("text", "settings", "expected"), CASES.values(), ids=CASES)
def test_the_cases_of_a_study(
    text: str, settings: list[str], expected: dict[str, list[object]], tmp_path: Path
) -> None:
    study = study_in(tmp_path, text, *settings)
    assert values(study, *expected) == list(zip(*expected.values(), strict=True))


@pytest.mark.parametrize(("base", "text", "expected"), ON_A_BASE.values(), ids=ON_A_BASE)
def test_the_cases_of_a_study_on_a_base(
    base: str, text: str, expected: dict[str, list[object]], tmp_path: Path
) -> None:
    study_in(tmp_path, base, name="base")
    study = study_in(tmp_path, f'base = "base.toml"\n{text}')
    assert values(study, *expected) == list(zip(*expected.values(), strict=True))


def test_cases_are_called_by_what_varies_and_are_of_their_scenes(tmp_path: Path) -> None:
    listed = study_in(tmp_path, LISTED, "cells_per_radius=1", "adhesion_factor=0").cases
    assert [case.label for case in listed] == ["rigidity_index=50.0", "rigidity_index=70.0"]
    scenes = [case.scene for case in study_in(tmp_path, SEVERAL).cases]
    assert scenes == ["strip_footing", "strip_footing", "material_point"]
    assert study_in(tmp_path, 'base = "adhesion_factor"\ntitle = "mine"').title == "mine"


def test_ranges(tmp_path: Path) -> None:
    text = """[vary]
    adhesion_factor = { from = 0, to = 1, count = 5 }
    rigidity_index = { from = 500, to = 5, count = 3, spacing = "logarithmic" }
    """
    varied = study_in(tmp_path, HEAD + text).parts[0].varied
    assert varied["adhesion_factor"] == (0, 0.25, 0.5, 0.75, 1)
    assert varied["rigidity_index"] == (500, 50, 5)


def test_exclusions_snapshots_and_listed_cases_go_before_those_of_a_base(tmp_path: Path) -> None:
    own = "[scenes.cone_penetration]\nexclude = ['adhesion_factor == 0']\nsnapshots = [1]\n"
    varied = "[vary]\nadhesion_factor = [0, 1]\n"
    study_in(tmp_path, HEAD + varied + own, name="base")
    text = 'base = "base.toml"\nexclude = ["adhesion_factor == 1"]\nsnapshots = [2]\n'
    (case,) = study_in(tmp_path, text).cases
    assert (case.parameters["adhesion_factor"], case.snapshots) == (0, (2,))
    listed = f'{HEAD}design = "list"\n[[scenes.cone_penetration.case]]\nadhesion_factor = 0\n'
    study_in(tmp_path, listed, name="base")
    text = 'base = "base.toml"\ncase = [{ adhesion_factor = 1 }]\n'
    assert values(study_in(tmp_path, text), "adhesion_factor") == [(1,)]


NOT_VARIED = r'^--set rigidity_index = .* design = "list" .* a number'


@pytest.mark.parametrize(
    ("text", "setting", "told"),
    [
        (LISTED, "rigidity_index=[50, 60]", NOT_VARIED),
        (LISTED, "rigidity_index={from = 50, to = 60, count = 2}", NOT_VARIED),
        (
            LISTED.replace("fixed =", "vary = { density = [1] }\nfixed ="),
            "density=1",
            r"s.toml: \[vary\] density = \[1\]: is not allowed with",
        ),
        (TWO_SCENES, "cell_count=0", r"^--set, for thick_cylinder: cell_count = 0 is not allowed"),
        (TWO_SCENES, "travel=-1", r"^--set, for sliding_block: travel = -1 is not allowed"),
        (TWO_SCENES, "cell_cuont=5", r"^--set cell_cuont = 5: .* did you mean 'cell_count'"),
    ],
)
def test_a_setting_beside_the_study_is_told(
    text: str, setting: str, told: str, tmp_path: Path
) -> None:
    with pytest.raises(StudyError, match=told):
        study_in(tmp_path, text, setting)


def test_a_name_that_is_a_file_here_is_told_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, refusal: Refusal
) -> None:
    study_in(tmp_path, IN_TURN, name="mine")
    with pytest.raises(StudyError, match=r"base = 'mine': .*; a file here is called mine\.toml$"):
        study_in(tmp_path, 'base = "mine"\n')
    assert "called" not in refusal(["status", "mine"])
    monkeypatch.chdir(tmp_path)
    assert refusal(["status", "mine"]).endswith("; a file here is called mine.toml")
