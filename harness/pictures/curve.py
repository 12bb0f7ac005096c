"""The picture `curve`: the result over a varied parameter, cone factors beside the literature."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import Role, over_cases, with_role
from harness.compare.compared import BY_COMPRESSION, stored_experience
from harness.pictures.convergence import refined
from harness.pictures.drawing.caption import captioned, left_out
from harness.pictures.drawing.plot_parts import STYLED, label_ends, once, panels, series
from harness.pictures.drawing.quantities import Floats, Values, axis_label
from harness.pictures.literature import (
    draw_experience,
    draw_literature,
    has_literature,
    ranges_of_own,
)
from harness.pictures.map import is_map
from harness.pictures.sounding import STRETCH
from harness.pictures.studied import Studied
from harness.references.reference import COMPARED, NEEDED


@STYLED
def curve_figure(dataset: xr.Dataset) -> Figure | None:
    """The headline over one parameter; a second one that gives no map makes several series.

    Cone factors are shown with the envelope of the literature if the scene has the parameters that
    it depends on, also for a single case. Stretches of a sounding have no curve, because the
    picture `sounding` joins them.
    """
    studied = Studied.of(dataset)
    if studied is None or not studied.is_combined or STRETCH in studied.varied:
        return None
    if refined(studied) or is_map(studied) or len(studied.varied) > 2:
        return None
    if not (studied.varied or has_literature(studied)):
        return None
    name = max(
        studied.numbers or studied.varied,
        key=lambda it: studied.varied[it].different.size,
        default=NEEDED[1],
    )
    along = studied.varied.get(name) or Values.of(dataset, name)
    figure, (axes,) = panels()
    if studied.headline == COMPARED:
        draw_experience(axes, dataset)
    groups = studied.groups(name, along.numbers)
    shown = series(groups)
    ends = []
    if has_literature(studied):
        drawn = [(cases, line.colour) for (cases, _), line in shown]
        ends = draw_literature(axes, studied, along, drawn)
    for (cases, label), line in shown:
        x = along.numbers[cases]
        style = {**line.style, "ls": "" if along.categories else "-", "zorder": 4}
        studied.draw(axes, along.numbers, cases, label=label or "computed", **style)
        _draw_exact(axes, studied, cases, x, are_texts=bool(along.categories))
        _draw_by_strength_of_bands(axes, studied, cases, x, line.colour)
    along.dress(axes, room=10)
    axes.set(xlabel=axis_label(dataset, name), ylabel=axis_label(dataset, studied.headline))
    label_ends(axes, ends)
    return captioned(
        figure,
        dataset,
        studied.bars,
        ranges_of_own(dataset) if has_literature(studied) else "",
        left_out(len(groups) - len(shown), "series"),
        legend=axes,
    )


def _draw_exact(
    axes: Axes, studied: Studied, cases: np.ndarray, x: Floats, *, are_texts: bool
) -> None:
    """Draw exact values: a line over numbers, single marks over texts."""
    dataset = studied.dataset
    style: dict[str, Any] = {"ls": "", "marker": "_", "ms": 20} if are_texts else {"ls": "--"}
    for name in with_role(dataset, Role.EXACT):
        belongs = dataset[name].attrs.get("exact_of") == studied.headline
        if belongs and set(dataset[name].dims) <= set(dataset["status"].dims):
            exact = over_cases(dataset, name)[cases]
            axes.plot(x, exact, **style, lw=1, color="0.4", label=once(axes, "exact"))


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
        axes.plot(x, factors[cases], ls=":", marker="o", mfc="white", color=colour, label=label)
