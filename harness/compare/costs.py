"""Costs: the cheapest settings for an error (`recommend`), and tables of speed (`bench`).

Settings are looked up in stored results. The tables are Markdown, of results of `step_cost`.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError
from harness.archive.conventions import (
    CASE,
    COMPLETED,
    alike,
    case_dims,
    headline_values,
    is_there,
    largest_parts_of,
    over_cases,
    parameter_of,
    uncertainty_of,
    varied_names,
)
from harness.archive.netcdf_files import read_attributes
from harness.archive.provenance import tell_of_other_version
from harness.archive.study_files import read_study
from harness.compare.columns import markdown_lines
from harness.compare.defaults import not_by_default
from harness.compare.finest_error import credited_error, error_name
from harness.errors import HarnessError, counted, tell
from harness.study.scene_part import method_of
from mpm_warp.fields.declaration import Parameter, Value
from mpm_warp.fields.flat import parameters_of
from mpm_warp.scenes import scene_class

DERIVED = "derived"
"""Shown for a parameter of the method that the scene derives itself."""


@dataclass(frozen=True, kw_only=True)
class Recommendation:
    """Settings of the method, with their measured time and error."""

    settings: dict[str, Value]  # those that vary between cases or differ from the default
    run_time: float  # longest wall-clock time of the time loop among cases with them [s]
    error: float  # largest relative error among these cases; see `credited_error`
    largest_part: str  # of the half width where that is the error, and what makes it smaller
    case_count: int  # cases with a known error, or that did not complete
    file: Path  # the result that they come from

    def __str__(self) -> str:
        text = ", ".join(f"{name} = {value}" for name, value in self.settings.items())
        return (
            f"{text or 'default settings'}: error {self.error:.2%} and {self.run_time:.3g} s at "
            f"most, over {counted(self.case_count, 'case')} of {self.file}"
            f"{self.largest_part and f'; largest part of its U: {self.largest_part}'}"
        )


def recommend(scene: str, largest_error: float, files: Iterable[Path]) -> Recommendation:
    """The cheapest settings whose relative error is small enough in every case.

    If none are, it is those of the smallest error.
    Files of other scenes or without errors are ignored, but one of the scene must have errors.
    """
    known = scene_class(scene)
    method = {name: parameters_of(known)[name] for name in method_of(known)}
    read = {file: read_study(file) for file in files if _has(file, scene)}
    results = {file: _of_scene(scene, dataset) for file, dataset in read.items()}
    for file, dataset in results.items():
        tell_of_other_version(file, dataset)
    found = [one for file, dataset in results.items() for one in _measured(method, dataset, file)]
    if not found:
        raise HarnessError(f"{scene}: {_why_nothing(method, results.values())}")
    good = [entry for entry in found if entry.error <= largest_error]
    nearest = min(found, key=lambda it: it.error)
    return min(good, key=lambda it: it.run_time, default=nearest)


def results_in(folder: Path) -> list[Path]:
    """The netCDF files of a folder, sorted."""
    if not folder.is_dir():
        raise HarnessError(f"--results {folder}: no such folder")
    return sorted(folder.glob("*.nc"))


def _has(file: Path, scene: str) -> bool:
    """Whether a file is a result of the scene; a line says if it cannot be read."""
    try:
        attributes = read_attributes(file)
    except ArchiveError as error:
        tell(str(error))
        return False
    return "study" in attributes and scene in str(attributes.get("scene")).split()


def _of_scene(scene: str, dataset: xr.Dataset) -> xr.Dataset:
    """The cases of one scene; coordinates that do not vary among them become scalars."""
    if "scene" not in dataset.coords:
        return dataset
    cases = dataset.isel(case=np.flatnonzero(dataset["scene"].values == scene))
    constant = {
        name: variable.variable[0]
        for name, variable in cases.coords.items()
        if name != CASE and np.unique(variable.values).size == 1
    }
    return cases.assign_coords(constant).assign_attrs(scene=scene)


def _varied(method: Collection[str], dataset: xr.Dataset) -> list[str]:
    return [name for name in varied_names(dataset) if parameter_of(name) in method]


def _why_nothing(method: Collection[str], results: Collection[xr.Dataset]) -> str:
    if not method:
        return "its error is unknown: it has neither an exact solution nor parameters of the method"
    if not results or any(_varied(method, dataset) for dataset in results):
        return "no stored result has errors; run a study of it first"
    return f"no stored result has errors, because none varies the method: {', '.join(method)}"


def _measured(
    method: Mapping[str, Parameter], dataset: xr.Dataset, file: Path
) -> list[Recommendation]:
    """Time and error of each combination of settings in a result."""
    if error_name(dataset) is None or "run_time" not in dataset:
        return []
    error, parts = credited_error(dataset), largest_parts_of(dataset)
    by_half_width = uncertainty_of(dataset) / np.abs(headline_values(dataset))
    seconds = over_cases(dataset, "run_time")
    done = over_cases(dataset, "status") == COMPLETED
    fixed = {
        name: _setting(dataset[own].item(), method[name])
        for name, own in not_by_default(dataset).items()
        if name in method
    }
    varied, found = _varied(method, dataset), []
    for values, cases in alike(dataset, varied).items():
        errors = error[cases]
        # The case that the errors refer to has no error, so it says nothing about its settings.
        judged = np.isfinite(errors) | ~done[cases]
        if judged.any():
            judged_by = np.where(judged, np.where(done[cases], errors, np.inf), -np.inf)
            worst = cases[int(np.argmax(judged_by))]
            own = zip(map(parameter_of, varied), values, strict=True)
            found.append(
                Recommendation(
                    settings=fixed | {name: _setting(value, method[name]) for name, value in own},
                    run_time=float(np.nanmax(seconds[cases])) if done[cases].any() else np.inf,
                    error=float(judged_by.max()),
                    largest_part=parts[worst] if error[worst] == by_half_width[worst] else "",
                    case_count=int(judged.sum()),
                    file=file,
                )
            )
    return found


def _setting(value: Any, definition: Parameter) -> Value:
    """A value in the type of its parameter, which a file of several scenes does not keep."""
    return definition.kind(value) if is_there(value) else DERIVED


SMALL = 0.01
"""Stages with a smaller share of the step are listed together as "all others"."""
BOUND_BY_MEMORY = 0.8
"""Share of the bandwidth of a copy from which on memory is the limit of a step (roofline model)."""


RATES = ("update_rate", "update_rate_lowest", "update_rate_highest")
TABLES: Mapping[str, tuple[str, Sequence[str], float]] = {
    "million updates/s, median (least to most)": ("{:.1f} ({:.1f} to {:.1f})", RATES, 1e6),
    "times as fast as one thread": ("{:.2f}", ["thread_gain"], 1.0),
    "arrays, bytes a point": ("{:.0f}", ["array_bytes"], 1.0),
}
"""Tables by title: format of a cell, results in it, and the number they are divided by."""


def bench_rows(dataset: xr.Dataset) -> list[str]:
    """Tables of speed, gain by threads and memory, with a column for each number of points.

    A table of the stages of a step follows, for the largest case among those with most stages.
    """
    if dataset.attrs["scene"] != "step_cost":
        raise HarnessError(f"{dataset.attrs['study']}: is not a study of the scene step_cost")
    dims = case_dims(dataset)
    cases = dataset.stack(it=dims) if dims else dataset.expand_dims("it")
    completed = cases.isel(it=np.flatnonzero(cases.status.values == COMPLETED))
    each = [completed.isel(it=place) for place in range(completed.sizes["it"])]
    tables = [_by_size(title, each, dims) for title in TABLES]
    rows = [line for table in tables if table for line in (*table, "")]
    return [*rows, *_stage_rows(completed)] if "stage_time" in completed else rows[:-1]


def _by_size(title: str, cases: Sequence[xr.Dataset], dims: Sequence[str]) -> list[str]:
    """A table with a column for each size and a row for each combination of other parameters."""
    text, names, unit = TABLES[title]
    table: dict[str, dict[int, str]] = {}
    for case in cases:
        values = [case[name].item() / unit if name in case else np.nan for name in names]
        if np.isfinite(values[0]):
            varied = [name for name in dims if name != "size"] or ["physics"]
            others = ", ".join(f"{name} {case[name].item()}" for name in varied)
            table.setdefault(others, {})[int(case["size"].item())] = text.format(*values)
    sizes = sorted({size for row in table.values() for size in row})
    rows = [[others, *(row.get(size, "") for size in sizes)] for others, row in table.items()]
    return markdown_lines([title, *(f"{size:,} points" for size in sizes)], rows) if rows else []


def _stage_rows(cases: xr.Dataset) -> list[str]:
    """The stages of a step, and how much of the bandwidth of a copy each reaches."""
    stage_count = cases.stage_time.notnull().sum("stage").values
    largest = np.lexsort((cases.particle_count.values, stage_count))[-1]
    case = cases.isel(it=int(largest)).dropna("stage", subset=["stage_time"])
    case = case.sortby("stage_time", ascending=False)
    times, moved = case.stage_time.values, case.stage_bytes.values
    step, most = times.sum(), case.copy_rate.item() / 1e9  # bytes a nanosecond
    is_small = times < SMALL * step
    groups = [(f"`{case.stage.values[k]}`", np.array([k])) for k in np.flatnonzero(~is_small)]
    if is_small.any():
        groups.append(("all others", is_small))
    table = [
        [
            name,
            f"{times[own].sum():.2f}",
            f"{times[own].sum() / step:.1%}",
            f"{moved[own].sum():.0f}",
            f"{moved[own].sum() / times[own].sum() / most:.0%}",
        ]
        for name, own in groups
    ]
    reached = moved.sum() / step / most
    limit = "memory" if reached > BOUND_BY_MEMORY else "not memory"
    says = (
        f"The step moves {moved.sum() / step:.1f} GB/s, {reached:.0%} of what a copy moves here "
        f"({most:.1f} GB/s): its limit is {limit}."
    )
    device = cases.attrs["device"]
    where = "one thread" if device == "cpu" else device
    title = f"A step of {case.particle_count.item():,.0f} points on {where}"
    heading = ["stage", "ns a point", "share of the step", "bytes a point", "of a copy's bandwidth"]
    return [title, "", *markdown_lines(heading, table), "", says]
