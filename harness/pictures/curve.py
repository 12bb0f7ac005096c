"""The picture `curve`: the result over a varied parameter, cone factors beside the literature."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import Role, over_cases, with_role
from harness.compare.compared import BY_COMPRESSION, stored_experience
from harness.pictures.declared import pieces_of
from harness.pictures.drawing.caption import captioned, left_out
from harness.pictures.drawing.plot_parts import (
    MOST_LABELS,
    end_of,
    label_ends,
    once,
    panels,
    series,
)
from harness.pictures.drawing.quantities import Floats, Values, axis_label
from harness.pictures.drawing.style import BAR, GREY, PAPER, STYLED
from harness.pictures.literature import (
    draw_experience,
    draw_literature,
    has_literature,
    ranges_of_own,
)
from harness.pictures.method.convergence import refined
from harness.pictures.studied import Studied
from harness.references.reference import COMPARED, NEEDED


@STYLED
def curve_figure(dataset: xr.Dataset) -> Figure | None:
    """The headline over one parameter; a second one that gives no map makes several series.

    Cone factors are shown with the envelope of the literature if the scene has the parameters that
    it depends on, also for a single case. Pieces of curves that are joined have no such picture.
    """
    studied = Studied.of(dataset)
    if studied is None or not studied.is_combined or pieces_of(dataset):
        return None
    if refined(studied) or studied.is_map or len(studied.varied) > 2:
        return None
    if not (studied.varied or has_literature(studied)):
        return None
    name = max(
        studied.numbers or studied.varied,
        key=lambda it: studied.varied[it].different.size,
        default=NEEDED[1],
    )
    figure, (axes,) = panels()
    along = studied.varied.get(name) or Values.of(dataset, name)
    left = draw_over(axes, studied, along, MOST_LABELS, room=10)
    return captioned(
        figure,
        dataset,
        studied.bars,
        ranges_of_own(dataset) if has_literature(studied) else "",
        left_out(left, "series"),
        legend=axes,
    )


def draw_over(
    axes: Axes, studied: Studied, along: Values, most: int, room: int, *, at_ends: bool = False
) -> int:
    """Draw the headline over a parameter, a series for each value of others, and the literature.

    Series have their labels in the legend, or at their ends. Returned is the number of series that
    are not drawn because there are more than `most`; the axis has room for `room` labels.
    """
    dataset, ends = studied.dataset, []
    if studied.headline == COMPARED:
        draw_experience(axes, dataset)
    groups = studied.groups(along.name, along.numbers)
    shown = series(groups, most)
    if has_literature(studied):
        drawn = [(cases, line.colour) for (cases, _), line in shown]
        ends += draw_literature(axes, studied, along, drawn)
    for (cases, label), line in shown:
        style = {**line.style, "ls": "" if along.categories else "-", "zorder": 4}
        style |= {} if at_ends else {"label": label or "computed"}
        studied.draw(axes, along.numbers, cases, **style)
        x = along.numbers[cases]
        ends += end_of(x, studied.computed[cases], label, line.colour) if at_ends else []
        _draw_exact(axes, studied, cases, x, are_texts=bool(along.categories))
        _draw_by_strength_of_bands(axes, studied, cases, x, line.colour)
    along.dress(axes, room)
    axes.set(xlabel=axis_label(dataset, along.name), ylabel=axis_label(dataset, studied.headline))
    label_ends(axes, ends)
    return len(groups) - len(shown)


def _draw_exact(
    axes: Axes, studied: Studied, cases: np.ndarray, x: Floats, *, are_texts: bool
) -> None:
    """Draw exact values: a line over numbers, single marks over texts."""
    dataset = studied.dataset
    style: dict[str, Any] = {"ls": "", "marker": "_", "ms": BAR} if are_texts else {"ls": "--"}
    for name in with_role(dataset, Role.EXACT):
        belongs = dataset[name].attrs.get("exact_of") == studied.headline
        if belongs and set(dataset[name].dims) <= set(dataset["status"].dims):
            exact = over_cases(dataset, name)[cases]
            axes.plot(x, exact, **style, color=GREY, label=once(axes, "exact"))


def _draw_by_strength_of_bands(
    axes: Axes, studied: Studied, cases: np.ndarray, x: Floats, colour: str
) -> None:
    """Draw factors by su in compression beside bands of experience, which are by that su.

    Nothing is drawn if the headline is by this su already.
    """
    if BY_COMPRESSION not in studied.dataset or not stored_experience(studied.dataset):
        return
    factors = over_cases(studied.dataset, BY_COMPRESSION)
    if not np.allclose(factors, studied.computed, equal_nan=True):
        label = once(axes, "by su in triaxial compression")
        axes.plot(x, factors[cases], ls=":", marker="o", mfc=PAPER, color=colour, label=label)
