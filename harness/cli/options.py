"""The parser of the command line: values, defaults, and one-line answers to mistakes.

Functions that read a value raise `argparse.ArgumentTypeError` with a one-line message.
"""

import argparse
import math
import re
import sys
import textwrap
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, NoReturn

from harness.cli.help import HELP, Option, epilog
from harness.cli.process import BAD_INPUT
from harness.errors import say, shortened
from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.fields.names import did_you_mean
from mpm_warp.fields.plain_numbers import plain_number

BYTES = {"KB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12, "B": 1.0}
"""Units of memory that may follow a number, in bytes."""


def number(
    meaning: str, units: Mapping[str, float] | None = None, *, least: float = sys.float_info.min
) -> Callable[[str], float]:
    """A function that reads a finite number of at least `least`, by default any number > 0.

    Args:
        meaning: what is allowed, for the error message.
        units: units that may follow the number, with their sizes.
        least: smallest allowed number.
    """
    sizes = units or {}

    def read(text: str) -> float:
        unit = next((unit for unit in sizes if text.upper().endswith(unit)), "")
        value = plain_number(text.upper().removesuffix(unit))
        value = math.nan if value is None else value * sizes.get(unit, 1.0)
        if not least <= value < math.inf:
            raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must be {meaning}")
        return value

    return read


def html_file(text: str) -> Path:
    """A path that ends in .html."""
    # If -o were followed by a result by mistake, the page would overwrite it.
    if not text.endswith(".html"):
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must end in .html")
    return Path(text)


def share(text: str) -> float:
    """A share > 0: 1% or 0.01."""
    value = number("> 0, as 1% or 0.01", {"%": 0.01})(text)
    if value >= 1.0 and not text.endswith("%"):
        meant = f"{text}% meant? 100% and more is written with its sign, as {100.0 * value:g}%"
        raise argparse.ArgumentTypeError(f"{text!r} is {value:.0%}: is {meant}")
    return value


def positive_count(text: str) -> int:
    """An integer from 1 to 999999."""
    if not re.fullmatch("[0-9]{1,6}", text) or int(text) < 1:
        shown = text if len(text) < 20 else f"{text[:20]}..."
        raise argparse.ArgumentTypeError(
            f"{shown!r} is not allowed: must be an integer from 1 to 999999"
        )
    return int(text)


RESULTS = Path("results")
PATHS = ("DIR", "FILE", "OTHER", "TEST", "CSV", "SITE")
"""Placeholders in the help for values that are paths."""
FORMS = ["png", "pdf", "svg"]
"""Formats of pictures, the default first."""
VALUES: dict[str, dict[str, Any]] = {
    "--out": {"default": RESULTS},
    "--set": {"action": "append", "default": []},
    "--threads": {"type": int, "choices": THREAD_COUNTS},
    "--device": {"default": "cpu"},
    "new --scene": {"default": "cone_penetration"},
    "run --workers": {"type": positive_count},
    "run --case-timeout": {"type": number("a number > 0"), "default": math.inf},
    "run --memory-limit": {"type": number("100MB at least, as 8e9 or 8GB", BYTES, least=100e6)},
    "schema of": {"choices": ("study", "site"), "default": "study"},
    "verify --scene": {"action": "extend", "default": []},
    "interpret --check": {"nargs": "?", "const": "quick", "choices": ("quick", "standard")},
    "benchmark action": {"choices": ("run", "score")},
    "benchmark --accuracy": {"choices": ("quick", "standard", "fine")},
    "compare --tolerance": {"type": number("a number >= 0", least=0.0)},
    "compare --format": {"choices": ("text", "markdown", "latex", "csv"), "default": "text"},
    "--format": {"choices": FORMS, "default": FORMS[:1]},
    "report --out": {"type": html_file, "default": Path("report.html")},
    "recommend --error": {"type": share, "required": True},
    "recommend --results": {"default": RESULTS},
    "help about": {"choices": tuple(HELP)},
    "completion shell": {"choices": ("bash", "zsh", "fish")},
}
"""Arguments for argparse of options that are not simply texts or paths, by key of the option."""
EXCLUSIVE = (
    *("run --workers", "run --dask", "new --interpret", "new --scene"),
    *("references id", "references --field"),
)
"""Options of a command that exclude one another."""


class Parser(argparse.ArgumentParser):
    """A parser with one-line errors that accepts no abbreviated options."""

    def __init__(self, **options: Any) -> None:
        layout = argparse.RawDescriptionHelpFormatter
        super().__init__(allow_abbrev=False, formatter_class=layout, **options)

    def print_help(self, file: object = None) -> None:
        """Print the help as results are; argparse would not notice that it cannot be written."""
        say(self.format_help().rstrip())

    def error(self, message: str) -> NoReturn:
        """End the process because a value is not allowed or an argument is missing."""
        self.exit(BAD_INPUT, f"{self.prog}: {shortened(message)}; see {self.prog} --help\n")


def make_parser() -> Parser:
    """The parser of the command line.

    What it parses has two special attributes. `command` is the name of the command. `function`
    names a module of `harness.cli.commands` and a function in it, "run.run" say; the function takes
    the options and returns the exit code.
    """
    parser = Parser(
        prog="harness",
        description="Parametric studies of cone penetration by the material point method.",
        epilog="first steps:\n"
        "  harness run adhesion_factor    the main job, in a minute\n"
        "  harness new my_study           a study of your own, to be edited and run\n"
        "  harness tour                   a notebook: all of it from Python\n"
        "  harness help COMMAND           options and examples of a command",
    )
    parser.add_argument("--version", action="version", version=_version())
    commands = parser.add_subparsers(required=True, metavar="COMMAND", dest="command")
    for name, entry in HELP.items():
        command = commands.add_parser(
            name,
            help=entry.summary,
            description=textwrap.fill(entry.description, 80),
            epilog=epilog(name),
        )
        command.set_defaults(function=entry.function)
        has_exclusive = any(option.key in EXCLUSIVE for option in entry.options)
        exclusive = command.add_mutually_exclusive_group() if has_exclusive else command
        for option in entry.options:
            place = exclusive if option.key in EXCLUSIVE else command
            place.add_argument(*option.names, **_as_argument(option))
        debug = "if the program itself fails, print where"
        command.add_argument("--debug", action="store_true", help=debug)
    return parser


def _as_argument(option: Option) -> dict[str, Any]:
    if not option.value and option.key not in VALUES:
        return {"action": "store_true", "help": option.meaning}
    argument: dict[str, Any] = {"help": option.meaning.replace("%", "%%") or None}
    name = option.value.removesuffix("...").strip("[]")
    if name:
        argument["metavar"] = name
    if option.value != name:
        argument["nargs"] = "+" if option.value.endswith("...") else "?"
    if name in PATHS:
        argument["type"] = Path
    return argument | VALUES.get(option.key, {})


def _version() -> str:
    try:
        return f"harness {metadata.version('mpm-warp')}"
    except metadata.PackageNotFoundError:
        return "harness, from a source tree that is not installed"


SHOWN_LENGTH = 40
"""Characters of a word that a message shows."""


def mistake_in(arguments: Sequence[str]) -> str | None:
    """A common mistake in a command line, found before it is parsed; None if there is none."""
    for argument in arguments:
        if any("\ud800" <= character <= "\udfff" for character in argument):
            return f"{argument!r}: is not valid text and could not be stored in a result"
    return _unknown_command(arguments) or _missing_quotes(arguments)


def options_of(command: str) -> list[str]:
    """The long options of a command, such as ``--out``."""
    names = [name for option in HELP[command].options for name in option.names]
    return [*(name for name in names if name.startswith("--")), "--debug", "--help"]


def unrecognised(words: Sequence[str], command: str) -> str:
    """The error for words that the parser does not know, with what was probably meant."""
    first, *_ = words
    problem = f"unrecognized arguments: {' '.join(words)}"
    if first.startswith("-"):
        return problem + did_you_mean(first.partition("=")[0], options_of(command))
    if "=" in first and "--set" in options_of(command):
        return f"{problem}; change a parameter by --set {first}"
    return f"{problem}; put quotes around a value with blanks"


def _unknown_command(arguments: Sequence[str]) -> str | None:
    if not arguments or arguments[0].startswith("-") or arguments[0] in HELP:
        return None
    from harness.study.files import study_names  # imported here so that help appears at once

    word = arguments[0]
    shown = word if len(word) <= SHOWN_LENGTH else f"{word[:SHOWN_LENGTH]}..."
    if word.endswith(".toml") or word in study_names():
        return f"{shown}: is a study, not a command; `harness run {shown}` runs it"
    if word.endswith(".nc"):
        return f"{shown}: is a result, not a command; `harness compare {shown}` shows it"
    near = did_you_mean(word, HELP)
    return f"{shown}: is not a command{near or '; `harness --help` lists them'}"


def _missing_quotes(arguments: Sequence[str]) -> str | None:
    """The error for a --set value that the shell has split at a blank; None if there is none."""
    for place, argument in enumerate(arguments):
        if argument == "--set" and place + 1 < len(arguments):
            start, pieces = "--set ", arguments[place + 1 :]
        elif argument.startswith("--set="):
            start, pieces = "", arguments[place:]
        else:
            continue
        if _open_brackets(pieces[0]) <= 0:
            continue
        for count in range(2, len(pieces) + 1):
            whole = " ".join(pieces[:count])
            if _open_brackets(whole) == 0:
                key, _, value = whole.removeprefix("--set=").partition("=")
                return (
                    f"{start}{pieces[0]}: the shell has split the value at a blank; "
                    f"put quotes around it: --set '{key}={value}'"
                )
        return f"{start}{pieces[0]}: a bracket is not closed"
    return None


def _open_brackets(text: str) -> int:
    """Number of opening less closing brackets, without those in quoted texts."""
    bare = re.sub(r'"[^"]*"', "", text)
    return len(re.findall(r"[\[{]", bare)) - len(re.findall(r"[\]}]", bare))
