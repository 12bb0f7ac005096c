"""[profile] of a study: the ground by depth, in the study or in a file beside it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from harness.study.study import load_study
from harness.study.tables import StudyError
from mpm_warp.scenes.sounding.profile import Profile

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
