"""The pictures of a study's result, made for print and for colour-blind readers.

Figures are matplotlib objects without a display or global state. Each picture has a function that
returns None for results that it does not fit; the functions are listed here.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

import xarray as xr
from matplotlib.figure import Figure

from harness.archive.conventions import without_incomplete_curves
from harness.archive.own_files import check_replaceable, write_own
from harness.errors import HarnessError
from harness.pictures.cases import cases_figure, scenes_figure
from harness.pictures.curve import curve_figure
from harness.pictures.curves import curves_figure
from harness.pictures.declared import declared
from harness.pictures.drawing.caption import MISSING_NUMBERS
from harness.pictures.drawing.plot_parts import image
from harness.pictures.effects import effects_figure, tornado_figure
from harness.pictures.map import map_figure
from harness.pictures.method.convergence import convergence_figure
from harness.pictures.method.stability import stability_figure
from harness.pictures.method.work_precision import study_figure
from harness.pictures.spread import spread_figure

Picture = Callable[[xr.Dataset], Figure | None]
PICTURES: dict[str, Picture] = {
    "curve": curve_figure,
    "map": map_figure,
    "tornado": tornado_figure,
    "convergence": convergence_figure,
    "spread": spread_figure,
    "effects": effects_figure,
    "cases": cases_figure,
    "scenes": scenes_figure,
    "work_precision": study_figure,
    "stability": stability_figure,
}
"""Functions that draw the pictures of all results, by name, main ones first. None means that a
result has no such picture. The pictures of curves follow: results declare them themselves."""


class NothingToDrawError(HarnessError):
    """No picture fits the dataset."""


GREATEST = 1e100
"""Numbers of this size and more are not drawn: the range of an axis would overflow."""
Rendered = TypeVar("Rendered")
Failures = dict[str, Exception]
"""Errors of the program while drawing, by name of the picture."""


def draw(
    dataset: xr.Dataset, folder: Path, forms: Sequence[str] = ("png",)
) -> tuple[list[Path], Failures]:
    """Write the pictures that fit a study's result as ``<study>_<name>.<format>``.

    Returned are their paths, and the errors of pictures that could not be drawn. If a file of such
    a name was not written by this program, no picture is written.
    """
    drawn, failed = rendered(dataset, lambda figure: {form: image(figure, form) for form in forms})
    if not drawn and not failed:
        raise NothingToDrawError(
            "nothing to draw: the dataset has no headline that varies, no error over settings of "
            "the method, no map of its stability, and no curve that says where it is drawn; if it "
            "is older than that, `harness run STUDY --fresh` makes it anew"
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


def _drawable(dataset: xr.Dataset) -> xr.Dataset:
    """A result without numbers beyond `GREATEST`; captions say that they are missing."""
    beyond = {
        name: variable.where(abs(variable) < GREATEST)
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind == "f" and (abs(variable) >= GREATEST).any()
    }
    told = f"Numbers of {GREATEST:g} and more are not drawn." if beyond else ""
    return dataset.assign(beyond).assign_attrs({MISSING_NUMBERS: told})


def _pictures_of(dataset: xr.Dataset) -> dict[str, Picture]:
    """`PICTURES`, and those of the curves that the result declares."""
    curves = declared(dataset)
    if taken := PICTURES.keys() & curves:
        raise HarnessError(
            f"picture {min(taken)}: the harness has one of this name; call that of the curve "
            f"{curves[min(taken)][0]} otherwise"
        )
    return PICTURES | {name: partial(curves_figure, names=own) for name, own in curves.items()}


def rendered(
    dataset: xr.Dataset, render: Callable[[Figure], Rendered]
) -> tuple[dict[str, Rendered], Failures]:
    """Apply `render` to each picture that fits a result, without curves of incomplete cases.

    Returned are the rendered pictures by name, main ones first, and the errors of the others.
    """
    sound = _drawable(without_incomplete_curves(dataset))
    made: dict[str, Rendered] = {}
    failed: Failures = {}
    for name, picture in _pictures_of(sound).items():
        try:
            if (figure := picture(sound)) is not None:
                made[name] = render(figure)
        except HarnessError:
            raise
        except Exception as error:
            failed[name] = error
    return made, failed
