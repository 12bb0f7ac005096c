"""Pictures of a study's result, for print and for colour-blind readers.

Figures are made with matplotlib's objects alone: no display, no global state. Each picture has a
file of its own, which says for which results it is meant.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import xarray as xr
from matplotlib.figure import Figure

from harness.archive.conventions import without_incomplete_curves
from harness.errors import HarnessError
from harness.pictures.case_curves import (
    cycles_figure,
    element_tests_figure,
    resistance_figure,
    shows_cycles,
    shows_element_tests,
    shows_resistance,
)
from harness.pictures.cases import (
    cases_figure,
    scenes_figure,
    shows_cases,
    shows_scenes,
    shows_spread,
    spread_figure,
)
from harness.pictures.convergence import convergence_figure, shows_convergence
from harness.pictures.curve import curve_figure, map_figure, shows_curve, shows_map
from harness.pictures.drawing.plot_parts import check_replaceable, image, write_own
from harness.pictures.effects import effects_figure, shows_effects, shows_tornado, tornado_figure
from harness.pictures.sounding import shows_sounding, sounding_figure
from harness.pictures.stability import shows_stability
from harness.pictures.stability_map import stability_figure
from harness.pictures.work_precision import shows_work_precision, study_figure

PICTURES: dict[str, tuple[Callable[[xr.Dataset], bool], Callable[[xr.Dataset], Figure]]] = {
    "curve": (shows_curve, curve_figure),
    "map": (shows_map, map_figure),
    "tornado": (shows_tornado, tornado_figure),
    "convergence": (shows_convergence, convergence_figure),
    "cycles": (shows_cycles, cycles_figure),
    "element_tests": (shows_element_tests, element_tests_figure),
    "spread": (shows_spread, spread_figure),
    "effects": (shows_effects, effects_figure),
    "cases": (shows_cases, cases_figure),
    "scenes": (shows_scenes, scenes_figure),
    "work_precision": (shows_work_precision, study_figure),
    "resistance": (shows_resistance, resistance_figure),
    "stability": (shows_stability, stability_figure),
    "sounding": (shows_sounding, sounding_figure),
}
"""By name: whether a picture is meant for a result, and the picture, drawn of such results alone;
the main ones first."""


class NothingToDrawError(HarnessError):
    """The dataset has no variable that a picture shows; the message is one line."""


Rendered = TypeVar("Rendered")
Failures = dict[str, Exception]
"""Errors of this program in pictures, by the name of the picture."""


def draw(
    dataset: xr.Dataset, folder: Path, forms: Sequence[str] = ("png",)
) -> tuple[list[Path], Failures]:
    """Write the pictures of a study's result, each whole or not at all.

    Returns:
        Paths of the pictures, ``<study>_<name>.<format>``, as far as they are meant for the result;
        and the errors of the pictures that could not be drawn.

    Raises:
        NothingToDrawError: none is meant for it.
        NotOwnFileError: a file is in the way that was not written by this program; then no
            picture is written.
    """
    drawn, failed = rendered(dataset, lambda figure: {form: image(figure, form) for form in forms})
    if not drawn and not failed:
        raise NothingToDrawError(
            "nothing to draw: the dataset has no headline that varies, no penetration_resistance, "
            "no error over settings of the method, and no map of its stability"
        )
    folder.mkdir(parents=True, exist_ok=True)
    content = {
        folder / f"{dataset.attrs['study']}_{name}.{form}": picture
        for name, pictures in drawn.items()
        for form, picture in pictures.items()
    }
    for path in content:
        check_replaceable(path)
    for path, picture in content.items():
        write_own(picture, path)
    return list(content), failed


def rendered(
    dataset: xr.Dataset, render: Callable[[Figure], Rendered]
) -> tuple[dict[str, Rendered], Failures]:
    """What is made of each picture meant for a result, by name, the main one first; and errors.

    A failed case has no curve there. A picture that fails, which is an error of this program, takes
    nothing from the others.
    """
    sound = without_incomplete_curves(dataset) if "status" in dataset else dataset
    made: dict[str, Rendered] = {}
    failed: Failures = {}
    for name, (shows, figure) in PICTURES.items():
        try:
            if shows(sound):
                made[name] = render(figure(sound))
        except HarnessError:
            raise
        except Exception as error:
            failed[name] = error
    return made, failed
