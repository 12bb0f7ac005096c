"""The key `snapshots` of a study, and the option of that name."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.study.study import with_snapshots
from harness.study.tables import StudyError
from mpm_warp.scenes.sounding.profile import Profile
from tests.harness.conftest import study_in

CONE = 'title = "A cone"\nscene = "cone_penetration"\n'


@pytest.mark.parametrize(
    ("given", "moments"),
    [("[10, 5]", (5.0, 10.0)), ("{ from = 2, to = 4, count = 3 }", (2.0, 3.0, 4.0))],
)
def test_moments_are_listed_or_a_range(
    given: str, moments: tuple[float, ...], tmp_path: Path
) -> None:
    """In a study or by the option, which takes a list without brackets too."""
    study = study_in(tmp_path, f"{CONE}snapshots = {given}\n")
    for option in (given, *(("5, 10", "5, 10,") if given[0] == "[" else ())):
        assert with_snapshots(study_in(tmp_path, CONE), option).cases[0].snapshots == moments
    assert study.cases[0].snapshots == moments


@pytest.mark.parametrize("given", ["a", "[", "-1", "1, 1"])
def test_an_option_that_is_none_is_refused_in_one_line(given: str, tmp_path: Path) -> None:
    study = study_in(tmp_path, CONE)
    with pytest.raises(StudyError, match="--snapshots"):
        with_snapshots(study, given)


def test_of_several_scenes_the_option_goes_to_those_that_take_snapshots(tmp_path: Path) -> None:
    text = 'title = "Two"\nscene = ["cone_penetration", "gravity_column"]\n'
    cases = with_snapshots(study_in(tmp_path, text), "5").cases
    assert {case.scene: case.snapshots for case in cases} == {
        "cone_penetration": (5.0,),
        "gravity_column": (),
    }


SECRET = "root:x:0:0:"
HEAD = 'title = "t"\nscene = "sounding"\n'
GROUND = "depth [m], strength [kPa]\n# a remark\n0, 40\n2, 10\n2, 20\n8, 60\n"
COLUMNS = '[profile]\n"depth [m]" = [0, 2, 2, 8]\n"strength [kPa]" = [40, 10, 20, 60]\n'


@pytest.mark.parametrize("said", [COLUMNS, '[profile]\nfile = "ground.csv"\n'])
def test_ground_of_columns_and_of_a_file_is_the_same(tmp_path: Path, said: str) -> None:
    (tmp_path / "ground.csv").write_text(GROUND)
    (case,) = study_in(tmp_path, HEAD + said).cases
    profile = Profile.read(str(case.parameters["profile"]))
    np.testing.assert_allclose(profile.depth, [0.0, 2.0, 2.0, 8.0])
    np.testing.assert_allclose(profile.strength, [40e3, 10e3, 20e3, 60e3])


def test_a_study_that_stands_on_another_has_its_ground(tmp_path: Path) -> None:
    study_in(tmp_path, HEAD + COLUMNS, name="site")
    own = study_in(tmp_path, 'base = "site.toml"\n[vary]\nadhesion_factor = [0, 1]\n')
    assert all(it.parameters["profile"] for it in own.cases)


def large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1 << 40)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda it: it.symlink_to("/dev/zero"), "in the folder of the study, or below it"),
        (lambda it: it.symlink_to("../secret"), "in the folder of the study, or below it"),
        (os.mkfifo, "is not a regular file"),
        (large, "a profile has at most 1000000"),
        (lambda it: it.write_text(SECRET), "must name columns with units"),
    ],
    ids=["device", "elsewhere", "fifo", "large", "secret"],
)
def test_nothing_but_a_profile_beside_the_study_is_read(
    make: Callable[[Path], object], message: str, tmp_path: Path
) -> None:
    (tmp_path.parent / "secret").write_text(SECRET)
    make(tmp_path / "odd.csv")
    with pytest.raises(StudyError, match=message) as error:
        study_in(tmp_path, HEAD + '[profile]\nfile = "odd.csv"\n')
    assert SECRET not in str(error.value)
