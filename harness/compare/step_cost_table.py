"""What a step costs, as tables in Markdown: the result of a study of the scene `step_cost`."""

from collections.abc import Sequence
from string import Formatter

import numpy as np
import xarray as xr

from harness.archive.conventions import COMPLETED, case_dims
from harness.errors import HarnessError

SMALL = 0.01
"""Share of a step below which its stages are put together."""


TABLES = {
    "million updates/s, median (least to most)": (
        "{update_rate:.1f} ({update_rate_lowest:.1f} to {update_rate_highest:.1f})"
    ),
    "times as fast as one thread": "{thread_gain:.2f}",
    "arrays, bytes a point": "{array_bytes:.0f}",
}
"""Titles of the tables, and what stands in them of each case."""


def bench_rows(dataset: xr.Dataset) -> list[str]:
    """Tables of speed, of the gain by threads and of memory, a column a size.

    Below stand the stages of a step, with their times, of the largest case of the most physics.
    """
    if dataset.attrs["scene"] != "step_cost":
        raise HarnessError(f"{dataset.attrs['study']}: is not a study of the scene step_cost")
    dims = case_dims(dataset)
    cases = dataset.stack(it=dims) if dims else dataset.expand_dims("it")
    completed = cases.isel(it=np.flatnonzero(cases.status.values == COMPLETED))
    each = [completed.isel(it=place) for place in range(completed.sizes["it"])]
    tables = [_by_size(title, text, each, dims) for title, text in TABLES.items()]
    rows = [line for table in tables if table for line in (*table, "")]
    return [*rows, *_stage_rows(completed)] if "stage_time" in completed else rows[:-1]


def _by_size(title: str, text: str, cases: Sequence[xr.Dataset], dims: Sequence[str]) -> list[str]:
    """A table with a column for each size and a row for whatever else varies; none of no case."""
    names = [name for _, name, _, _ in Formatter().parse(text) if name]
    table: dict[str, dict[int, str]] = {}
    for case in cases:
        values = {name: case[name].item() if name in case else np.nan for name in names}
        values |= {name: values[name] / 1e6 for name in names if name.startswith("update_rate")}
        if np.isfinite(values[names[0]]):
            others = ", ".join(f"{name} {case[name].item()}" for name in dims if name != "size")
            table.setdefault(others, {})[int(case["size"].item())] = text.format(**values)
    sizes = sorted({size for row in table.values() for size in row})
    rows = [[others, *(row.get(size, "") for size in sizes)] for others, row in table.items()]
    return _markdown([title, *(f"{size:,} points" for size in sizes)], rows) if rows else []


def _stage_rows(cases: xr.Dataset) -> list[str]:
    stage_count = cases.stage_time.notnull().sum("stage").values
    largest = np.lexsort((cases.particle_count.values, stage_count))[-1]
    case = cases.isel(it=int(largest)).dropna("stage", subset=["stage_time"])
    case = case.sortby("stage_time", ascending=False)
    times = case.stage_time.values
    is_small = times < SMALL * times.sum()
    table = [
        [f"`{case.stage.values[k]}`", f"{times[k]:.2f}", f"{times[k] / times.sum():.1%}"]
        for k in np.flatnonzero(~is_small)
    ]
    small = times[is_small].sum()
    others = ["all others", f"{small:.2f}", f"{small / times.sum():.1%}"]
    return [
        f"A step of {case.particle_count.item():,.0f} points on one thread",
        "",
        *_markdown(["stage", "ns a point", "share of the step"], [*table, others]),
    ]


def _markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    rule = ["---"] * len(header)
    return ["| " + " | ".join(row) + " |" for row in (header, rule, *rows)]
