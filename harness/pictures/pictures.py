"""Pictures of a study's result, for print and for colour-blind readers.

Figures are made with matplotlib's objects alone: no display, no global state.
"""

from __future__ import annotations

from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from harness.archive.atomic_files import write_whole
from harness.errors import HarnessError
from harness.pictures.cone_factor_plot import cone_factor_figure
from harness.pictures.plot_parts import png
from harness.pictures.resistance_plot import resistance_figure
from harness.pictures.stability import shows_stability
from harness.pictures.stability_map import stability_figure
from harness.pictures.work_precision import has_work_precision, study_figure


class NothingToDrawError(HarnessError):
    """The dataset has no variable that a picture shows; the message is one line."""


def draw(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Write the pictures of a study's result.

    Each file is written whole or not at all.

    Args:
        dataset: result of a study; the attribute ``study`` names the files.
        folder: where the pictures go; made where it does not exist.

    Returns:
        Paths of the pictures: `<study>_cone_factor.png`, `<study>_resistance.png`,
        `<study>_work_precision.png` and `<study>_stability.png`, as far as the dataset holds what
        they show.

    Raises:
        NothingToDrawError: it holds nothing of it.
        NothingToCompareError: it holds cone factors, but not their parameters.
        ArchiveError: a file cannot be written.
    """
    shown = figures(dataset)
    if not shown:
        raise NothingToDrawError(
            "nothing to draw: the dataset has neither cone_factor nor penetration_resistance, nor "
            "an error and a run_time, nor a map of its stability"
        )
    folder.mkdir(parents=True, exist_ok=True)
    stem = folder / dataset.attrs["study"]
    paths = {name: Path(f"{stem}_{name}.png") for name in shown}
    for name, figure in shown.items():
        write_whole(png(figure), paths[name])
    return list(paths.values())


def figures(dataset: xr.Dataset) -> dict[str, Figure]:
    """The pictures of a study's result, by name, as far as it holds what they show.

    Raises:
        NothingToCompareError: it holds cone factors, but not their parameters.
    """
    shown = {}
    if "cone_factor" in dataset:
        shown["cone_factor"] = cone_factor_figure(dataset)
    if "penetration_resistance" in dataset:
        shown["resistance"] = resistance_figure(dataset)
    if has_work_precision(dataset):
        shown["work_precision"] = study_figure(dataset)
    if shows_stability(dataset):
        shown["stability"] = stability_figure(dataset)
    return shown
