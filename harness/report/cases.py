"""The cases of a study as a table that is sorted and filtered, and the parameters of each."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import xarray as xr
from markupsafe import Markup

from harness.archive.conventions import (
    COMPLETED,
    Role,
    is_there,
    limits_of,
    over_cases,
    parameter_names,
    uncertainty_of,
    varied_names,
    with_role,
)
from harness.compare.finest_error import error_name
from harness.report import words


@dataclass(frozen=True)
class Cell:
    """What a table shows of one value.

    Attributes:
        text: the value with few digits.
        value: all its digits, by which the table is sorted and filtered; "" where it is a text.
    """

    text: str
    value: str


@dataclass(frozen=True)
class Column:
    """One quantity of all cases.

    Attributes:
        title: its name.
        symbol: its symbol, "" where it has none.
        unit: its unit, "" where it has none.
        cells: one for each case.
    """

    title: str
    symbol: Markup
    unit: str
    cells: list[Cell]

    @property
    def is_number(self) -> bool:
        """Whether there are numbers to be sorted."""
        return any(cell.value for cell in self.cells)


@dataclass(frozen=True)
class CaseTable:
    """The table of a study's cases.

    Attributes:
        columns: what varies, how each case ended, and what came out.
        completed: whether each case did.
        fixed: name, value and unit of each parameter that is the same in all cases.
        own: name and unit of each parameter that is not.
        values: the texts of `own`, of each case.
    """

    columns: list[Column]
    completed: list[bool]
    fixed: list[tuple[str, str, str]]
    own: list[tuple[str, str]]
    values: list[list[str]]

    @property
    def rows(self) -> list[tuple[bool, list[Cell]]]:
        """Whether it completed and what is shown, of each case."""
        cells = zip(*(column.cells for column in self.columns), strict=True)
        return [(done, list(row)) for done, row in zip(self.completed, cells, strict=True)]

    @property
    def parameters(self) -> dict[str, Any]:
        """What the page's script shows of a case."""
        return {"fixed": self.fixed, "own": self.own, "values": self.values}


def case_table(dataset: xr.Dataset) -> CaseTable:
    """The table of a result's cases."""
    parameters = {
        name: stored for name, stored in parameter_names(dataset).items() if stored in dataset
    }
    fixed = [
        (name, words.text(dataset[stored].item()), words.unit(dataset, stored))
        for name, stored in parameters.items()
        if dataset[stored].ndim == 0 and is_there(dataset[stored].item())
    ]
    own = {name: stored for name, stored in parameters.items() if dataset[stored].ndim}
    texts = [
        [words.text(value) for value in over_cases(dataset, name).tolist()] for name in own.values()
    ]
    count = dataset["status"].size
    return CaseTable(
        columns=[_column(dataset, name) for name in _names(dataset)],
        completed=[status == COMPLETED for status in over_cases(dataset, "status")],
        fixed=fixed,
        own=[(name, words.unit(dataset, stored)) for name, stored in own.items()],
        values=[list(row) for row in zip(*texts, strict=True)] or [[] for _ in range(count)],
    )


def _names(dataset: xr.Dataset) -> list[str]:
    """The variables that have a column, as far as each case has one value of them."""
    wanted = (
        *varied_names(dataset),
        "status",
        *with_role(dataset, Role.HEADLINE),
        *with_role(dataset, Role.UNCERTAINTY),
        *([error_name(dataset)] if error_name(dataset) else []),
        *with_role(dataset, Role.DEVIATION),
        *limits_of(dataset),
        *("run_time", "peak_memory", "message"),
    )
    dims = set(dataset["status"].dims)
    return [
        str(name)
        for name in dict.fromkeys(wanted)
        # What is the same in all cases is listed elsewhere; a case alone has no dims.
        if name in dataset and set(dataset[name].dims) <= dims and (dataset[name].ndim or not dims)
    ]


def _column(dataset: xr.Dataset, name: str) -> Column:
    values = [words.in_unit(dataset, name, value) for value in over_cases(dataset, name).tolist()]
    texts = map(_texts_of(dataset, name), values, uncertainty_of(dataset).tolist())
    cells = [Cell(text, _sortable(value)) for text, value in zip(texts, values, strict=True)]
    title = "outcome" if name == "status" else words.title(dataset, name)
    return Column(title, words.symbol(name), words.unit(dataset, name), cells)


def _texts_of(dataset: xr.Dataset, name: str) -> Callable[[Any, float], str]:
    """What shows a variable, given its value and the uncertainty of the headline in each case."""
    match dataset[name].attrs.get("role"):
        case Role.DEVIATION:
            return lambda value, half_width: words.percent(value)
        case Role.HEADLINE | Role.UNCERTAINTY if with_role(dataset, Role.UNCERTAINTY):
            return words.known
        case Role.PARAMETER:
            return lambda value, half_width: words.text(value)
        case _:
            return lambda value, half_width: words.text(value, digits=3)


def _sortable(value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    return repr(value) if math.isfinite(value) else ""
