"""What the pictures of results have in common: axes, series, labels, and the image itself."""

from __future__ import annotations

import io
import itertools
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass

import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

SIZE = (6.4, 4.2)
MARKERS = "osD^v<>pX*"
FAILED = "#B00020"
"""Colour of cases that failed."""


def png(figure: Figure) -> bytes:
    """The image of a figure, cut to what is drawn."""
    image = io.BytesIO()
    figure.savefig(image, format="png", bbox_inches="tight")
    return image.getvalue()


def empty_figure() -> tuple[Figure, Axes]:
    """A figure with one pair of axes."""
    figure = Figure(figsize=SIZE, dpi=200)
    axes = figure.add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", lw=0.6)
    axes.set_axisbelow(True)
    return figure, axes


def series_of(dataset: xr.Dataset, dims: Iterable[Hashable]) -> list[tuple[str, xr.Dataset]]:
    """One dataset for each combination of values along `dims`, and what to call it."""
    indices = itertools.product(*([(dim, i) for i in range(dataset.sizes[dim])] for dim in dims))
    ones = ((index, dataset.isel(dict(index))) for index in indices)
    return [
        (", ".join(_named_value(one, dim) for dim, _ in index) or "computed", one)
        for index, one in ones
    ]


def series_colour(index: int, count: int) -> str:
    """Colour of one of so many series; black where it is alone."""
    if count == 1:
        return "black"
    return to_hex(colormaps["viridis"](0.75 * index / (count - 1)))


@dataclass(frozen=True)
class CurveEnd:
    """The last point of a curve, and what to write there."""

    x: float
    y: float
    label: str
    colour: str


def label_ends(axes: Axes, ends: Iterable[CurveEnd]) -> None:
    """Write each curve's label right of the axes, spread where they would overlap."""
    low, high = axes.get_ylim()
    ordered = sorted(ends, key=lambda end: end.y)
    places = _spread([(end.y - low) / (high - low) for end in ordered])
    for end, place in zip(ordered, places, strict=True):
        leader = {"arrowstyle": "-", "color": end.colour, "lw": 0.5, "relpos": (0, 0.5)}
        axes.annotate(
            end.label,
            xy=(end.x, end.y),
            xytext=(1.04, place),
            textcoords="axes fraction",
            color=end.colour,
            fontsize=8,
            va="center",
            arrowprops=leader,
        )


def _spread(heights: Sequence[float]) -> list[float]:
    """Ascending `heights` within 0 to 1, pushed apart to a readable distance."""
    gap = min(0.05, 1 / max(len(heights), 1))
    places = list(heights)
    for _ in range(200):
        for i in range(len(places) - 1):
            overlap = max(0.0, gap - (places[i + 1] - places[i]))
            places[i] -= overlap / 2
            places[i + 1] += overlap / 2
    return places


def axis_label(variable: xr.DataArray) -> str:
    """Long name and unit for an axis."""
    unit = variable.attrs.get("units", "1")
    name = variable.attrs.get("long_name", str(variable.name).replace("_", " "))
    return f"{name} [{'-' if unit == '1' else unit}]"


def fixed_note(dataset: xr.Dataset) -> str:
    """The parameters that matter most, where the study keeps them fixed."""
    names = ("rigidity_index", "adhesion_factor", "material", "poissons_ratio")
    return ", ".join(
        _named_value(dataset, name) for name in names if name in dataset and not dataset[name].dims
    )


def _named_value(dataset: xr.Dataset, name: Hashable) -> str:
    value = dataset[name].item()
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{str(name).replace('_', ' ')} {text}"
