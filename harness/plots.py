"""Pictures of a study's result, for print and for colour-blind readers.

Figures are made with matplotlib's objects alone: no display, no global state.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullLocator, StrMethodFormatter

from harness import HarnessError
from harness.compare import conditions_of, stored_references, varied_names
from harness.references.cone_factors import CONE_FACTORS, Quantity, envelope, envelope_applies
from harness.stability import shows_stability
from harness.stability_map import stability_figure
from harness.work_precision import has_work_precision, study_figure

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C564B", "#666666")
"""Okabe and Ito's colours, which colour-blind readers can tell apart; one for each reference."""

MARKERS = "osD^v<>p"
FAILED = "#B00020"
SIZE = (6.4, 4.2)
ENVELOPE_LABEL = "envelope of the literature (no confidence interval)"
MOST_LABELS = 20
"""Curves whose labels find room beside a picture."""
FINE = 400
"""Points of a literature curve."""


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
        harness.compare.NothingToCompareError: it holds cone factors, but not their parameters.
        OSError: a file cannot be written.
    """
    shown = figures(dataset)
    if not shown:
        raise NothingToDrawError(
            "nothing to draw: the dataset has neither cone_factor nor penetration_resistance, nor "
            "an error and a run_time, nor a map of its stability"
        )
    folder.mkdir(parents=True, exist_ok=True)
    stem = folder / dataset.attrs["study"]
    return [_write(figure, Path(f"{stem}_{name}.png")) for name, figure in shown.items()]


def figures(dataset: xr.Dataset) -> dict[str, Figure]:
    """The pictures of a study's result, by name, as far as it holds what they show.

    Raises:
        harness.compare.NothingToCompareError: it holds cone factors, but not their parameters.
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


def cone_factor_figure(dataset: xr.Dataset) -> Figure:
    """Computed cone factors over the first varied number, with the literature's beside them.

    A second varied parameter, and any further one, makes series. The literature's curves are
    solid where they apply and dashed outside; where they depend on what makes the series, they
    take its colour. Cases that form no grid are points without the literature's curves, each of
    which would hold for one of them.
    """
    dataset = dataset.sortby(list(dataset["cone_factor"].dims))
    computed = dataset["cone_factor"]
    abscissa = _Abscissa.of(dataset)
    figure, axes = _figure()
    if computed.dims == ("case",):
        axes.plot(abscissa.positions, computed, "o", color="black", label="computed", markersize=4)
        _mark_failures(axes, abscissa.positions[~np.isfinite(computed.values)])
        abscissa.dress(axes)
        axes.set_ylabel(_label(computed))
        _legend(axes, _fixed(dataset))
        return figure
    series = _series(dataset, [dim for dim in computed.dims if dim != abscissa.name])
    conditions = vars(conditions_of(dataset)).values()
    shared = not any(set(c.dims) & set(computed.dims) - {abscissa.name} for c in conditions)
    ends: list[_CurveEnd] = []
    for index, (label, one) in enumerate(series):
        colour, marker = _colour(index, len(series)), MARKERS[index % len(MARKERS)]
        if index == 0 or not shared:
            ends += _draw_literature(axes, one, abscissa, None if shared else colour)
        values = np.atleast_1d(one["cone_factor"])
        line = "" if abscissa.categories else "-" if len(series) > 1 else ":"
        (points,) = axes.plot(abscissa.positions, values, color=colour, ls=line, lw=1, zorder=4)
        points.set(marker=marker, markersize=6, label=label)
        _mark_failures(axes, abscissa.positions[~np.isfinite(values)])
    abscissa.dress(axes)
    axes.set_ylabel(_label(computed))
    _label_ends(axes, ends)
    _legend(axes, _fixed(dataset))
    return figure


