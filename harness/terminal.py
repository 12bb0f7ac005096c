"""Colour on a terminal, which nothing that is read from a file can give itself."""

import os
import secrets
import sys
from typing import TextIO

GREEN, RED, PLAIN = (f"\0{secrets.token_hex(8)}\0" for _ in range(3))
"""What stands for a colour until it is printed: no file can know it."""
CODES = {GREEN: "\033[32m", RED: "\033[31m", PLAIN: "\033[0m"}
"""What a terminal takes for it."""


def coloured(text: str, *, is_good: bool, stream: TextIO | None = None) -> str:
    """A text in green or red where it goes to a terminal that has colours; otherwise as it is.

    The environment variable ``NO_COLOR`` (https://no-color.org), set to anything, keeps it plain.

    Args:
        text: what is to be printed.
        is_good: whether it reports what went well.
        stream: where it is printed as it is; default: standard output, where
            `harness.cli.process` puts the codes of the colours in.
    """
    to_terminal = (stream or sys.stdout).isatty()
    if not to_terminal or os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return text
    begin, end = GREEN if is_good else RED, PLAIN
    return f"{begin}{text}{end}" if stream is None else f"{CODES[begin]}{text}{CODES[end]}"
