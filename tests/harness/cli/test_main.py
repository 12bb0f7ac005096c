"""The way to a command: each can be loaded, alone; and results that are none."""

import argparse
import importlib
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from harness.cli.commands import studies
from harness.cli.help import HELP
from harness.cli.main import main
from harness.cli.options import make_parser
from harness.cli.process import DEFECT
from tests.harness.conftest import Refusal


@pytest.mark.parametrize("command", ["compare", "plot"])
def test_a_result_that_is_none_is_one_line(
    command: str, small_file: Path, refusal: Refusal
) -> None:
    assert "cannot be read" in refusal([command, str(small_file)])
    assert "no such file" in refusal([command, str(small_file.with_suffix(".nc"))])


def test_help_loads_nothing_that_computes() -> None:
    script = (
        "import sys, harness.cli.main as cli; cli.make_parser().format_help()\n"
        "sys.exit(str({'numpy', 'xarray', 'warp', 'matplotlib', 'scipy'} & sys.modules.keys()))"
    )
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert result.stderr.strip() == "set()"


EXAMPLES = [told.examples[0] for told in HELP.values() if told.examples]


def test_every_command_that_has_help_can_be_loaded() -> None:
    for example in EXAMPLES:
        module, function = make_parser().parse_args(shlex.split(example)).function.split(".")
        assert callable(
            getattr(importlib.import_module(f"harness.cli.commands.{module}"), function)
        )


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
