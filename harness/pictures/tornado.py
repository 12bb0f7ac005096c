"""The picture `tornado`: the effect of each parameter that is changed alone."""

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
from harness.pictures.drawing.plot_parts import ACCENT, INK, LIGHT, STYLED, labelled_rows
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

MOST_BARS, ROW_HEIGHT = 20, 0.3
"""Largest number of bars, and height of the row of one [inch]."""


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
    names = [f"{named(dataset, bar.values.name)} ({bar.text(studied, 0)})" for bar in shown]
    figure, axes = labelled_rows(names, ROW_HEIGHT)
    start = float(studied.computed[0])
    axes.axvline(start, color=INK, lw=1)
    for place, bar in enumerate(shown):
        _draw_bar(axes, studied, bar, place)
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
