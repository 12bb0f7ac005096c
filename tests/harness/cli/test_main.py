"""The way to a command: help, completion, how values of options are read, errors of the program."""

import argparse
import importlib
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from harness.cli.commands import studies
from harness.cli.help import HELP
from harness.cli.options import make_parser
from harness.cli.process import DEFECT, DONE
from tests.conftest import finished
from tests.harness.conftest import Command, Refusal

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


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("help run", ["Run the cases of a study", "harness run adhesion_factor"]),
        ("run --help", ["Run the cases of a study", "harness run adhesion_factor"]),
        ("help", [f"\n    {name}" for name in HELP]),
        ("--version", ["harness"]),
        *((f"completion {shell}", ["_ARGCOMPLETE"]) for shell in ("bash", "zsh", "fish")),
    ],
)
def test_help_version_and_completion_are_told(line: str, told: list[str], command: Command) -> None:
    out = command(*line.split()).out
    assert all(text in out for text in told)


def test_help_loads_nothing_that_computes() -> None:
    script = (
        "import sys, harness.cli.main as cli; cli.make_parser().format_help()\n"
        "sys.exit(str({'numpy', 'xarray', 'warp', 'matplotlib', 'scipy'} & sys.modules.keys()))"
    )
    assert finished([sys.executable, "-c", script]).stderr.strip() == "set()"


def broken(options: argparse.Namespace) -> int:
    dict[str, int]()["no such key"]
    return 0


@pytest.mark.parametrize("debug", [[], ["--debug"]])
def test_an_error_of_the_program_is_not_called_the_users(
    debug: list[str], monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    monkeypatch.setattr(studies, "references", broken)
    *trace, line = command("references", *debug, code=DEFECT).err.splitlines()
    assert "an error of the program, not of your input: KeyError: 'no such key'" in line
    assert "please report it to the mpm_warp developers" in line
    assert bool(trace) == bool(debug)
    assert not trace or "in broken" in "".join(trace)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_any_command_as_an_exception_that_removes_what_is_half_done(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    def interrupted(options: argparse.Namespace) -> int:
        with TemporaryDirectory(dir=tmp_path):
            signal.raise_signal(number)
        return DONE

    # It may be ignored here, as under nohup or in the background.
    by_default = signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
    signal.signal(number, by_default)
    monkeypatch.setattr(studies, "references", interrupted)
    assert command("references", code=128 + number).err == "harness: interrupted\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("harness re", {"report", "recommend", "references"}),
        ("harness run adh", {"adhesion_factor"}),
        ("harness run mi", {"mine.toml"}),
        ("harness describe cone_b", {"cone_bearing"}),
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


NUMBERS = {
    "run s --memory-limit": dict.fromkeys(("8GB", "8e9", "8000MB", "8gb", "8000000000B"), 8e9),
    "recommend s --error": {"2%": 0.02, "0.02": 0.02, "0.5%": 0.005, "150%": 1.5},
}


@pytest.mark.parametrize("option", NUMBERS)
def test_a_number_has_its_unit_or_none(option: str) -> None:
    name = option.partition("--")[2].replace("-", "_")
    for text, number in NUMBERS[option].items():
        assert vars(make_parser().parse_args([*option.split(), text]))[name] == number


def test_bytes_that_are_no_text_are_refused(refusal: Refusal) -> None:
    """The result holds the command line; every case would be computed, and none be kept."""
    line = refusal(["run", "mesh_size", "--out", b"bad\xff".decode(errors="surrogateescape")])
    assert line.endswith("is not valid text and could not be stored in a result")
