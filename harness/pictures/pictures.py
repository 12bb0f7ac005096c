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
from harness.pictures.case_curves import cycles_figure, element_tests_figure, resistance_figure
from harness.pictures.cases import cases_figure, scenes_figure, spread_figure
from harness.pictures.convergence import convergence_figure
from harness.pictures.curve import curve_figure, map_figure
from harness.pictures.drawing.plot_parts import check_replaceable, image, write_own
from harness.pictures.effects import effects_figure, tornado_figure
from harness.pictures.sounding import sounding_figure
from harness.pictures.stability import stability_figure
from harness.pictures.work_precision import study_figure

PICTURES: dict[str, Callable[[xr.Dataset], Figure | None]] = {
    "curve": curve_figure,
    "map": map_figure,
    "tornado": tornado_figure,
    "convergence": convergence_figure,
    "cycles": cycles_figure,
    "element_tests": element_tests_figure,
    "spread": spread_figure,
    "effects": effects_figure,
    "cases": cases_figure,
    "scenes": scenes_figure,
    "work_precision": study_figure,
    "resistance": resistance_figure,
    "stability": stability_figure,
    "sounding": sounding_figure,
}
"""By name, the main ones first; a picture is None for a result that it is not meant for."""


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
    sound = without_incomplete_curves(dataset)
    made: dict[str, Rendered] = {}
    failed: Failures = {}
    for name, picture in PICTURES.items():
        try:
            if (figure := picture(sound)) is not None:
                made[name] = render(figure)
        except HarnessError:
            raise
        except Exception as error:
            failed[name] = error
    return made, failed
