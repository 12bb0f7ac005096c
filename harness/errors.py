"""Errors that the user can put right, and how they are reported."""

from __future__ import annotations

import sys

LONGEST_LINE = 1000
"""Characters of a line that is reported."""


class HarnessError(Exception):
    """What the user can put right; the message is one line."""


def in_one_line(error: BaseException) -> str:
    """Type and message of an error that nobody has foreseen, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def printable(text: str) -> str:
    """A text in which each character that cannot be printed is written as its escape.

    A text out of a file must not move the cursor of a terminal, or say what is not so.
    """
    return text if text.isprintable() else "".join(map(_shown, text))


def _shown(character: str) -> str:
    return character if character.isprintable() else ascii(character)[1:-1]


def shortened(text: str, longest: int) -> str:
    """A text of at most about `longest` characters, without its middle if it has more."""
    half = longest // 2
    # The end of a message names the remedy.
    return text if len(text) <= longest else f"{text[:half]} ... {text[-half:]}"


def tell(message: str) -> None:
    """Print one line of bounded length on standard error, where it does not mix with results."""
    line = shortened(printable(" ".join(message.split())), LONGEST_LINE)
    print("harness:", line, file=sys.stderr)
