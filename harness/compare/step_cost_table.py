"""What a step costs, as tables in Markdown: the result of a study of the scene `step_cost`."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from harness.archive.conventions import COMPLETED, case_dims
from harness.errors import HarnessError

SMALL = 0.01
"""Share of a step below which its stages are put together."""


def bench_rows(dataset: xr.Dataset) -> list[str]:
    """Tables of speed, of the gain by threads, of Python's share and of memory, a column a size.

    Below stand the stages of a step, with their times, of the largest case of the most physics.

    Raises:
        HarnessError: the dataset is of another scene.
    """
    if dataset.attrs["scene"] != "step_cost":
        raise HarnessError(f"{dataset.attrs['study']}: is not a study of the scene step_cost")
    dims = case_dims(dataset)
    cases = dataset.stack(it=dims) if dims else dataset.expand_dims("it")
    completed = cases.isel(it=np.flatnonzero(cases.status.values == COMPLETED))
    each = [completed.isel(it=place) for place in range(completed.sizes["it"])]
    rows = _by_size("million updates/s, median (least to most)", each, dims, _speed)
    for title, name, text in TABLES:
        measured = [case for case in each if name in case and np.isfinite(case[name].item())]
        if measured:
            rows += ["", *_by_size(title, measured, dims, text)]
    return [*rows, "", *_stage_rows(completed)] if "stage_time" in completed else rows


def _speed(case: xr.Dataset) -> str:
    names = ("update_rate", "update_rate_lowest", "update_rate_highest")
    rate, low, high = (case[name].item() / 1e6 for name in names)
    return f"{rate:.1f} ({low:.1f} to {high:.1f})"


def _gain(case: xr.Dataset) -> str:
    return f"{case.thread_gain.item():.2f} ({case.core_gain.item():.2f})"


TABLES: Sequence[tuple[str, str, Callable[[xr.Dataset], str]]] = (
    ("times as fast as one thread (as many runs at once)", "thread_gain", _gain),
    (
        "times as fast as a bare step",
        "bare_step_gain",
        lambda case: f"{case.bare_step_gain.item():.2f}",
    ),
    (
        "Python and launches, share of the time",
        "overhead_share",
        lambda case: f"{case.overhead_share.item():.1%}",
    ),
    ("arrays, bytes a point", "array_bytes", lambda case: f"{case.array_bytes.item():.0f}"),
)
"""Title, variable and text of the tables besides the speed."""


def _by_size(
    title: str,
    cases: Sequence[xr.Dataset],
    dims: Sequence[str],
    text: Callable[[xr.Dataset], str],
) -> list[str]:
    """A table with a column for each size and a row for whatever else varies."""
    table: dict[str, dict[int, str]] = {}
    for case in cases:
        others = ", ".join(f"{name} {case[name].item()}" for name in dims if name != "size")
        table.setdefault(others, {})[int(case["size"].item())] = text(case)
    sizes = sorted({size for row in table.values() for size in row})
    return _markdown(
        [title, *(f"{size:,} points" for size in sizes)],
        [[others, *(row.get(size, "") for size in sizes)] for others, row in table.items()],
    )


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
