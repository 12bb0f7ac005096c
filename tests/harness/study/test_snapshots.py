"""The key `snapshots` of a study, and the option of that name."""

import os
from collections.abc import Callable
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from harness.study.study import load_study, with_snapshots
from harness.study.tables import StudyError
from mpm_warp.scenes.sounding.profile import Profile

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


HEAD = 'title = "t"\nscene = "sounding"\n'
GROUND = "depth [m], strength [kPa]\n# a remark\n0, 40\n2, 10\n2, 20\n8, 60\n"
COLUMNS = '[profile]\n"depth [m]" = [0, 2, 2, 8]\n"strength [kPa]" = [40, 10, 20, 60]\n'
Write = Callable[[str], Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a study of soundings beside a file with its ground."""
    (tmp_path / "ground.csv").write_text(GROUND)

    def written(text: str) -> Path:
        path = tmp_path / "site.toml"
        path.write_text(HEAD + text)
        return path

    return written


@pytest.mark.parametrize("said", [COLUMNS, '[profile]\nfile = "ground.csv"\n'])
def test_ground_of_columns_and_of_a_file_is_the_same(write: Write, said: str) -> None:
    (case,) = load_study(str(write(said))).cases
    profile = Profile.read(str(case.parameters["profile"]))
    np.testing.assert_allclose(profile.depth, [0.0, 2.0, 2.0, 8.0])
    np.testing.assert_allclose(profile.strength, [40e3, 10e3, 20e3, 60e3])


def test_a_study_that_stands_on_another_has_its_ground(write: Write, tmp_path: Path) -> None:
    write(COLUMNS)
    own = tmp_path / "own.toml"
    own.write_text('base = "site.toml"\n[vary]\nadhesion_factor = [0, 1]\n')
    assert {len(str(it.parameters["profile"])) > 0 for it in load_study(str(own)).cases} == {True}


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ('[profile]\nfile = "no.csv"', "file = 'no.csv': cannot be read: No such file"),
        ('[profile]\nfile = "ground.csv"\nx = 1', "x = 1: unknown key"),
        ('[profile]\n"depth [m]" = 1', "depth [m] = 1: must be a list of numbers"),
        ('[profile]\n"depth [m]" = [0, 1]\n"strength [kPa]" = [1]', "have different lengths"),
        ('[profile]\n"depth" = [0]\n"strength [kPa]" = [1]', "column depth has no unit"),
        ('[profile]\n"depth [m]" = [0]\n"strength [kPa]" = [-1]', "strength in row 1 is -1000"),
        ("[profile]\n", "[profile]: header"),
        ("profile = 3", "profile = 3: must be a table [profile]"),
        (COLUMNS + '[fixed]\nprofile = "x"', "stands under [profile] as well"),
        (COLUMNS + "[fixed]\nto_depth = 9", "profile: ends at 8 m, must reach to_depth = 9 m"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(write: Write, said: str, message: str) -> None:
    with pytest.raises(StudyError) as refusal:
        _ = load_study(str(write(said))).cases
    assert message in str(refusal.value)
    assert str(refusal.value).isprintable()
    assert "site.toml" in str(refusal.value)


def device(path: Path) -> None:
    path.symlink_to("/dev/zero")


def fifo(path: Path) -> None:
    os.mkfifo(path)


def elsewhere(path: Path) -> None:
    (path.parent.parent / "secret").write_text("root:x:0:0:")
    path.symlink_to("../secret")


def large(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(1 << 40)


def secret(path: Path) -> None:
    path.write_text("root:x:0:0:")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (device, "must be beside the study, or in a folder below"),
        (fifo, "is no ordinary file"),
        (elsewhere, "must be beside the study, or in a folder below"),
        (large, "has more than 1000000 bytes"),
        (secret, "must name columns with units"),
    ],
)
def test_nothing_but_a_profile_beside_the_study_is_read(
    make: Callable[[Path], None], message: str, write: Write, tmp_path: Path
) -> None:
    make(tmp_path / "odd.csv")
    with pytest.raises(StudyError, match=message) as error:
        load_study(str(write('[profile]\nfile = "odd.csv"\n')))
    assert "root:x" not in str(error.value)


def test_a_profile_in_another_folder_is_not_read(write: Write) -> None:
    with pytest.raises(StudyError, match="must be beside the study"):
        load_study(str(write('[profile]\nfile = "/etc/passwd"\n')))
