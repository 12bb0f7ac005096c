"""What a terminal is told: errors of the user's and of the program, each in a line; colour.

Nothing that is read from a file can give itself a colour, or move the cursor.
"""

import os
import secrets
import sys
from typing import TextIO

LONGEST_LINE = 1000
"""Characters of a line that is reported."""
DEVELOPERS = "the mpm_warp developers"
"""Who takes reports: the authors of the package."""


class HarnessError(Exception):
    """What the user can put right; the message is one line."""


def in_one_line(error: BaseException) -> str:
    """Type and message of an error that nobody has foreseen, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def defect(error: BaseException) -> str:
    """An error of the program itself in one line, and where to report it."""
    return (
        f"an error of the program, not of your input: {in_one_line(error)}; please report it to "
        f"{DEVELOPERS}, with the command and what --debug prints"
    )


def printable(text: str) -> str:
    """A text in which each character that cannot be printed is written as its escape.

    A text out of a file must not move the cursor of a terminal, or say what is not so.
    """
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)


def shortened(text: str, longest: int = LONGEST_LINE) -> str:
    """A printable text of at most about `longest` characters, without its middle if it has more."""
    text, half = printable(text), longest // 2
    # The end of a message names the remedy.
    return text if len(text) <= longest else f"{text[:half]} ... {text[-half:]}"


def counted(count: int, noun: str) -> str:
    """A number of things in words: ``1 file``, ``2 files``."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def tell(message: str) -> None:
    """Print one line of bounded length on standard error, where it does not mix with results."""
    print("harness:", shortened(" ".join(message.split())), file=sys.stderr)


GREEN, RED, PLAIN = (f"\0{secrets.token_hex(8)}\0" for _ in range(3))
"""What stands for a colour until it is printed: no file can know it."""
CODES = {GREEN: "\033[32m", RED: "\033[31m", PLAIN: "\033[0m"}
"""What a terminal takes for it."""


def coloured(text: str, *, is_good: bool, stream: TextIO | None = None) -> str:
    """A text in green or red where it goes to a terminal that has colours; otherwise as it is.

    The environment variable ``NO_COLOR`` (https://no-color.org), set to anything, keeps it plain.
    By default it goes to standard output, where `harness.cli.process` puts the codes of the colours
    in.
    """
    to_terminal = (stream or sys.stdout).isatty()
    if not to_terminal or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return text
    begin, end = GREEN if is_good else RED, PLAIN
    return f"{begin}{text}{end}" if stream is None else f"{CODES[begin]}{text}{CODES[end]}"
