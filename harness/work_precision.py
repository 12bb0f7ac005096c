"""The work-precision picture: error against run time, a curve for each check."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.figure import Figure

MARKERS = "osD^v<>pX*"


def draw_work_precision(dataset: xr.Dataset, path: Path) -> None:
    """Write the picture, whole or not at all.

    Args:
        dataset: `error` and `run_time` over `check` and `rank`.
        path: the PNG file.

    Raises:
        OSError: the file cannot be written.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        work_precision_figure(dataset).savefig(part, format="png", bbox_inches="tight")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def work_precision_figure(dataset: xr.Dataset) -> Figure:
    """Both axes logarithmic; runs that failed are left out."""
    figure = Figure(figsize=(6.4, 4.8), dpi=200)
    axes = figure.add_subplot()
    count = dataset.sizes["check"]
    colours = colormaps["viridis"](np.linspace(0.0, 0.85, count))
    for index, check in enumerate(dataset["check"].values):
        curve = dataset.isel(check=index)
        axes.loglog(
            curve["run_time"],
            curve["error"],
            marker=MARKERS[index % len(MARKERS)],
            color=colours[index],
            label=str(check),
        )
    axes.set_xlabel("run time [s]")
    axes.set_ylabel("error against the exact solution [-]")
    axes.grid(color="0.9", lw=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, fontsize=7, frameon=False)
    return figure
