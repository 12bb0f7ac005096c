"""Values on the command line: how each kind is read, and what is allowed.

Each reader raises `argparse.ArgumentTypeError`, which says what is not allowed in one line.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path

UNITS = {"K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}
"""First letters of units of memory, in bytes."""


def finite_number(meaning: str, holds: Callable[[float], bool]) -> Callable[[str], float]:
    """What reads a finite number for which something holds, described in words."""

    def read(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not (math.isfinite(number) and holds(number)):
            raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must be {meaning}")
        return number

    return read


def size_in_bytes(text: str) -> float:
    """A size in bytes, or with a decimal unit."""
    number, unit = text.upper().removesuffix("B"), 1.0
    if text.upper().endswith("B") and number[-1:] in UNITS:
        number, unit = number[:-1], UNITS[number[-1]]
    try:
        size = float(number) * unit
    except ValueError:
        size = math.nan
    if not 0 < size < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must be > 0, as 8e9 or 8GB")
    return size


def html_file(text: str) -> Path:
    """A path that ends in .html."""
    # A result in its place, the page's name forgotten, would be lost.
    if not text.endswith(".html"):
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must end in .html")
    return Path(text)


def share(text: str) -> float:
    """A share > 0: 1% or 0.01."""
    try:
        value = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not allowed: must be > 0, as 1% or 0.01")
    return value


def positive_count(text: str) -> int:
    """An integer from 1 to 999999."""
    if not text.isdecimal() or len(text) > 6 or int(text) < 1:
        shown = text if len(text) < 20 else f"{text[:20]}..."
        raise argparse.ArgumentTypeError(
            f"{shown!r} is not allowed: must be an integer from 1 to 999999"
        )
    return int(text)
