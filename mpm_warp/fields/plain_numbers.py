"""The one reader of numbers in texts: files of others, tables of this project, command lines.

Python itself would take ``1_0`` for 10, digits of any script, and ``inf`` and ``nan`` in words.
"""

import csv
import math
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # commands that compute nothing do not load numpy
    import numpy as np
    from numpy.typing import NDArray

PLAIN = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)(e[-+]?\d+)?", re.ASCII | re.IGNORECASE)
LARGEST = 1e300
"""Larger numbers are mistakes, and overflow in other units."""


def plain_number(text: str) -> float | None:
    """The number that a text is, as 1, -.5 or 1.2e-3; None if it is anything else.

    Blanks around the number do not matter.
    """
    number = float(text) if PLAIN.fullmatch(text.strip()) else math.inf
    return number if abs(number) < LARGEST else None


def number_of(text: str) -> float:
    """The number that a text is; a `ValueError` if it is anything else."""
    number = plain_number(text)
    if number is None:
        raise ValueError(f"{text[:40]!r} is no number as 1.5 or 1.5e-3")
    return number


def numbers_by_column(text: str) -> "dict[str, NDArray[np.float64]]":
    """The columns of a CSV of numbers by the names in its header, NaN for an empty cell.

    Lines that begin with # are comments.

    Raises:
        ValueError: a cell is no number, or a row has more or fewer cells than the header.
    """
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    names, *rows = csv.reader(lines)
    numbers = [[number_of(cell) if cell.strip() else math.nan for cell in row] for row in rows]
    import numpy as np

    return dict(zip(names, np.array(numbers).reshape(-1, len(names)).T, strict=True))
