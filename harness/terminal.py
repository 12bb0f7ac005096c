"""Colour on a terminal."""

from __future__ import annotations

import os
import sys
from typing import TextIO

GOOD, BAD, PLAIN = "\033[32m", "\033[31m", "\033[0m"


def coloured(text: str, *, is_good: bool, stream: TextIO | None = None) -> str:
    """A text in green or red where it goes to a terminal that has colours; otherwise as it is.

    The environment variable ``NO_COLOR`` (https://no-color.org), set to anything, keeps it plain.

    Args:
        text: what is to be printed.
        is_good: whether it reports what went well.
        stream: where it is to be printed; default: standard output.
    """
    to_terminal = (stream or sys.stdout).isatty()
    if not to_terminal or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return text
    return f"{GOOD if is_good else BAD}{text}{PLAIN}"
