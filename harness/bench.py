"""What a step costs, as text: the result of a study of the scene `step_cost`."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np
import xarray as xr

from harness import HarnessError
from harness.cases import COMPLETED

LABEL = 40
SMALL = 0.01
"""Share of a step below which its stages are put together."""


def bench_rows(dataset: xr.Dataset) -> list[str]:
    """A line a case: speed as median (least to most), time and memory per material point.

    Below, for the largest case of the most physics, the stages of a step; with the time that their
    arrays would take at the rate of a bare streaming loop.

    Raises:
        HarnessError: the dataset is of another scene.
    """
    if dataset.attrs["scene"] != "step_cost":
        raise HarnessError(f"{dataset.attrs['study']}: is not a study of the scene step_cost")
    dims = dataset.status.dims
    cases = dataset.stack(it=dims) if dims else dataset.expand_dims("it")
    completed = cases.isel(it=np.flatnonzero(cases.status.values == COMPLETED))
    rows = [
        f"{'':{LABEL}}{'points':>9}{'million updates/s':>24}{'ns a point':>12}{'bytes':>15}",
        *(_case_row(completed.isel(it=place), dims) for place in range(completed.sizes["it"])),
    ]
    return [*rows, *_stage_rows(completed)] if "stage_time" in completed else rows


def _case_row(case: xr.Dataset, dims: tuple[Hashable, ...]) -> str:
    label = ", ".join(f"{name}={case[name].item()}" for name in dims)
    rate, low, high = (
        case[name].item() / 1e6
        for name in ("update_rate", "update_rate_lowest", "update_rate_highest")
    )
    speed = f"{rate:.1f} ({low:.1f} to {high:.1f})"
    return (
        f"{label:{LABEL}}{case.particle_count.item():9.0f}{speed:>24}{1e3 / rate:12.1f}"
        f"{case.array_bytes.item():15.0f}"
    )


def _stage_rows(cases: xr.Dataset) -> list[str]:
    stage_count = cases.stage_time.notnull().sum("stage").values
    largest = np.lexsort((cases.particle_count.values, stage_count))[-1]
    case = cases.isel(it=int(largest)).dropna("stage", subset=["stage_time"])
    case = case.sortby("stage_time", ascending=False)
    streaming, arithmetic = case.streaming_rate.item() / 1e9, case.arithmetic_rate.item() / 1e9
    times, sizes = case.stage_time.values, case.stage_bytes.values
    is_small = times < SMALL * times.sum()
    stages = [
        f"{name:20}{time:12.2f}{size:15.0f}{size / streaming:20.2f}{time * streaming / size:8.1f}"
        for name, time, size, small in zip(case.stage.values, times, sizes, is_small, strict=True)
        if not small
    ]
    bare = f"{streaming:.1f} GB/s of memory traffic, {arithmetic:.1f} GFlop/s"
    return [
        "",
        f"a step of {case.particle_count.item():.0f} points on one thread; bare loops: {bare}",
        f"{'stage':20}{'ns a point':>12}{'bytes':>15}{'memory alone [ns]':>20}{'ratio':>8}",
        *stages,
        f"{'all others':20}{times[is_small].sum():12.2f}",
    ]
