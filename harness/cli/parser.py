"""How a command line is read: values, and mistakes that are answered by one line with a remedy.

A reader of a value raises `argparse.ArgumentTypeError`, which says what is not allowed in one line.
"""

import argparse
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from harness.cli.process import BAD_INPUT
from harness.errors import LONGEST_LINE, printable, shortened


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, like all others, and that takes no options cut short."""

    def __init__(self, **options: Any) -> None:
        layout = argparse.RawDescriptionHelpFormatter
        super().__init__(allow_abbrev=False, formatter_class=layout, **options)

    def error(self, message: str) -> NoReturn:
        """End the process: a value is not allowed, or a word is missing."""
        line = shortened(printable(message), LONGEST_LINE)
        self.exit(BAD_INPUT, f"{self.prog}: {line}; see {self.prog} --help\n")


def options_of(parser: argparse.ArgumentParser, command: str) -> list[str]:
    """The options of a command, as ``--out``."""
    (commands,) = (action for action in parser._actions if isinstance(action.choices, dict))
    assert isinstance(commands.choices, dict)
    return [
        option
        for action in commands.choices[command]._actions
        for option in action.option_strings
        if option.startswith("--")
    ]


BYTES = {"KB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12, "B": 1.0}
NO_UNIT: Mapping[str, float] = {}
"""Units that may stand behind a number, and what one of them is."""


def number(
    meaning: str, units: Mapping[str, float] = NO_UNIT, *, or_zero: bool = False
) -> Callable[[str], float]:
    """What reads a finite number > 0, described in words; a unit may stand behind it."""

    def read(text: str) -> float:
        unit = next((known_unit for known_unit in units if text.upper().endswith(known_unit)), "")
        try:
            value = float(text.upper().removesuffix(unit)) * units.get(unit, 1.0)
        except ValueError:
            value = math.nan
        if not (0.0 < value < math.inf or (or_zero and value == 0.0)):
            raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must be {meaning}")
        return value

    return read


def html_file(text: str) -> Path:
    """A path that ends in .html."""
    # A result in its place, the page's name forgotten, would be lost.
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
    if not text.isdecimal() or len(text) > 6 or int(text) < 1:
        shown = text if len(text) < 20 else f"{text[:20]}..."
        raise argparse.ArgumentTypeError(
            f"{shown!r} is not allowed: must be an integer from 1 to 999999"
        )
    return int(text)


SHOWN_LENGTH = 40
"""Characters of a word that are shown, at most."""


def mistake_in(arguments: Sequence[str], commands: Collection[str]) -> str | None:
    """What is wrong with a command line before it is parsed; None where nothing is seen."""
    for argument in arguments:
        if any("\ud800" <= character <= "\udfff" for character in argument):
            return f"{argument!r}: is not text, which results could not keep"
    return _unknown_command(arguments, commands) or _missing_quotes(arguments)


def unrecognised(words: Sequence[str], options: Collection[str]) -> str:
    """What a parser could make nothing of, and what was meant by it."""
    from mpm_warp.parameters import did_you_mean  # help is at once, without it

    first, *_ = words
    problem = f"unrecognized arguments: {' '.join(words)}"
    if first.startswith("-"):
        return problem + did_you_mean(first.partition("=")[0], options)
    if "=" in first and "--set" in options:
        return f"{problem}; a parameter is changed by --set {first}"
    return f"{problem}; what has blanks in it needs quotes"


def _unknown_command(arguments: Sequence[str], commands: Collection[str]) -> str | None:
    if not arguments or arguments[0].startswith("-") or arguments[0] in commands:
        return None
    from harness.study.files import study_names
    from mpm_warp.parameters import did_you_mean  # help is at once, without it

    word = arguments[0]
    shown = word if len(word) <= SHOWN_LENGTH else f"{word[:SHOWN_LENGTH]}..."
    if word.endswith(".toml") or word in study_names():
        return f"{shown}: is no command, but a study: run it by `harness run {shown}`"
    if word.endswith(".nc"):
        return f"{shown}: is no command, but a result: show it by `harness compare {shown}`"
    near = did_you_mean(word, commands)
    return f"{shown}: is no command{near or '; `harness --help` lists them'}"


def _missing_quotes(arguments: Sequence[str]) -> str | None:
    """Where a shell has cut the value of a setting in pieces, or has eaten its quotes."""
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
                    f"{start}{pieces[0]}: the shell has cut the value at a blank; "
                    f"put quotes around it: --set '{key}={value}'"
                )
        return f"{start}{pieces[0]}: a bracket is opened and not closed"
    return None


def _open_brackets(text: str) -> int:
    """Brackets that are opened and not closed, those in texts left aside."""
    bare = re.sub(r'"[^"]*"', "", text)
    return sum(bare.count(bracket) for bracket in "[{") - sum(
        bare.count(bracket) for bracket in "]}"
    )
