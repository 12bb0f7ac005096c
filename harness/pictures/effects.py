"""The pictures `tornado`, the effect of each parameter alone, and `effects`, from a fit."""

import math
import textwrap
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from harness.archive.conventions import MISSING, over_cases
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import (
    ACCENT,
    INK,
    LIGHT,
    MOST_LABELS,
    STYLED,
    mark_failures,
    panels,
)
from harness.pictures.drawing.quantities import (
    Floats,
    Values,
    axis_label,
    named,
    number,
    plain,
    quantity,
    symbol,
    unit_of,
)
from harness.pictures.studied import Studied, changing

LEAST_PARAMETERS = 3
COLUMNS = 3
MOST_BARS = 20


def much_varied(dataset: xr.Dataset) -> Studied | None:
    """The result of a study with three or more varied parameters, or random ones; else None."""
    studied = Studied.of(dataset)
    if studied is None or studied.is_one_at_a_time:
        return None
    least = LEAST_PARAMETERS if studied.is_combined else 1
    varies = len(studied.varied) >= least
    return studied if varies and np.isfinite(studied.computed).sum() >= LEAST_PARAMETERS else None


def has_few_cases(studied: Studied) -> bool:
    """Whether there are at most 20 cases, and too few for a fit."""
    return studied.computed.size <= 20 and not _effects(studied).is_fitted


class _Effects(NamedTuple):
    """A fit of the headline by a sum of functions of one parameter each."""

    parts: dict[str, Floats]  # by parameter; each has the mean 0 over completed cases
    mean: float  # of the headline over completed cases
    residual: Floats  # NaN for a case that did not complete
    is_fitted: bool  # whether there were enough cases for a fit; if not, the parts are 0

    @property
    def spread(self) -> float:
        """Standard deviation of the residual."""
        return float(np.nanstd(self.residual))


def _effects(studied: Studied) -> _Effects:
    """Fit the headline by least squares.

    A number, or its logarithm on a logarithmic axis, contributes a parabola, or a straight line if
    there are fewer than two cases for each coefficient. A category contributes a constant.
    """
    sound = np.isfinite(studied.computed)
    values = studied.computed[sound]
    mean = float(values.mean())
    for degree in (2, 1):
        columns = [_columns(parameter, sound, degree) for parameter in studied.varied.values()]
        matrix = np.hstack(columns)
        is_fitted = bool(sound.sum() >= 2 * (matrix.shape[1] + 1))
        if is_fitted:
            break
    found = np.linalg.lstsq(matrix[sound], values - mean)[0] if is_fitted else 0.0 * matrix[0]
    ends = np.cumsum([column.shape[1] for column in columns])[:-1]
    parts = list(map(np.matmul, columns, np.split(found, ends)))
    residual = np.where(sound, studied.computed - (mean + np.sum(parts, axis=0)), np.nan)
    return _Effects(dict(zip(studied.varied, parts, strict=True)), mean, residual, is_fitted)


def _columns(values: Values, sound: np.ndarray, degree: int) -> Floats:
    """The terms of the fit, shape [case, :]; their mean over completed cases is 0."""
    if values.categories:
        columns = (values.numbers[:, None] == np.arange(1, len(values.categories))).astype(float)
    else:
        place = np.log(values.numbers) if values.scale == "log" else values.numbers
        place = (place - place.min()) / np.ptp(place)
        columns = place[:, None] ** np.arange(1, 1 + min(degree, values.different.size - 1))
    centred: Floats = columns - columns[sound].mean(axis=0)
    return centred


@STYLED
def effects_figure(dataset: xr.Dataset) -> Figure | None:
    """A panel for each parameter, largest effect first, with the effect of all others removed."""
    studied = much_varied(dataset)
    if studied is None or has_few_cases(studied):
        return None
    found = _effects(studied)
    sound = np.isfinite(found.residual)
    strength = {name: np.ptp(part[sound]) for name, part in found.parts.items()}
    names = sorted(strength, key=lambda name: strength[name], reverse=True)[:MOST_LABELS]
    row_count = math.ceil(len(names) / COLUMNS)
    figure = Figure()
    figure.set_figheight(1.75 * row_count + 0.9)
    grid = figure.subplots(row_count, COLUMNS, squeeze=False, sharey=True)
    for axes in grid.flat[len(names) :]:
        axes.remove()
    for axes, name in zip(grid.flat, names, strict=False):
        _draw_panel(axes, studied, found, name)
    label = axis_label(dataset, studied.headline)
    figure.supylabel(textwrap.fill(label, 24 + 16 * (row_count - 1)), fontsize=9)
    failed, total = int((~sound).sum()), float(np.nanstd(studied.computed))
    explained = 1.0 - (found.spread / total) ** 2 if total > 0.0 else 1.0
    return captioned(
        figure,
        dataset,
        f"{sound.sum()} cases{f'; {failed} did not complete (crosses)' if failed else ''}.",
        "Each dot is a case, less the effects of all other parameters; the line is this "
        "parameter's effect, a parabola by least squares. The band is the standard deviation of "
        f"the residual, {found.spread:.2g}; the fit explains {explained:.0%} of the variance."
        if found.is_fitted
        else "Each dot is a case as it was computed: there are too few for a fit.",
        studied.bars,
        f"Of {len(studied.varied)} parameters the {len(names)} with most effect are shown."
        if len(studied.varied) > len(names)
        else "",
    )


