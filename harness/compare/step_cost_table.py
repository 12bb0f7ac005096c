"""What a step costs, as tables in Markdown: the result of a study of the scene `step_cost`."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence

import numpy as np
import xarray as xr

from harness.errors import HarnessError
from harness.study.cases import COMPLETED

SMALL = 0.01
"""Share of a step below which its stages are put together."""
STAGE_COLUMNS = (
    *("ns a point", "operations", "divisions", "bytes"),
    *("by arithmetic, ns", "by memory, ns", "time over the larger"),
)


def bench_rows(dataset: xr.Dataset) -> list[str]:
    """Tables of speed, of the gain by threads, of Python's share and of memory, a column a size.

    Below, for the largest case of the most physics, the stages of a step; with the times that their
    operations, or the bytes that they move, would take at the rates of bare loops.

    Raises:
        HarnessError: the dataset is of another scene.
    """
    if dataset.attrs["scene"] != "step_cost":
        raise HarnessError(f"{dataset.attrs['study']}: is not a study of the scene step_cost")
    dims = dataset.status.dims
    cases = dataset.stack(it=dims) if dims else dataset.expand_dims("it")
    completed = cases.isel(it=np.flatnonzero(cases.status.values == COMPLETED))
    each = [completed.isel(it=place) for place in range(completed.sizes["it"])]
    rows = _by_size("million updates/s, median (least to most)", each, dims, _speed)
    for title, name, text in (
        ("times as fast as one thread (as many runs at once)", "thread_gain", _gain),
        ("times as fast as a bare step", "bare_step_gain", _bare_step_gain),
        ("Python and launches, share of the time", "overhead_share", _overhead),
        ("arrays, bytes a point", "array_bytes", _array_bytes),
    ):
        measured = [case for case in each if name in case and np.isfinite(case[name].item())]
        if measured:
            rows += ["", *_by_size(title, measured, dims, text)]
    return [*rows, "", *_stage_rows(completed)] if "stage_time" in completed else rows


def _speed(case: xr.Dataset) -> str:
    rate, low, high = (
        case[name].item() / 1e6
        for name in ("update_rate", "update_rate_lowest", "update_rate_highest")
    )
    return f"{rate:.1f} ({low:.1f} to {high:.1f})"


def _gain(case: xr.Dataset) -> str:
    return f"{case.thread_gain.item():.2f} ({case.core_gain.item():.2f})"


def _bare_step_gain(case: xr.Dataset) -> str:
    return f"{case.bare_step_gain.item():.2f}"


def _overhead(case: xr.Dataset) -> str:
    return f"{case.overhead_share.item():.1%}"


def _array_bytes(case: xr.Dataset) -> str:
    return f"{case.array_bytes.item():.0f}"


def _by_size(
    title: str,
    cases: Sequence[xr.Dataset],
    dims: tuple[Hashable, ...],
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
    memory = 1e9 * case.stage_bytes.values / case.streaming_rate.item()
    arithmetic = 1e9 * (
        case.stage_operations.values / case.arithmetic_rate.item()
        + case.stage_divisions.values / case.division_rate.item()
    )
    is_small = times < SMALL * times.sum()
    table = [
        [
            f"`{case.stage.values[k]}`",
            f"{times[k]:.2f}",
            f"{case.stage_operations.values[k]:.0f}",
            f"{case.stage_divisions.values[k]:.2f}",
            f"{case.stage_bytes.values[k]:.0f}",
            f"{arithmetic[k]:.2f}",
            f"{memory[k]:.2f}",
            f"{times[k] / max(arithmetic[k], memory[k]):.1f}",
        ]
        for k in np.flatnonzero(~is_small)
    ]
    others = ["all others", f"{times[is_small].sum():.2f}", *[""] * (len(STAGE_COLUMNS) - 1)]
    rates = (case.streaming_rate, case.arithmetic_rate, case.division_rate)
    streaming, operations, divisions = (rate.item() / 1e9 for rate in rates)
    bare = f"{streaming:.1f} GB/s, {operations:.1f} GFlop/s, {divisions:.1f} billion divisions/s"
    return [
        f"A step of {case.particle_count.item():,.0f} points on one thread; bare loops: {bare}",
        "",
        *_markdown(["stage", *STAGE_COLUMNS], [*table, others]),
    ]


def _markdown(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    rule = ["---"] * len(header)
    return ["| " + " | ".join(row) + " |" for row in (header, rule, *rows)]
