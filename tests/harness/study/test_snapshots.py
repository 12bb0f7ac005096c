"""The key `snapshots` of a study, and the option of that name."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

from harness.study.study import load_study, with_snapshots
from harness.study.tables import StudyError

CONE = """
    title = "A cone"
    scene = "cone_penetration"
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "cone.toml"
    path.write_text(dedent(CONE))
    return path


@pytest.mark.parametrize(
    ("given", "moments"),
    [
        ("[10, 5]", (5.0, 10.0)),
        ("{ from = 2, to = 4, count = 3 }", (2.0, 3.0, 4.0)),
    ],
)
def test_moments_are_a_list_or_a_range(given: str, moments: tuple[float, ...], file: Path) -> None:
    file.write_text(f"{file.read_text()}snapshots = {given}\n")
    assert load_study(str(file)).cases[0].snapshots == moments


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ("5", "must be a list of one value or more, or a range"),
        ("[]", "must be a list of one value or more, or a range"),
        ("[0]", "must be a number > 0 and <= "),
        ("[3000]", "must be a number"),
        ("['a']", "must be a number"),
        ("[5, 5]", "is there twice"),
        ("{ from = 1, to = 4 }", "count: is missing"),
    ],
)
def test_moments_that_are_none_are_refused_in_one_line(
    given: str, problem: str, file: Path
) -> None:
    file.write_text(f"{file.read_text()}snapshots = {given}\n")
    with pytest.raises(StudyError, match="snapshots") as refused:
        load_study(str(file))
    assert problem in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_scene_that_takes_none_refuses_them(file: Path) -> None:
    file.write_text('title = "Column"\nscene = "gravity_column"\nsnapshots = [1]\n')
    with pytest.raises(StudyError, match="gravity_column takes no snapshots"):
        load_study(str(file))


@pytest.mark.parametrize("given", ["5, 10", "5, 10,", "[10, 5]", "{from = 5, to = 10, count = 2}"])
def test_the_option_takes_a_list_or_a_range(given: str, file: Path) -> None:
    assert with_snapshots(load_study(str(file)), given).cases[0].snapshots == (5.0, 10.0)


@pytest.mark.parametrize("given", ["a", "[", "-1", "1, 1"])
def test_an_option_that_is_none_is_refused_in_one_line(given: str, file: Path) -> None:
    study = load_study(str(file))
    with pytest.raises(StudyError, match="--snapshots"):
        with_snapshots(study, given)


def test_of_several_scenes_the_option_goes_to_those_that_take_snapshots(file: Path) -> None:
    file.write_text('title = "Two"\nscene = ["cone_penetration", "gravity_column"]\n')
    cases = with_snapshots(load_study(str(file)), "5").cases
    assert {case.scene: case.snapshots for case in cases} == {
        "cone_penetration": (5.0,),
        "gravity_column": (),
    }