def resistance_figure(dataset: xr.Dataset) -> Figure:
    """Penetration resistance over undrained shear strength, one curve a case."""
    resistance = dataset["penetration_resistance"] / dataset["undrained_shear_strength"]
    figure, axes = _figure()
    curves = xr.Dataset({"curve": resistance})
    series = _series(curves, [dim for dim in resistance.dims if dim != "penetration"])
    ends, failed = [], []
    for index, (label, one) in enumerate(series):
        curve = one["curve"].dropna("penetration")
        if curve.size == 0:
            failed.append(label)
            continue
        colour = _colour(index, len(series))
        axes.plot(curve["penetration"], curve, color=colour, lw=1.2, label=label)
        ends.append(_CurveEnd(float(curve["penetration"][-1]), float(curve[-1]), label, colour))
    axes.set_xlabel(_label(dataset["penetration"]))
    axes.set_ylabel("resistance / undrained shear strength [-]")
    axes.set_xlim(0, float(dataset["penetration"].max()))
    axes.set_ylim(bottom=0)
    if len(ends) <= MOST_LABELS:
        _label_ends(axes, ends)
    notes = [_fixed(dataset), *(["failed: " + "; ".join(failed)] if failed else [])]
    axes.set_title("\n".join(filter(None, notes)), loc="left", fontsize=8)
    return figure


@dataclass(frozen=True)
class _Abscissa:
    """The parameter along the horizontal axis."""

    name: str
    label: str
    positions: np.ndarray
    categories: tuple[str, ...] = ()

    @classmethod
    def of(cls, dataset: xr.Dataset) -> _Abscissa:
        varied = varied_names(dataset)
        numbers = [name for name in varied if dataset[name].dtype.kind in "iuf"]
        # A study of one case varies nothing: it is shown as a point of the adhesion's axis.
        name = (numbers or varied or ["adhesion_factor"])[0]
        values = np.atleast_1d(dataset[name].values)
        if values.dtype.kind in "iuf":
            return cls(name, _label(dataset[name]), values.astype(float))
        label = _label(dataset[name]).removesuffix(" [-]")
        return cls(name, label, np.arange(float(values.size)), tuple(map(str, values)))

    @property
    def span(self) -> tuple[float, float]:
        """Where the literature's curves begin and end."""
        low, high = self.positions.min(), self.positions.max()
        if self.categories:
            return low - 0.5, high + 0.5
        if low < high:
            return low, high
        return (0.0, 1.0) if 0 <= low <= 1 else (low / 2, low * 2)

    @property
    def logarithmic(self) -> bool:
        low, high = self.span
        decades = low > 0 and high > 10 * low
        return not self.categories and (self.name == "rigidity_index" or decades)

    def fine(self, dataset: xr.Dataset) -> xr.Dataset:
        """The parameters of `dataset` on a fine grid along this axis."""
        space = np.geomspace if self.logarithmic else np.linspace
        coarse = dataset.drop_dims(self.name, errors="ignore").drop_vars(self.name, errors="ignore")
        return coarse.assign_coords({self.name: space(*self.span, FINE)})

    def dress(self, axes: Axes) -> None:
        axes.set_xlabel(self.label)
        if self.categories:
            axes.set_xticks(self.positions, self.categories)
        if self.logarithmic:
            axes.set_xscale("log")
            few = self.positions.size <= 8
            ticks = FixedLocator(list(self.positions)) if few else LogLocator(subs=(1, 2, 5))
            axes.xaxis.set_major_locator(ticks)
            axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axes.xaxis.set_minor_locator(NullLocator())


@dataclass(frozen=True)
class _CurveEnd:
    """The last point of a curve, and what to write there."""

    x: float
    y: float
    label: str
    colour: str


