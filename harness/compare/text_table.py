"""Tables of results for a terminal: a row a case, a column a parameter or a result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import over_cases, stated, varied_names

MISSING = "-"
"""In the place of a number that there is not."""


@dataclass(frozen=True)
class Column:
    """One column of a table: a heading of two lines and a text for each case."""

    heading: tuple[str, str]
    texts: list[str]

    @property
    def width(self) -> int:
        """Characters of its longest text."""
        return max(len(text) for text in (*self.heading, *self.texts))


def table_lines(columns: Sequence[Column]) -> list[str]:
    """The lines of a table: two of headings, a rule, and one for each case."""
    rows = [
        [column.heading[0] for column in columns],
        [column.heading[1] for column in columns],
        ["-" * column.width for column in columns],
        *zip(*(column.texts for column in columns), strict=True),
    ]
    return ["  ".join(_justified(row, columns)).rstrip() for row in rows]


def parameter_columns(dataset: xr.Dataset) -> list[Column]:
    """A column for each parameter that the study varies."""
    return [
        Column(heading(name), [_text(value) for value in over_cases(dataset, name)])
        for name in varied_names(dataset)
    ]


def run_columns(dataset: xr.Dataset) -> list[Column]:
    """Run time, where it is known, and status."""
    columns = []
    if "run_time" in dataset:
        seconds = over_cases(dataset, "run_time")
        columns.append(Column(("run time", "[s]"), [number(value, ".1f") for value in seconds]))
    status = over_cases(dataset, "status")
    return [*columns, Column(("", "status"), [_text(value) for value in status])]


def heading(name: str) -> tuple[str, str]:
    """A name on two lines, to keep its column narrow."""
    head, _, tail = name.rpartition("_")
    return head, tail


def number(value: float, form: str) -> str:
    """A number in a format, a dash where there is none."""
    return format(value, form) if np.isfinite(value) else MISSING


def with_half_width(value: float, half_width: float) -> str:
    """A number and its half width, where that is known; a dash where there is no number."""
    return stated(value, half_width) if np.isfinite(value) else MISSING


def _text(value: object) -> str:
    return number(value, "g") if isinstance(value, float) else str(value)


def _justified(row: Sequence[str], columns: Sequence[Column]) -> list[str]:
    return [text.rjust(column.width) for text, column in zip(row, columns, strict=True)]
