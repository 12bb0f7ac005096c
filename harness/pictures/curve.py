"""The picture of one varied parameter: what was computed over it, with bands and references."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import Role, over_cases, parameter_of, with_role
from harness.compare.compared import NothingToCompareError, conditions_of, stored_references
from harness.pictures.convergence import shows_convergence
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.literature import draw_experience, draw_literature, ranges_of_own
from harness.pictures.drawing.plot_parts import (
    MARKERS,
    MOST_LABELS,
    STYLED,
    CurveEnd,
    chosen,
    draw_series,
    empty_figure,
    label_ends,
    legend_above,
    mark_failures,
    once,
    series_colour,
)
from harness.pictures.drawing.quantities import Floats, Values, axis_label
from harness.pictures.map import shows_map
from harness.pictures.sounding import STRETCH
from harness.pictures.studied import Studied
from harness.references.cone_factors import COMPARED, NEEDED
from harness.study.own_references import OwnReference

FINE = 400
"""Points of a literature curve."""


def shows_curve(dataset: xr.Dataset) -> bool:
    """Whether a result is that of one varied parameter, or of two that make no map.

    A cone factor alone is shown too, beside the literature's. The stretches of a sounding are no
    curve: their picture joins them.
    """
    studied = Studied.of(dataset)
    if studied is None or not studied.is_combined or STRETCH in studied.varied:
        return False
    if shows_map(dataset) or shows_convergence(dataset):
        return False
    count = len(studied.varied)
    return count in (1, 2) or (count == 0 and studied.headline == COMPARED)


@STYLED
def curve_figure(dataset: xr.Dataset) -> Figure:
    """What was computed over a parameter, one series for each value of a second one.

    Cone factors have the envelope of the literature beside them. The references have their curves
    where these hold for all series; otherwise each series has the envelope in its own colour.
    """
    studied = Studied.known(dataset)
    name, other = _axis_and_series(studied)
    figure, axes = empty_figure()
    if studied.headline == COMPARED:
        draw_experience(axes, dataset)
    along = _values(studied, name)
    groups = studied.groups(other)
    shown = chosen(len(groups), MOST_LABELS)
    ends: list[CurveEnd] = []
    shared = not any(_depends_on(dataset, one) for one in other)
    for rank, cases in enumerate(groups[place] for place in shown):
        colour = series_colour(rank, len(shown))
        ordered = cases[np.argsort(along.numbers[cases], kind="stable")]
        x, y = along.numbers[ordered], studied.computed[ordered]
        label = studied.label(cases[0], other)
        if studied.headline == COMPARED and (rank == 0 or not shared):
            ends += _literature(axes, studied, name, ordered[0], None if shared else colour)
        widths = None if studied.half_width is None else studied.half_width[ordered]
        style = {"ls": "" if along.categories else "-", "marker": MARKERS[rank], "zorder": 4}
        draw_series(axes, x, y, widths, color=colour, label=label or "computed", **style)
        mark_failures(axes, x[~np.isfinite(y)])
        _draw_exact(axes, studied, ordered, x)
    along.dress(axes, room=10)
    axes.set_xlabel(axis_label(dataset, name))
    axes.set_ylabel(axis_label(dataset, studied.headline))
    label_ends(axes, ends)
    legend_above(figure, axes)
    left_out = len(groups) - len(shown)
    write_caption(
        figure,
        dataset,
        studied.bars,
        ranges_of_own(dataset) if ends else "",
        f"{left_out} more series are not shown." if left_out else "",
    )
    return figure


def _axis_and_series(studied: Studied) -> tuple[str, list[str]]:
    """The parameter along the axis, the number with most values, and those that make series."""
    if not studied.varied:
        return NEEDED[1], []
    names = studied.numbers or list(studied.varied)
    name = max(names, key=lambda it: studied.varied[it].different.size)
    return name, [it for it in studied.varied if it != name]


def _values(studied: Studied, name: str) -> Values:
    return studied.varied.get(name) or Values.of(studied.dataset, name)


def _depends_on(dataset: xr.Dataset, name: str) -> bool:
    """Whether the references, the literature's or the study's own, depend on a parameter."""
    try:
        conditions = vars(conditions_of(dataset))
    except NothingToCompareError:
        return False
    own = [
        reference for reference in stored_references(dataset) if isinstance(reference, OwnReference)
    ]
    if any(parameter_of(name) in reference.names for reference in own):
        return True
    column = over_cases(dataset, name)
    quantities = [it for key, it in conditions.items() if key != "parameters"]
    return any(np.array_equal(over_cases(dataset, quantity), column) for quantity in quantities)


def _literature(
    axes: Axes, studied: Studied, name: str, case: int, colour: str | None
) -> list[CurveEnd]:
    along = _values(studied, name)
    dataset = studied.dataset
    follows = [name for name in with_role(dataset, Role.PARAMETER) if name in dataset.data_vars]
    # What the scene derives from a varied parameter goes along with it: it is left to be derived.
    one = studied.case(case).drop_vars([name for name in follows if dataset[name].ndim])
    if along.categories:
        # A text says nothing to the literature: its values stand side by side.
        places = np.linspace(-0.5, len(along.categories) - 0.5, FINE)
        return draw_literature(axes, one.assign({name: 0.0}), name, places, colour)
    return draw_literature(axes, one, name, _fine(along), colour)


def _fine(values: Values) -> Floats:
    """Where the literature's curves are drawn: from the first value to the last."""
    low, high = values.different[[0, -1]].tolist()
    if low == high:
        low, high = (0.0, 1.0) if 0 <= low <= 1 else (low / 2, low * 2)
    space = np.geomspace if values.scale == "log" else np.linspace
    return np.union1d(space(low, high, FINE), values.different)


def _draw_exact(axes: Axes, studied: Studied, cases: np.ndarray, x: Floats) -> None:
    """Draw the exact values of the headline, of scenes that have them."""
    dataset = studied.dataset
    for name in with_role(dataset, Role.EXACT):
        belongs = dataset[name].attrs.get("exact_of") == studied.headline
        if belongs and set(dataset[name].dims) <= set(dataset["status"].dims):
            exact = over_cases(dataset, name)[cases]
            axes.plot(x, exact, ls="--", lw=1, color="0.4", label=once(axes, "exact"))
