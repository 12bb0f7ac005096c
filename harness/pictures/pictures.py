"""Pictures of a study's result, for print and for colour-blind readers.

Figures are made with matplotlib's objects alone: no display, no global state. Each picture has a
file of its own, which says for which results it is meant.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure

from harness.archive.atomic_files import write_whole
from harness.archive.conventions import without_incomplete_curves
from harness.errors import HarnessError
from harness.pictures.cone_factor_plot import cone_factor_figure, shows_cone_factor
from harness.pictures.plot_parts import png
from harness.pictures.resistance_plot import resistance_figure, shows_resistance
from harness.pictures.stability import shows_stability
from harness.pictures.stability_map import stability_figure
from harness.pictures.work_precision import shows_work_precision, study_figure

PICTURES: dict[str, tuple[Callable[[xr.Dataset], bool], Callable[[xr.Dataset], Figure]]] = {
    "cone_factor": (shows_cone_factor, cone_factor_figure),
    "resistance": (shows_resistance, resistance_figure),
    "work_precision": (shows_work_precision, study_figure),
    "stability": (shows_stability, stability_figure),
}
"""By name: whether a picture is meant for a result, and the picture."""


class NothingToDrawError(HarnessError):
    """The dataset has no variable that a picture shows; the message is one line."""


def draw(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Write the pictures of a study's result.

    Each file is written whole or not at all.

    Args:
        dataset: result of a study; the attribute ``study`` names the files.
        folder: where the pictures go; made where it does not exist.

    Returns:
        Paths of the pictures, `<study>_<name>.png`, as far as they are meant for the result.

    Raises:
        NothingToDrawError: none is.
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
    paths = [folder / f"{dataset.attrs['study']}_{name}.png" for name in shown]
    for path, figure in zip(paths, shown.values(), strict=True):
        write_whole(png(figure), path)
    return paths


def figures(dataset: xr.Dataset) -> dict[str, Figure]:
    """The pictures that are meant for a study's result, by name; a failed case has no curve there.

    Raises:
        NothingToCompareError: it holds cone factors, but not their parameters.
    """
    sound = without_incomplete_curves(dataset)
    return {name: figure(sound) for name, (shows, figure) in PICTURES.items() if shows(sound)}
