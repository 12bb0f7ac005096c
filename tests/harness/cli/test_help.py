"""Help: a sentence and examples of each command, the version, completion by the Tab key."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from harness.cli.arguments import make_parser
from harness.cli.command_help import HELP
from harness.cli.completion import scene_names_at_once
from harness.cli.main import COMMANDS, main
from mpm_warp.scenes import scene_names

EXAMPLES = [example for _, examples in HELP.values() for example in examples]


def test_every_command_has_help_and_an_example() -> None:
    assert HELP.keys() == COMMANDS.keys()
    for name, (sentence, examples) in HELP.items():
        assert sentence.endswith(".")
        assert examples or name == "completion"


@pytest.mark.parametrize("example", EXAMPLES)
def test_examples_are_command_lines(example: str) -> None:
    options = make_parser().parse_args(shlex.split(example))
    assert options.command == example.split(maxsplit=1)[0]


@pytest.mark.parametrize("arguments", [["help", "run"], ["run", "--help"]])
def test_help_of_a_command_says_what_it_does(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(arguments)
    out = capsys.readouterr().out
    assert "Run the cases of a study" in out
    assert "harness run adhesion_factor" in out


def test_help_of_everything_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["help"])
    out = capsys.readouterr().out
    assert all(f"\n    {name}" in out for name in COMMANDS)


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out.startswith("harness")


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
