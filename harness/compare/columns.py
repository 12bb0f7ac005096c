"""Columns of a text table, a line for each case of a study."""

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    over_cases,
    reasons_of,
    stated,
    uncertainty_of,
    varied_names,
)

MISSING = "-"
"""Shown instead of a missing number."""
Column = list[str]
"""The lines of a column, all of the same width."""


def table(columns: Iterable[Column], notes: Iterable[str]) -> str:
    """Columns side by side, an empty line, and notes."""
    rows = ["  ".join(row).rstrip() for row in zip(*columns, strict=True)]
    return "\n".join([*rows, "", *notes])


def column(name: str, texts: Iterable[object]) -> Column:
    """A column: a heading of two lines, split at the last "_" of `name`, a rule, and the texts."""
    head, _, tail = name.rpartition("_")
    lines = [head, tail, *map(str, texts)]
    width = max(map(len, lines))
    return [line.rjust(width) for line in (head, tail, "-" * width, *lines[2:])]


def parameter_columns(dataset: xr.Dataset) -> list[Column]:
    """A column for each parameter that the study varies."""
    varied = varied_names(dataset)
    return [column(name, map(_text, over_cases(dataset, name))) for name in varied]


def half_width_column(dataset: xr.Dataset, name: str, heading: str) -> Column:
    """A column of numbers, each with its half width or with why it has none."""
    return stated_column(
        heading, over_cases(dataset, name), uncertainty_of(dataset), reasons_of(dataset)
    )


def stated_column(heading: str, *columns: Iterable[Any]) -> Column:
    """A column of numbers with half widths, or with reasons why they have none; all by case."""
    rows = zip(*columns, strict=True)
    return column(heading, (stated(*row) if np.isfinite(row[0]) else MISSING for row in rows))


def with_runs(dataset: xr.Dataset, columns: Iterable[Column]) -> Iterable[Column]:
    """Add the parameters before the columns, and run time and status after them."""
    yield from parameter_columns(dataset)
    yield from columns
    if "run_time" in dataset:
        yield numbers_column(dataset, "run_time", ".1f", "run time_[s]")
    yield column("status", over_cases(dataset, "status"))


def numbers_column(dataset: xr.Dataset, variable: object, form: str, name: str) -> Column:
    """A column of the numbers of a variable, or of the one of this name."""
    return column(name, (number_text(value, form) for value in over_cases(dataset, variable)))


def number_text(value: float, form: str) -> str:
    """A number in this format; `MISSING` where it is not finite."""
    return format(value, form) if np.isfinite(value) else MISSING


def _text(value: object) -> str:
    return number_text(value, "g") if isinstance(value, float) else str(value)
