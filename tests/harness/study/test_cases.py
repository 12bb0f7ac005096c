from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from harness.study.cases import Case
from harness.study.study import Study, load_study
from harness.study.tables import StudyError


def test_all_combinations_in_the_order_of_the_study(small_file: Path) -> None:
    cases = load_study(str(small_file), ["rigidity_index=[200, 100]"]).cases
    values = [(c.parameters["adhesion_factor"], c.parameters["rigidity_index"]) for c in cases]
    assert values == [(0, 200), (0, 100), (0.5, 200), (0.5, 100), (1, 200), (1, 100)]


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


def test_a_study_of_too_many_cases_is_refused(small_file: Path) -> None:
    values = [i / 1000 for i in range(1000)]
    settings = [f"adhesion_factor={values}", f"friction_coefficient={values}"]
    with pytest.raises(StudyError, match="gives 1000000 cases"):
        _ = load_study(str(small_file), settings).cases