def _draw_panel(axes: Axes, studied: Studied, found: _Effects, name: str) -> None:
    values = studied.varied[name]
    effect = found.mean + found.parts[name]
    sound = np.isfinite(found.residual)
    order = np.argsort(values.numbers, kind="stable")
    x = values.numbers[order]
    size = max(1.5, 4.0 - 0.005 * x.size)
    axes.errorbar(
        values.numbers[sound],
        (effect + found.residual)[sound],
        studied.widths(sound),
        fmt="o",
        ms=size,
        color="0.65",
        elinewidth=0.6,
        capsize=0,
        zorder=1,
    )
    if found.is_fitted:
        low, high = (effect[order] + side * found.spread for side in (-1, 1))
        line, marker = ("", "_") if values.categories else ("-", "")
        axes.fill_between(x, low, high, color=ACCENT, alpha=0.3, lw=0, zorder=2)
        axes.plot(x, effect[order], color=ACCENT, ls=line, marker=marker, zorder=3)
    mark_failures(axes, values.numbers[~sound])
    values.dress(axes, room=5)
    axes.set_xlabel(axis_label(studied.dataset, name), fontsize=8)
    axes.tick_params(labelsize=7)


class _Bar(NamedTuple):
    """The effect of one parameter: the cases that change it, and their changes of the headline."""

    values: Values
    cases: np.ndarray
    change: Floats

    def text(self, studied: Studied, case: int) -> str:
        return quantity(self.values.of_case(case), unit_of(studied.dataset, self.values.name))

    @property
    def reach(self) -> float:
        """Range of the headline in these cases and the first one."""
        return float(np.ptp(np.nan_to_num([0.0, *self.change])))

    def extreme(self, side: int) -> int | None:
        """The completed case of greatest change with a value below (-1) or above (1) the start."""
        numbers = self.values.numbers
        beyond = side * (numbers[self.cases] - numbers[0]) > 0.0
        places = np.flatnonzero(beyond & np.isfinite(self.change))
        return int(places[np.argmax(np.abs(self.change[places]))]) if places.size else None


def _bars(studied: Studied) -> list[_Bar]:
    ran = over_cases(studied.dataset, "status") != MISSING
    varied = list(studied.varied.values())
    found = []
    for values, changed in zip(varied, changing(studied.dataset, varied), strict=True):
        own = np.flatnonzero(ran & changed)
        found.append(_Bar(values, own, studied.computed[own] - studied.computed[0]))
    return sorted(found, key=lambda bar: bar.reach, reverse=True)


@STYLED
def tornado_figure(dataset: xr.Dataset) -> Figure | None:
    """A bar for each parameter: its largest changes of the headline from the first case."""
    studied = Studied.of(dataset)
    if studied is None or not studied.is_one_at_a_time or not np.isfinite(studied.computed[0]):
        return None
    bars = _bars(studied)
    if not any(bar.reach > 0.0 for bar in bars):
        return None
    shown = bars[:MOST_BARS]
    figure, (axes,) = panels(height=0.3 * len(shown) + 1.6)
    start = float(studied.computed[0])
    axes.axvline(start, color=INK, lw=1)
    for place, bar in enumerate(shown):
        _draw_bar(axes, studied, bar, place)
    names = [f"{named(dataset, bar.values.name)} ({bar.text(studied, 0)})" for bar in shown]
    axes.set_yticks(range(len(shown)), names, fontsize=7)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    axes.margins(x=0.12)
    label = axis_label(dataset, studied.headline)  # long names of parameters leave little room
    axes.set_xlabel(textwrap.fill(label, 40, break_long_words=False))
    handles = [
        Patch(color=LIGHT, label="value below the start"),
        Patch(color=ACCENT, label="value above it, or another choice"),
        Line2D([], [], color=INK, lw=1, label=f"start: {number(start)}"),
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=3)
    rest = len(bars) - len(shown)
    return captioned(
        figure,
        dataset,
        "Each case differs from the start in one parameter. In brackets: the parameter's value at "
        "the start; at the ends of bars: its value in the case with this result.",
        f"{rest} more parameters change the result less." if rest else "",
        _failures(bars),
        studied.bars,
    )


def _draw_bar(axes: Axes, studied: Studied, bar: _Bar, place: int) -> None:
    """Draw values below the start in the upper half of the row, others in the lower half."""
    start = float(studied.computed[0])
    for side, colour in ((-1, LIGHT), (1, ACCENT)):
        extreme = bar.extreme(side)
        if extreme is None:
            continue
        case, change, height = int(bar.cases[extreme]), bar.change[extreme], place + 0.2 * side
        width = studied.widths(case)
        axes.barh(height, change, 0.36, left=start, color=colour, xerr=width, ecolor="0.3")
        outward = -1.0 if change < 0.0 else 1.0
        beyond = 0.0 if width is None else np.nan_to_num(width)
        axes.annotate(
            bar.text(studied, case),
            (start + change + outward * beyond, height),
            xytext=(3 * outward, 0),
            textcoords="offset points",
            ha="right" if outward < 0.0 else "left",
            va="center",
            fontsize=6,
        )


def _failures(bars: Sequence[_Bar]) -> str:
    """A sentence on the values with which cases did not complete."""
    failures = []
    for values, cases, change in bars:
        failed = values.numbers[cases[~np.isfinite(change)]]
        if failed.size:
            texts = ", ".join(plain(values.text(float(number))) for number in failed)
            failures.append(f"{symbol(values.name) or plain(values.label)} = {texts}")
    return f"Not completed: {'; '.join(failures)}." if failures else ""