def _draw_literature(
    axes: Axes, dataset: xr.Dataset, abscissa: _Abscissa, colour: str | None
) -> list[_CurveEnd]:
    """Draw the envelope and the references of one series, in `colour` or each in its own."""
    fine = abscissa.fine(dataset)
    x, conditions = fine[abscissa.name].values, conditions_of(fine)

    def along(value: Quantity) -> np.ndarray:
        return np.broadcast_to(np.asarray(value), x.shape)

    lower, upper = (along(bound) for bound in envelope(conditions))
    inside = along(envelope_applies(conditions))
    if inside.any():
        band = axes.fill_between(x, lower, upper, inside, color=colour or "0.6", alpha=0.2, lw=0)
        band.set_label(_once(axes, ENVELOPE_LABEL))
        # A band has no width where the references hold for one value alone, as of the apex angle.
        beside = np.pad(inside, 1)
        alone = inside & ~beside[:-2] & ~beside[2:]
        if alone.any():
            own = colour or "0.6"
            axes.vlines(x[alone], lower[alone], upper[alone], color=own, alpha=0.4, lw=5)
    ends = []
    for reference in stored_references(dataset):
        own = colour or COLOURS[CONE_FACTORS.index(reference) % len(COLOURS)]
        value = along(reference.evaluate(conditions))
        applies = along(reference.applies(conditions))
        axes.plot(x, np.where(applies, value, np.nan), color=own, lw=1.3)
        if not applies.all():
            label = _once(axes, "outside its validity")
            axes.plot(x, value, color=own, lw=0.9, ls=(0, (4, 3)), alpha=0.7, label=label)
        ends.append(_CurveEnd(x[-1], value[-1], reference.label, own))
    return ends


def _mark_failures(axes: Axes, positions: np.ndarray) -> None:
    # Failed cases have no value: they stand on the axis instead of going missing.
    if positions.size:
        on_axis = axes.get_xaxis_transform()
        heights = np.full(positions.shape, 0.03)
        label = _once(axes, "failed")
        axes.plot(positions, heights, "x", color=FAILED, transform=on_axis, label=label)


def _once(axes: Axes, label: str) -> str:
    """`label` if the legend does not have it yet, else none."""
    return "" if label in axes.get_legend_handles_labels()[1] else label


def _label_ends(axes: Axes, ends: Iterable[_CurveEnd]) -> None:
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


def _series(dataset: xr.Dataset, dims: Iterable[Hashable]) -> list[tuple[str, xr.Dataset]]:
    """One dataset for each combination of values along `dims`, and what to call it."""
    indices = itertools.product(*([(dim, i) for i in range(dataset.sizes[dim])] for dim in dims))
    ones = ((index, dataset.isel(dict(index))) for index in indices)
    return [
        (", ".join(_named_value(one, dim) for dim, _ in index) or "computed", one)
        for index, one in ones
    ]


def _colour(index: int, count: int) -> str:
    if count == 1:
        return "black"
    return to_hex(colormaps["viridis"](0.75 * index / (count - 1)))


def _figure() -> tuple[Figure, Axes]:
    figure = Figure(figsize=SIZE, dpi=200)
    axes = figure.add_subplot()
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", lw=0.6)
    axes.set_axisbelow(True)
    return figure, axes


def _legend(axes: Axes, title: str) -> None:
    # Above the axes, where it hides no data.
    axes.legend(
        title=title or None,
        loc="lower left",
        bbox_to_anchor=(0, 1),
        ncols=3,
        fontsize=8,
        title_fontsize=8,
        alignment="left",
        frameon=False,
    )


def _label(variable: xr.DataArray) -> str:
    """Long name and unit for an axis."""
    unit = variable.attrs.get("units", "1")
    name = variable.attrs.get("long_name", str(variable.name).replace("_", " "))
    return f"{name} [{'-' if unit == '1' else unit}]"


def _fixed(dataset: xr.Dataset) -> str:
    """The parameters that matter most, where the study keeps them fixed."""
    names = ("rigidity_index", "adhesion_factor", "material", "poissons_ratio")
    return ", ".join(
        _named_value(dataset, name) for name in names if name in dataset and not dataset[name].dims
    )


def _named_value(dataset: xr.Dataset, name: Hashable) -> str:
    value = dataset[name].item()
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return f"{str(name).replace('_', ' ')} {text}"


def _write(figure: Figure, path: Path) -> Path:
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        figure.savefig(part, format="png", bbox_inches="tight")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
    return path
