"""What pictures have in common: axes, series, labels and files."""

import functools
import io
import itertools
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cbook import is_math_text
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from matplotlib.text import Text

from harness.archive.own_files import MAKER, write_own
from harness.pictures.drawing.quantities import IN_PLACE, SYMBOL, Floats, wrapped
from harness.pictures.drawing.style import DASHES, FAILED, MARKS, PAGE, STYLED, TALL, series_colour

_MADE_BY = {
    "png": {"Software": MAKER},
    "pdf": {"Creator": MAKER, "CreationDate": None},
    "svg": {"Creator": MAKER, "Date": None},
}

MOST_LABELS = 8
"""Largest number of curves, or points, that a picture labels."""
LABEL_LETTERS = 30
"""Number of letters in a line of the label of a curve."""
LEGEND_LINE = 0.25
"""Height of a legend of one line [inch]."""


@STYLED
def image(figure: Figure, form: str = "png", dpi: float | None = None) -> bytes:
    """The image of a figure as PNG, PDF or SVG, the same bytes each time; `dpi` is for a PNG.

    The layout of the first image stays: each run of matplotlib's would move it by a hair.
    """
    for text in figure.findobj(Text):
        text.set_parse_math(_is_valid_math(text.get_text()))
    if figure.get_layout_engine() is not None:
        figure.draw_without_rendering()
        figure.draw_without_rendering()  # labels have their places only now
        figure.set_layout_engine("none")
    content = io.BytesIO()
    figure.savefig(content, format=form, metadata=_MADE_BY[form], dpi=dpi or "figure")
    return content.getvalue()


def write_figure(figure: Figure, base: Path | str, forms: Sequence[str]) -> list[Path]:
    """Write a figure as ``<base>.<form>`` in each form; a file of another program is kept."""
    paths = [Path(f"{base}.{form}") for form in forms]
    for path, form in zip(paths, forms, strict=True):
        write_own(image(figure, form), path)
    return paths


@functools.cache
def _is_valid_math(words: str) -> bool:
    """Whether matplotlib can set the mathematics in a text; texts from files may be invalid."""
    lines = filter(is_math_text, words.splitlines())  # each is set by itself
    try:
        return all(MathTextParser("path").parse(line) for line in lines)
    except ValueError:
        return False


@STYLED
def panels(
    count: int = 1, *, by_depth: bool = False, height: float | None = None, **layout: Any
) -> tuple[Figure, list[Axes]]:
    """A figure with `count` axes side by side, by default as high [inch] as the style says."""
    figure = Figure()
    if count > 1:
        figure.set_figwidth(PAGE)
    if by_depth or height:
        figure.set_figheight(height or TALL)
    return figure, list(figure.subplots(1, count, squeeze=False, **layout)[0])


def runs(found: np.ndarray) -> list[slice]:
    """The slices in which all values are true, one for each run of neighbours."""
    from scipy.ndimage import find_objects, label

    return [run for (run,) in find_objects(label(found)[0])]


def draw_values(
    axes: Axes,
    at: Floats,
    values: Floats,
    half_widths: Floats | None = None,
    *,
    of_rows: bool = False,
    **style: Any,
) -> None:
    """Draw values with their half widths at places of an axis, or in rows.

    A value that is missing has a cross on the axis itself, where none could be taken for a value.
    """
    if of_rows:
        axes.errorbar(values, at, xerr=half_widths, **style)
    else:
        axes.errorbar(at, values, half_widths, **style)
    failed = at[~np.isfinite(values)]
    if failed.size:
        on_axis = np.zeros(failed.shape)
        axes.plot(
            *((on_axis, failed) if of_rows else (failed, on_axis)),
            "x",
            color=FAILED,
            transform=axes.get_yaxis_transform() if of_rows else axes.get_xaxis_transform(),
            label=once(axes, "not completed"),
            clip_on=False,
            zorder=5,
        )


def once(axes: Axes, label: str) -> str:
    """`label` if the legend does not have it yet, otherwise ""."""
    return "" if label in axes.get_legend_handles_labels()[1] else label


def chosen(count: int, most: int) -> list[int]:
    """Up to `most` of `count` indices, evenly spread from the first to the last."""
    return sorted({round(it) for it in np.linspace(0, count - 1, min(count, most)).tolist()})


