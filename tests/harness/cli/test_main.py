"""The way to a command, its help, and the version."""

import argparse
import importlib
import shlex
import subprocess
import sys

import pytest

from harness.cli.commands import studies
from harness.cli.help import HELP
from harness.cli.main import main
from harness.cli.options import make_parser
from harness.cli.process import DEFECT

EXAMPLES = [example for told in HELP.values() for example in told.examples]


def test_every_command_has_help_and_an_example() -> None:
    for name, told in HELP.items():
        assert told.description.endswith(".")
        assert told.examples or name == "completion"


@pytest.mark.parametrize("example", EXAMPLES)
def test_examples_are_command_lines_of_commands_that_can_be_loaded(example: str) -> None:
    options = make_parser().parse_args(shlex.split(example))
    assert options.command == example.split(maxsplit=1)[0]
    module, function = options.function.split(".")
    assert callable(getattr(importlib.import_module(f"harness.cli.commands.{module}"), function))


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
    assert all(f"\n    {name}" in out for name in HELP)


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out.startswith("harness")


def test_help_loads_nothing_that_computes() -> None:
    script = (
        "import sys, harness.cli.main as cli; cli.make_parser().format_help()\n"
        "sys.exit(str({'numpy', 'xarray', 'warp', 'matplotlib', 'scipy'} & sys.modules.keys()))"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert result.stderr.strip() == "set()"


def broken(options: argparse.Namespace) -> int:
    dict[str, int]()["no such key"]
    return 0


@pytest.mark.parametrize("debug", [[], ["--debug"]])
def test_an_error_of_the_program_is_not_called_the_users(
    debug: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(studies, "references", broken)
    assert main(["references", *debug]) == DEFECT
    *trace, line = capsys.readouterr().err.splitlines()
    assert "an error of the program, not of your input: KeyError: 'no such key'" in line
    assert "please report it to the mpm_warp developers" in line
    assert bool(trace) == bool(debug)
    assert not trace or "in broken" in "".join(trace)
