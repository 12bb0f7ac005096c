"""Completion by the Tab key: what each shell is given, and what is offered where."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from harness.cli.commands.completion import scene_names_at_once
from harness.cli.main import main
from mpm_warp.scenes import scene_names

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_is_given_its_code(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    assert "_ARGCOMPLETE" in capsys.readouterr().out


def test_names_of_scenes_are_found_without_importing_them() -> None:
    assert scene_names_at_once() == sorted(scene_names())


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("harness re", {"rerun", "report", "recommend", "references"}),
        ("harness run adh", {"adhesion_factor"}),
        ("harness run mi", {"mine.toml"}),
        ("harness describe cone_b", {"cone_bearing"}),
        ("harness new mine --scene strip", {"strip_footing"}),
        ("harness run mesh_size --fr", {"--fresh"}),
        ("harness compare so", {"some.nc"}),
    ],
)
def test_the_tab_key_offers_what_fits(line: str, offered: set[str], tmp_path: Path) -> None:
    for name in ("mine.toml", "some.nc", "other.txt"):
        (tmp_path / name).touch()
    asked = tmp_path / "offered"
    environment = os.environ | {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_STDOUT_FILENAME": str(asked),
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
    }
    subprocess.run([sys.executable, "-m", "harness"], cwd=tmp_path, env=environment, check=True)
    assert {word.strip() for word in asked.read_text().split("\n")} == offered
