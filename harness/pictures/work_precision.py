"""Work-precision pictures: error against run time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.atomic_files import write_whole
from harness.archive.conventions import COMPLETED, over_cases, scenes_of, spoken, varied_names
from harness.compare.finest_error import error_name
from harness.pictures.plot_parts import FAILED, MARKERS, empty_figure, png
from mpm_warp.scenes import scene_class, scene_names

MOST_LABELS = 12
"""Settings on the Pareto front that find room in a picture."""


def draw_work_precision(dataset: xr.Dataset, path: Path) -> None:
    """Write the picture, whole or not at all.

    Args:
        dataset: `error` and `run_time` over `check` and `rank`.
        path: the PNG file.

    Raises:
        ArchiveError: it cannot be written.
    """
    write_whole(png(work_precision_figure(dataset)), path)


def work_precision_figure(dataset: xr.Dataset) -> Figure:
    """Both axes logarithmic; runs that failed are left out."""
    figure, axes = empty_figure()
    checks = dataset["check"].values
    for index, (check, colour) in enumerate(zip(checks, _colours(checks.size), strict=True)):
        curve = dataset.isel(check=index)
        marker = MARKERS[index % len(MARKERS)]
        axes.loglog(
            curve["run_time"], curve["error"], marker=marker, color=colour, label=str(check)
        )
    _dress(axes, "error against the exact solution")
    return figure


def shows_work_precision(dataset: xr.Dataset) -> bool:
    """Whether a study's result holds errors and run times."""
    return error_name(dataset) is not None and "run_time" in dataset


def study_figure(dataset: xr.Dataset) -> Figure:
    """Error against run time of a study's cases, and the front of those that no other beats.

    Each scene of several has a front of its own. A case that did not complete has no error: it
    stands on the upper edge, at the time it took.
    """
    name = error_name(dataset)
    assert name is not None, "the dataset has no errors"
    errors, seconds = over_cases(dataset, name), over_cases(dataset, "run_time")
    figure, axes = empty_figure()
    sound = np.isfinite(errors) & np.isfinite(seconds) & (errors > 0.0)
    axes.loglog(seconds[sound], errors[sound], "o", color="0.45", ms=4, label="cases")
    scenes = np.array(scenes_of(dataset))
    names = list(dict.fromkeys(scenes.tolist()))
    for scene, colour in zip(names, _colours(len(names)), strict=True):
        own = scenes == scene
        front = _pareto(seconds, errors, np.flatnonzero(sound & own))
        method = scene_class(scene).method if scene in scene_names() else ()
        columns = {it: over_cases(dataset, it) for it in varied_names(dataset) if it in method}
        varied = {it: column for it, column in columns.items() if len({*column[own].tolist()}) > 1}
        label = f"{scene}, Pareto front: {' / '.join(map(spoken, varied))}".removesuffix(": ")
        axes.loglog(seconds[front], errors[front], "o-", color=colour, label=label)
        for case in front[:MOST_LABELS] if varied else ():
            values = (column[case] for column in varied.values())
            text = " / ".join(f"{value:g}" if np.isreal(value) else str(value) for value in values)
            place = (float(seconds[case]), float(errors[case]))
            axes.annotate(text, place, xytext=(4, 4), textcoords="offset points", size=6)
    failed = over_cases(dataset, "status") != COMPLETED
    if "case_time" in dataset and failed.any():
        axes.plot(
            over_cases(dataset, "case_time")[failed],
            np.ones(failed.sum()),
            "x",
            color=FAILED,
            transform=axes.get_xaxis_transform(),
            clip_on=False,
            label="failed",
        )
    _dress(axes, dataset[name].attrs.get("long_name", name) if len(names) == 1 else name)
    return figure


def _colours(count: int) -> np.ndarray:
    return colormaps["viridis"](np.linspace(0.0, 0.85, count))


def _dress(axes: Axes, meaning: str) -> None:
    axes.set_xlabel("run time [s]")
    axes.set_ylabel(f"{meaning} [-]")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, fontsize=7, frameon=False)


def _pareto(seconds: np.ndarray, errors: np.ndarray, cases: np.ndarray) -> np.ndarray:
    """The cases that no other is both faster and better than, the fastest first."""
    ordered = cases[np.lexsort((errors[cases], seconds[cases]))]
    best = np.minimum.accumulate(errors[ordered]) if ordered.size else errors[ordered]
    before = np.concatenate([[np.inf], best[:-1]])
    front: np.ndarray = ordered[errors[ordered] < before[: ordered.size]]
    return front
