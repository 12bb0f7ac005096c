"""What pictures have in common: style, axes, series, labels, and the files that they go to."""

import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from matplotlib import colormaps, style
from matplotlib.axes import Axes
from matplotlib.cbook import is_math_text
from matplotlib.colors import ListedColormap, to_hex
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text

from harness.archive.atomic_files import write_whole
from harness.errors import HarnessError
from harness.pictures.drawing.quantities import Floats

MAKER = "mpm_warp harness"
"""Stands in every picture and page: by it a file is known to be one of the harness."""
SEARCHED = 1 << 20
"""Bytes at the beginning and at the end of a file in which it is looked for."""


class NotOwnFileError(HarnessError):
    """A file is in the way that the harness has not written; the message is one line."""


def not_own(path: Path) -> NotOwnFileError:
    """The refusal to overwrite a file of another program."""
    return NotOwnFileError(
        f"{path}: was not written by this program and will not be overwritten; move it away, or "
        "write to another place"
    )


def check_replaceable(path: Path, mark: str = MAKER) -> None:
    """Refuse to write a file that is there already and was not written by the harness.

    `mark` is a text that stands in every such file.
    """
    if not path.exists() and not path.is_symlink():
        return
    if not path.is_file():
        raise NotOwnFileError(f"{path}: is in the way and is no file; move it away")
    with path.open("rb") as file:
        content = file.read(SEARCHED)
        file.seek(max(0, path.stat().st_size - SEARCHED))
        content += file.read()
    if mark.encode() not in content:
        raise not_own(path)


def write_own(content: bytes, path: Path) -> None:
    """Write a file that holds `MAKER`, whole or not at all."""
    assert MAKER.encode() in content, "the file would not be known again"
    check_replaceable(path)
    write_whole(content, path)


STYLED = style.context(Path(__file__).with_name("style.mplstyle"))
"""Decorator of whatever makes a figure or its image: the style of all pictures."""
_MADE_BY = {
    "png": {"Software": MAKER},
    "pdf": {"Creator": MAKER, "CreationDate": None},
    "svg": {"Creator": MAKER, "Date": None},
}

KILO = 1e3
MARKERS = "osD^v<>p"
"""Of series, which differ in grey too."""
MOST_LABELS = 8
"""Curves, or points, that a picture labels."""
FAILED = "#B00020"
"""Colour of cases that failed."""
SHADES = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.85, 256)))
"""Colours of a scale, by luminance; the lightest can still be seen on paper."""
INK, ACCENT, LIGHT = "black", "#0072B2", "#E69F00"
"""Colours of one series alone, of a second and a third: they differ in grey."""


@STYLED
def image(figure: Figure, form: str = "png", dpi: float | None = None) -> bytes:
    """The image of a figure as PNG, PDF or SVG, the same bytes each time; `dpi` is of a PNG."""
    for text in figure.findobj(Text):
        text.set_parse_math(_is_set(text.get_text()))
    content = io.BytesIO()
    figure.savefig(content, format=form, metadata=_MADE_BY[form], dpi=dpi or "figure")
    return content.getvalue()


def _is_set(words: str) -> bool:
    """Whether mathematics in a text can be set; in what a file says it may be none."""
    try:
        return not is_math_text(words) or bool(MathTextParser("path").parse(words))
    except ValueError:
        return False


@STYLED
def panels(count: int = 1, height: float | None = None, **layout: Any) -> tuple[Figure, list[Axes]]:
    """A figure with so many pairs of axes side by side, by default as high [inch] as the style."""
    figure = Figure()
    figure.set_figheight(height or figure.get_figheight())
    return figure, list(figure.subplots(1, count, squeeze=False, **layout)[0])


def series_colour(index: int, count: int) -> str:
    """Colour of one of so many series, by luminance; black where it is alone."""
    return INK if count == 1 else shade(index / (count - 1))