Thing = TypeVar("Thing")


class Series(NamedTuple):
    """The index of a thing that is drawn, and its style."""

    place: int
    colour: str
    marker: str
    dashes: str

    @property
    def style(self) -> dict[str, Any]:
        """Colour and marker, as matplotlib calls them."""
        return {"color": self.colour, "marker": self.marker}

    @property
    def line(self) -> dict[str, Any]:
        """Colour and dashes of a line without marks, as matplotlib calls them."""
        return {"color": self.colour, "ls": self.dashes}


def series(things: Iterable[Thing], most: int | None = MOST_LABELS) -> list[tuple[Thing, Series]]:
    """Up to `most` of the things, evenly spread, or all for None, each with its style."""
    every = list(things)
    shown = chosen(len(every), most or len(every))
    looks = zip(itertools.cycle(MARKS), itertools.cycle(DASHES))
    return [
        (every[place], Series(place, series_colour(rank, len(shown)), *look))
        for (rank, place), look in zip(enumerate(shown), looks, strict=False)
    ]


class CurveEnd(NamedTuple):
    """The last point of a curve, and its label."""

    x: float
    y: float
    label: str
    colour: str


def end_of(x: Floats, y: Floats, label: str, colour: str) -> list[CurveEnd]:
    """The last point of a curve that has a value, if any."""
    return [
        CurveEnd(x[last], y[last], label, colour) for last in np.flatnonzero(np.isfinite(y))[-1:]
    ]


def label_ends(axes: Axes, ends: Iterable[CurveEnd]) -> None:
    """Write labels right of the axes, as near to the ends of their curves as possible.

    Their lines have up to 30 letters, and are 0.06 of the axes' height apart, or less if there are
    too many.
    """
    from scipy.optimize import isotonic_regression

    wrap = functools.partial(wrapped, letters=LABEL_LETTERS)
    ordered = sorted((end._replace(label=wrap(end.label)) for end in ends), key=lambda end: end.y)
    if not ordered:
        return
    low, high = axes.get_ylim()
    heights = [(end.y - low) / (high - low) for end in ordered]
    lines = np.array([end.label.count("\n") + 1.0 for end in ordered])
    steps = min(0.06, 1.0 / lines.sum()) * (np.cumsum(lines) - 0.5 * (lines + lines[0]))
    # After subtraction of these steps the heights only have to be non-decreasing.
    places = np.clip(isotonic_regression(heights - steps).x, 0.0, 1.0 - steps[-1]) + steps
    for end, place in zip(ordered, places, strict=True):
        leader = {"arrowstyle": "-", "color": end.colour, "relpos": (0, 0.5)}
        axes.annotate(
            end.label,
            xy=(end.x, end.y),
            xytext=(1.03, place),
            textcoords="axes fraction",
            va="center",
            arrowprops=leader,
        )


def legend_above(figure: Figure, axes: Axes) -> None:
    """A legend above the axes, no wider than the page; long labels are wrapped.

    The figure becomes higher by the lines of the legend after the first.
    """
    handles, labels = axes.get_legend_handles_labels()
    if not handles:
        return
    share = 1.0
    for columns in range(min(len(handles), 4), 0, -1):
        share = _legend_share(figure, handles, labels, columns)
        if share <= 0.95:
            break
    else:
        longest = max(len(SYMBOL.sub(IN_PLACE, label)) for label in labels)
        lines = [wrapped(label, int(0.9 * longest / share)) for label in labels]
        _legend_share(figure, handles, lines, 1)
    (legend,) = figure.legends
    more = legend.get_window_extent().height / figure.dpi - LEGEND_LINE
    figure.set_figheight(figure.get_figheight() + max(0.0, more))


def _legend_share(
    figure: Figure, handles: Sequence[Artist], labels: Sequence[str], columns: int
) -> float:
    """Place the only legend of a figure; its width over that of the page."""
    for before in figure.legends:
        before.remove()
    legend = figure.legend(
        handles, labels, loc="outside upper left", ncols=columns, alignment="left"
    )
    return float(legend.get_window_extent().width / figure.bbox.width)
