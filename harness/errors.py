"""One-line messages for the terminal: errors of the user, errors of the program, and colours.

Text that comes from a file can neither set a colour nor move the cursor.
"""

import os
import secrets
import sys
from typing import TextIO

LONGEST_LINE = 1000
"""Characters that a message may have."""
DEVELOPERS = "the mpm_warp developers"
"""To whom errors of the program are reported."""


class HarnessError(Exception):
    """An error that the user can correct; the message is one line."""


def in_one_line(error: BaseException) -> str:
    """Type and message of an unexpected error in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def defect(error: BaseException) -> str:
    """One line for an error of the program itself, with where to report it."""
    return (
        f"an error of the program, not of your input: {in_one_line(error)}; please report it to "
        f"{DEVELOPERS}, with the command and what --debug prints"
    )


def printable(text: str) -> str:
    """A text with every non-printable character written as its escape sequence.

    So a text from a file cannot move the cursor of the terminal or overwrite other messages.
    """
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)


def shortened(text: str, longest: int = LONGEST_LINE) -> str:
    """A printable text; if it is longer than `longest` characters its middle is left out."""
    text, half = printable(text), longest // 2
    # The end is kept because it names the remedy.
    return text if len(text) <= longest else f"{text[:half]} ... {text[-half:]}"


def counted(count: int, noun: str) -> str:
    """A number of things in words: ``1 file``, ``2 files``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def tell(message: str) -> None:
    """Print one line of limited length on standard error, apart from results."""
    print("harness:", shortened(" ".join(message.split())), file=sys.stderr)


GREEN, RED, PLAIN = (f"\0{secrets.token_hex(8)}\0" for _ in range(3))
"""Random placeholders of colours; no text from a file can contain them."""
CODES = {GREEN: "\033[32m", RED: "\033[31m", PLAIN: "\033[0m"}
"""The terminal code of each placeholder."""


def coloured(text: str, *, is_good: bool, stream: TextIO | None = None) -> str:
    """A text in green or red if it goes to a terminal with colours; otherwise unchanged.

    Any value of the environment variable ``NO_COLOR`` (https://no-color.org) switches colours off.
    Without `stream` the text is for standard output and has placeholders, which
    `harness.cli.process` replaces by codes; with `stream` it has the codes.
    """
    to_terminal = (stream or sys.stdout).isatty()
    if not to_terminal or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return text
    begin, end = GREEN if is_good else RED, PLAIN
    return f"{begin}{text}{end}" if stream is None else f"{CODES[begin]}{text}{CODES[end]}"
