"""Help: a sentence and examples of each command, and the version."""

import shlex

import pytest

from harness.cli.help import HELP
from harness.cli.main import main
from harness.cli.options import make_parser

EXAMPLES = [example for told in HELP.values() for example in told.examples]


def test_every_command_has_help_and_an_example() -> None:
    for name, told in HELP.items():
        assert told.description.endswith(".")
        assert told.examples or name == "completion"


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
    assert all(f"\n    {name}" in out for name in HELP)


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out.startswith("harness")
