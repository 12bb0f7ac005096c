"""The picture of cone factors: computed ones as points, the literature's as curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, LogLocator, NullLocator, StrMethodFormatter

from harness.archive.conventions import varied_names
from harness.compare.cone_factors import conditions_of, stored_references
from harness.pictures.experience_band import draw_experience
from harness.pictures.plot_parts import (
    FAILED,
    MARKERS,
    CurveEnd,
    axis_label,
    empty_figure,
    fixed_note,
    label_ends,
    series_colour,
    series_of,
)
from harness.references.cone_factors import (
    COMPARED,
    CONE_FACTORS,
    Quantity,
    envelope,
    envelope_applies,
)

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#8C564B", "#666666")
"""Okabe and Ito's colours, which colour-blind readers can tell apart; one for each reference."""

ENVELOPE_LABEL = "envelope of the literature (no confidence interval)"
MOST_COLUMNS = 3
"""Columns of a legend."""
FINE = 400
"""Points of a literature curve."""


def shows_cone_factor(dataset: xr.Dataset) -> bool:
    """Whether a result holds cone factors."""
    return COMPARED in dataset


def cone_factor_figure(dataset: xr.Dataset) -> Figure:
    """Computed cone factors over the first varied number, with the literature's beside them.

    A second varied parameter, and any further one, makes series. The literature's curves are
    solid where they apply and dashed outside; where they depend on what makes the series, they
    take its colour. Cases that form no grid are points without the literature's curves, each of
    which would hold for one of them.
    """
    dataset = dataset.sortby(list(dataset[COMPARED].dims))
    computed = dataset[COMPARED]
    abscissa = _Abscissa.of(dataset)
    figure, axes = empty_figure()
    draw_experience(axes, dataset)
    if computed.dims == ("case",):
        axes.plot(abscissa.positions, computed, "o", color="black", label="computed", markersize=4)
        _mark_failures(axes, abscissa.positions[~np.isfinite(computed.values)])
        abscissa.dress(axes)
        axes.set_ylabel(axis_label(computed))
        _legend(axes, fixed_note(dataset))
        return figure
    series = series_of(dataset, [dim for dim in computed.dims if dim != abscissa.name])
    conditions = vars(conditions_of(dataset)).values()
    shared = not any(set(c.dims) & set(computed.dims) - {abscissa.name} for c in conditions)
    ends: list[CurveEnd] = []
    for index, (label, one) in enumerate(series):
        colour, marker = series_colour(index, len(series)), MARKERS[index % len(MARKERS)]
        if index == 0 or not shared:
            ends += _draw_literature(axes, one, abscissa, None if shared else colour)
        values = np.atleast_1d(one[COMPARED])
        line = "" if abscissa.categories else "-" if len(series) > 1 else ":"
        (points,) = axes.plot(abscissa.positions, values, color=colour, ls=line, lw=1, zorder=4)
        points.set(marker=marker, markersize=6, label=label)
        _mark_failures(axes, abscissa.positions[~np.isfinite(values)])
    abscissa.dress(axes)
    axes.set_ylabel(axis_label(computed))
    label_ends(axes, ends)
    _legend(axes, fixed_note(dataset))
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
            return cls(name, axis_label(dataset[name]), values.astype(float))
        label = axis_label(dataset[name]).removesuffix(" [-]")
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


def _draw_literature(
    axes: Axes, dataset: xr.Dataset, abscissa: _Abscissa, colour: str | None
) -> list[CurveEnd]:
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
        ends.append(CurveEnd(x[-1], value[-1], reference.label, own))
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


def _legend(axes: Axes, title: str) -> None:
    """Above the axes, where it hides no data; no wider than they are, as the labels beside rise."""
    for column_count in range(MOST_COLUMNS, 0, -1):
        legend = axes.legend(
            title=title or None,
            loc="lower left",
            bbox_to_anchor=(0, 1),
            ncols=column_count,
            fontsize=8,
            title_fontsize=8,
            alignment="left",
            frameon=False,
        )
        if legend.get_window_extent().width <= axes.get_window_extent().width:
            break