def shade(fraction: float) -> str:
    """Colour of a number on the scale `SHADES`, from 0 to 1."""
    return to_hex(SHADES(fraction))


def runs(found: np.ndarray) -> list[slice]:
    """Where neighbours are all true, one slice each."""
    from scipy.ndimage import find_objects, label

    return [run for (run,) in find_objects(label(found)[0])]


def mark_failures(axes: Axes, positions: Floats, height: float = 0.03) -> None:
    """Mark cases without a value at a height of the axes, from 0 to 1, not to leave them out."""
    if positions.size:
        axes.plot(
            positions,
            np.full(positions.shape, height),
            "x",
            color=FAILED,
            transform=axes.get_xaxis_transform(),
            label=once(axes, "not completed"),
            clip_on=False,
        )


def once(axes: Axes, label: str) -> str:
    """`label` if the legend does not have it yet, else none."""
    return "" if label in axes.get_legend_handles_labels()[1] else label


def chosen(count: int, most: int) -> list[int]:
    """Up to `most` of `count` places, evenly spread, the first and the last among them."""
    return sorted({round(it) for it in np.linspace(0, count - 1, min(count, most)).tolist()})


Thing = TypeVar("Thing")


class Series(NamedTuple):
    """Which of many things is drawn, and how."""

    place: int
    colour: str
    marker: str
    label: str = ""

    @property
    def style(self) -> dict[str, Any]:
        """Colour and marker, as matplotlib calls them."""
        return {"color": self.colour, "marker": self.marker}


def series(things: Iterable[Thing], most: int | None = MOST_LABELS) -> list[tuple[Thing, Series]]:
    """Up to `most` of the things that are drawn side by side, evenly spread; None: all of them."""
    every = list(things)
    shown = chosen(len(every), most or len(every))
    return [
        (every[place], Series(place, series_colour(rank, len(shown)), MARKERS[rank % len(MARKERS)]))
        for rank, place in enumerate(shown)
    ]


class CurveEnd(NamedTuple):
    """The last point of a curve, and what to write there."""

    x: float
    y: float
    label: str
    colour: str


def end_of(x: Floats, y: Floats, label: str, colour: str) -> list[CurveEnd]:
    """The end of a curve that has a value; else none."""
    return [
        CurveEnd(x[last], y[last], label, colour) for last in np.flatnonzero(np.isfinite(y))[-1:]
    ]


def label_ends(axes: Axes, ends: Iterable[CurveEnd], size: float = 8) -> None:
    """Write each curve's label right of the axes, as near to its end as those of others allow.

    They are 0.06 of the axes' height apart, or less where there are too many.
    """
    from scipy.optimize import isotonic_regression

    ordered = sorted(ends, key=lambda end: end.y)
    if not ordered:
        return
    low, high = axes.get_ylim()
    heights = [(end.y - low) / (high - low) for end in ordered]
    steps = min(0.06, 1.0 / len(ordered)) * np.arange(len(ordered))
    # Less these steps the places only have to rise.
    places = np.clip(isotonic_regression(heights - steps).x, 0.0, 1.0 - steps[-1]) + steps
    for end, place in zip(ordered, places, strict=True):
        leader = {"arrowstyle": "-", "color": end.colour, "lw": 0.5, "relpos": (0, 0.5)}
        axes.annotate(
            end.label,
            xy=(end.x, end.y),
            xytext=(1.03, place),
            textcoords="axes fraction",
            color=end.colour,
            fontsize=size,
            va="center",
            arrowprops=leader,
        )


def legend_above(figure: Figure, axes: Axes) -> None:
    """A legend above the axes, no wider than the page."""
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    for columns in range(min(len(handles), 4), 0, -1):
        for before in figure.legends:
            before.remove()
        legend = figure.legend(
            handles, labels, loc="outside upper left", ncols=columns, alignment="left"
        )
        if legend.get_window_extent().width <= 0.98 * figure.bbox.width:
            break
