"""A parser of the command line whose errors are one line, and what it says of itself."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn

from harness.cli.exit_codes import BAD_INPUT
from harness.errors import LONGEST_LINE, printable, shortened

if TYPE_CHECKING:
    Commands = argparse._SubParsersAction["Parser"]
    """The commands of a parser, to which more may be added."""


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, like all others, and that takes no options cut short."""

    def __init__(self, **options: Any) -> None:
        layout = argparse.RawDescriptionHelpFormatter
        super().__init__(allow_abbrev=False, formatter_class=layout, **options)

    def error(self, message: str) -> NoReturn:
        """End the process: a value is not allowed, or a word is missing."""
        line = shortened(printable(message), LONGEST_LINE)
        self.exit(BAD_INPUT, f"{self.prog}: {line}; see {self.prog} --help\n")


class Version(argparse.Action):
    """Prints the version, which is looked up only then."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> NoReturn:
        """Print it, and end the process."""
        from importlib.metadata import PackageNotFoundError, version

        try:
            print(f"harness {version('mpm-warp')}")
        except PackageNotFoundError:
            print("harness, of a source tree that is not installed")
        parser.exit()


def options_of(parser: argparse.ArgumentParser, command: str) -> list[str]:
    """The options of a command, as ``--out``."""
    (commands,) = (it for it in parser._actions if isinstance(it.choices, dict))
    assert isinstance(commands.choices, dict)
    return [
        option
        for action in commands.choices[command]._actions
        for option in action.option_strings
        if option.startswith("--")
    ]
