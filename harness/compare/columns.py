"""Columns of a table with a line for each case of a study, and the forms of tables."""

import csv
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    known_digits,
    over_cases,
    reasons_of,
    stated,
    uncertainty_of,
    varied_names,
    words_of,
)

MISSING = "-"
"""Shown instead of a missing number."""


class Column(NamedTuple):
    """A column: its name, which a text table splits at the last "_", and a text for each case."""

    name: str
    texts: list[str]
    apart: "tuple[Column, ...]" = ()  # what a csv has in its place: one number or text a cell


Rows = Sequence[Sequence[str]]


def table(columns: Iterable[Column], notes: Iterable[str], form: str = "text") -> str:
    """A table in one of `FORMS`, an empty line, and notes; `csv` has no notes."""
    if form == "csv":
        columns = [it for column in columns for it in column.apart or (column,)]
    names, texts, _ = zip(*columns, strict=True)
    rows = list(zip(*texts, strict=True))
    if form == "text":
        return "\n".join([*_text_lines(names, rows), "", *notes])
    headings = [name.replace("_", " ").strip() for name in names]
    lines = FORMS[form](headings, [[" ".join(text.split()) for text in row] for row in rows])
    mark = {"latex": "%", "markdown": "-"}.get(form)
    after = ["", *(f"{mark} {note.strip()}" for note in notes)] if mark else []
    return "\n".join([*lines, *after])


def _text_lines(names: Sequence[str], rows: Rows) -> list[str]:
    """Columns side by side, with headings of two lines and a rule."""
    cut = [name.rpartition("_") for name in names]
    heads = [[head for head, _, _ in cut], [tail for *_, tail in cut]]
    columns = list(zip(*heads, *rows, strict=True))
    widths = [max(map(len, lines)) for lines in columns]
    whole = [*heads, ["-" * width for width in widths], *rows]
    return ["  ".join(map(str.rjust, row, widths)).rstrip() for row in whole]


def markdown_lines(names: Sequence[str], rows: Rows) -> list[str]:
    """A table in Markdown."""
    rule = ["---"] * len(names)
    return ["| " + " | ".join(row) + " |" for row in (names, rule, *rows)]


def _latex_lines(names: Sequence[str], rows: Rows) -> list[str]:
    """A table in LaTeX, of its basic commands."""
    body = [" & ".join(map(_in_latex, row)) + r" \\" for row in (names, *rows)]
    begin = rf"\begin{{tabular}}{{{'r' * len(names)}}}"
    return [begin, r"\hline", body[0], r"\hline", *body[1:], r"\hline", r"\end{tabular}"]


def _in_latex(text: str) -> str:
    special: dict[str | int, str | int | None] = {it: f"\\{it}" for it in "&%$#_{}"}
    escaped = text.translate(
        str.maketrans({**special, "\\": r"\textbackslash{}", "~": r"\~{}", "^": r"\^{}"})
    )
    return escaped.replace("+-", r"$\pm$")


def _csv_lines(names: Sequence[str], rows: Rows) -> list[str]:
    text = io.StringIO()
    cells = [["" if cell == MISSING else cell for cell in row] for row in rows]
    csv.writer(text, lineterminator="\n").writerows([names, *cells])
    return text.getvalue().splitlines()


FORMS: Mapping[str, Callable[[Sequence[str], Rows], list[str]]] = {
    "markdown": markdown_lines,
    "latex": _latex_lines,
    "csv": _csv_lines,
}
"""What makes the lines of a table, by form; besides there is "text"."""


def column(name: str, texts: Iterable[object]) -> Column:
    """A column with the texts of some objects."""
    return Column(name, [*map(str, texts)])


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
    rows = list(zip(*columns, strict=True))
    texts = [stated(*row) if np.isfinite(row[0]) else MISSING for row in rows]
    apart = (
        column(heading, (known_digits(*row[:2]) if np.isfinite(row[0]) else "" for row in rows)),
        column(
            f"{heading}_+-", (known_digits(half, half) if half > 0.0 else "" for _, half, _ in rows)
        ),
        column(f"{heading}_no U", (words_of([reason]) for *_, reason in rows)),
    )
    return Column(heading, texts, apart)


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
