"""Errors that the user can put right, and how the user is told."""

from __future__ import annotations

import sys


class HarnessError(Exception):
    """What the user can put right; the message is one line."""


def in_one_line(error: BaseException) -> str:
    """Type and message of an error that nobody has foreseen, in one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def tell(message: str) -> None:
    """Print one line on standard error, where it does not mix with results."""
    print("harness:", " ".join(message.split()), file=sys.stderr)
