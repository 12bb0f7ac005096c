"""The picture of one parameter at a time: a tornado chart, the widest bar on top."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from harness.archive.conventions import MISSING
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import ACCENT, INK, LIGHT, STYLED
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
from harness.pictures.studied import Studied
from harness.study.designs import ONE_AT_A_TIME

MOST_ROWS = 20
ROW_HEIGHT, MARGIN = 0.3, 1.6
"""Inches of a bar, and of all around them."""


def shows_tornado(dataset: xr.Dataset) -> bool:
    """Whether a result shows what each of several parameters does alone."""
    studied = Studied.of(dataset)
    if studied is None or studied.design != ONE_AT_A_TIME or not np.isfinite(studied.computed[0]):
        return False
    return any(row.reach > 0.0 for row in _rows(studied))


@dataclass(frozen=True)
class _Row:
    """What one parameter does alone.

    Attributes:
        values: of the parameter in all cases; the first case has those of the start.
        cases: those that differ from the first in this parameter alone.
        change: of the headline in these cases, from the first one's.
    """

    values: Values
    cases: np.ndarray
    change: Floats

    @property
    def reach(self) -> float:
        """From the least headline to the greatest, that of the start among them."""
        known = self.change[np.isfinite(self.change)]
        return float(np.ptp([0.0, *known.tolist()]))

    def extreme(self, side: int) -> int | None:
        """The completed case of greatest change, with values below (-1) or above (1) the start."""
        numbers = self.values.numbers
        beyond = side * (numbers[self.cases] - numbers[0]) > 0.0
        places = np.flatnonzero(beyond & np.isfinite(self.change))
        return int(places[np.argmax(np.abs(self.change[places]))]) if places.size else None


@STYLED
def tornado_figure(dataset: xr.Dataset) -> Figure:
    """A bar for each parameter: how far the headline goes with it from the first case's."""
    studied = Studied.known(dataset)
    rows = sorted(_rows(studied), key=lambda row: row.reach, reverse=True)
    shown = rows[:MOST_ROWS]
    figure = Figure(figsize=(Figure().get_figwidth(), ROW_HEIGHT * len(shown) + MARGIN))
    axes = figure.add_subplot()
    start = float(studied.computed[0])
    axes.axvline(start, color=INK, lw=1)
    for place, row in enumerate(shown):
        _draw_row(axes, studied, row, place)
    axes.set_yticks(range(len(shown)), [_row_label(studied, row) for row in shown], fontsize=7)
    axes.set_ylim(len(shown) - 0.4, -0.6)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False, axis="y")
    axes.margins(x=0.12)
    axes.set_xlabel(axis_label(dataset, studied.headline))
    _legend(figure, start)
    rest = len(rows) - len(shown)
    write_caption(
        figure,
        dataset,
        "One parameter at a time differs from the case of the line. In brackets beside each "
        "parameter: its value in that case; at the ends of bars: the value that reaches so far.",
        f"{rest} more parameters change less." if rest else "",
        _failures(rows),
        studied.bars,
    )
    return figure


def _rows(studied: Studied) -> list[_Row]:
    found = []
    ran = studied.status != MISSING
    for values in studied.varied.values():
        own = np.flatnonzero(ran & (values.numbers != values.numbers[0]))
        change = studied.computed[own] - studied.computed[0]
        found.append(_Row(values, own, change))
    return found


def _row_label(studied: Studied, row: _Row) -> str:
    return f"{named(studied.dataset, row.values.name)} ({_value(studied, row, 0)})"


def _value(studied: Studied, row: _Row, case: int) -> str:
    """What the parameter of a row is in a case."""
    value = row.values.value(float(row.values.numbers[case]))
    return quantity(value, unit_of(studied.dataset, row.values.name))


def _draw_row(axes: Axes, studied: Studied, row: _Row, place: int) -> None:
    """Values below the start have the upper half of the row, those above it the lower one."""
    start = float(studied.computed[0])
    for side, colour in ((-1, LIGHT), (1, ACCENT)):
        extreme = row.extreme(side)
        if extreme is None:
            continue
        change, height = float(row.change[extreme]), place + 0.2 * side
        width = None if studied.half_width is None else studied.half_width[row.cases[extreme]]
        axes.barh(height, change, 0.36, left=start, color=colour, xerr=width, ecolor="0.3")
        outward = -1.0 if change < 0.0 else 1.0
        beyond = 0.0 if width is None or not np.isfinite(width) else float(width)
        axes.annotate(
            _value(studied, row, int(row.cases[extreme])),
            (start + change + outward * beyond, height),
            xytext=(3 * outward, 0),
            textcoords="offset points",
            ha="right" if outward < 0.0 else "left",
            va="center",
            fontsize=6,
        )


def _legend(figure: Figure, start: float) -> None:
    handles = [
        Patch(color=LIGHT, label="value below the start"),
        Patch(color=ACCENT, label="value above it, or another choice"),
        Line2D([], [], color=INK, lw=1, label=f"start: {number(start)}"),
    ]
    figure.legend(handles=handles, loc="outside upper left", ncols=3)


def _failures(rows: Sequence[_Row]) -> str:
    """The values at which the case did not complete, in a sentence."""
    failures = []
    for row in rows:
        failed = row.values.numbers[row.cases[~np.isfinite(row.change)]]
        if failed.size:
            values = ", ".join(plain(row.values.text(float(number))) for number in failed)
            own = symbol(row.values.name) or plain(row.values.label)
            failures.append(f"{own} = {values}")
    return f"Not completed: {'; '.join(failures)}." if failures else ""
