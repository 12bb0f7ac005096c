"""The picture of random cases, or of many parameters at once: the effect of each, and the rest."""

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import ACCENT, MOST_LABELS, STYLED, mark_failures
from harness.pictures.drawing.quantities import Floats, Values, axis_label, number
from harness.pictures.studied import Studied
from harness.study.designs import ONE_AT_A_TIME

LEAST_PARAMETERS = 3
MOST_LISTED = 20
"""Cases that a reader takes in one by one."""
COLUMNS = 3
ROW_HEIGHT, MARGIN = 1.75, 0.9
"""Inches of a row of panels, and of the caption."""


def shows_effects(dataset: xr.Dataset) -> bool:
    """Whether a result varies much, in cases enough for a fit or too many to look at each."""
    studied = much_varied(dataset)
    if studied is None:
        return False
    return studied.computed.size > MOST_LISTED or effects(studied).is_fitted


def much_varied(dataset: xr.Dataset) -> Studied | None:
    """What varies three parameters or more together, or any at random; None where none does."""
    studied = Studied.of(dataset)
    if studied is None or studied.design == ONE_AT_A_TIME:
        return None
    least = LEAST_PARAMETERS if studied.is_combined else 1
    varies = len(studied.varied) >= least
    return studied if varies and np.isfinite(studied.computed).sum() >= LEAST_PARAMETERS else None


@dataclass(frozen=True)
class Effects:
    """A fit of the headline by a sum of functions of one parameter each.

    Attributes:
        parts: of the fit, by parameter, of each case; each has the mean zero over completed cases.
        mean: of the headline over completed cases.
        residual: what the fit leaves, of each case; not a number where it did not complete.
        is_fitted: whether there were enough cases for a fit; else the parts are zero.
    """

    parts: dict[str, Floats]
    mean: float
    residual: Floats
    is_fitted: bool

    @property
    def spread(self) -> float:
        """Standard deviation of the residual."""
        return float(np.nanstd(self.residual))

    def strength(self, name: str) -> float:
        """From the least to the greatest of what a parameter contributes."""
        return float(np.ptp(self.parts[name][np.isfinite(self.residual)]))


def effects(studied: Studied) -> Effects:
    """Fit the headline by least squares.

    A number contributes a parabola, in its logarithm where its axis is logarithmic; a straight line
    where there are fewer than two cases for each coefficient. A category contributes a constant.
    """
    sound = np.isfinite(studied.computed)
    values = studied.computed[sound]
    mean = float(values.mean())
    for degree in (2, 1):
        columns = {name: _columns(it, sound, degree) for name, it in studied.varied.items()}
        matrix = np.column_stack(list(columns.values()))
        is_fitted = sound.sum() >= 2 * (matrix.shape[1] + 1)
        if is_fitted:
            break
    coefficients = (
        np.linalg.lstsq(matrix[sound], values - mean)[0] if is_fitted else np.zeros(matrix.shape[1])
    )
    ends = np.cumsum([column.shape[1] for column in columns.values()])[:-1]
    parts = {
        name: own @ factor
        for (name, own), factor in zip(columns.items(), np.split(coefficients, ends), strict=True)
    }
    fit = mean + np.sum(list(parts.values()), axis=0)
    return Effects(parts, mean, np.where(sound, studied.computed - fit, np.nan), bool(is_fitted))


def _columns(values: Values, sound: np.ndarray, degree: int) -> Floats:
    """What the fit is linear in, shape [case, :]; the mean over sound cases is zero."""
    if values.categories:
        columns = (values.numbers[:, None] == np.arange(1, len(values.categories))).astype(float)
    else:
        place = np.log(values.numbers) if values.scale == "log" else values.numbers
        place = (place - place.min()) / np.ptp(place)
        columns = place[:, None] ** np.arange(1, 1 + min(degree, values.different.size - 1))
    centred: Floats = columns - columns[sound].mean(axis=0)
    return centred


@STYLED
def effects_figure(dataset: xr.Dataset) -> Figure:
    """A panel for each parameter, most effect first: the cases without the effect of all others."""
    studied = Studied.known(dataset)
    found = effects(studied)
    names = sorted(studied.varied, key=found.strength, reverse=True)[:MOST_LABELS]
    row_count = math.ceil(len(names) / COLUMNS)
    figure = Figure(figsize=(Figure().get_figwidth(), ROW_HEIGHT * row_count + MARGIN))
    panels = figure.subplots(row_count, COLUMNS, squeeze=False, sharey=True)
    for axes in panels.flat[len(names) :]:
        axes.remove()
    for axes, name in zip(panels.flat, names, strict=False):
        _draw_panel(axes, studied, found, name)
    label = axis_label(dataset, studied.headline)
    figure.supylabel(textwrap.fill(label, 24 + 16 * (row_count - 1)), fontsize=9)
    write_caption(figure, dataset, *_explanations(studied, found, len(names)))
    return figure


def _draw_panel(axes: Axes, studied: Studied, found: Effects, name: str) -> None:
    values = studied.varied[name]
    effect = found.mean + found.parts[name]
    sound = np.isfinite(found.residual)
    order = np.argsort(values.numbers, kind="stable")
    x = values.numbers[order]
    size = max(1.5, 4.0 - 0.005 * x.size)
    axes.plot(values.numbers[sound], (effect + found.residual)[sound], "o", ms=size, color="0.55")
    if found.is_fitted:
        low, high = (effect[order] + side * found.spread for side in (-1, 1))
        style = "" if values.categories else "-"
        axes.fill_between(x, low, high, color=ACCENT, alpha=0.2, lw=0)
        axes.plot(x, effect[order], color=ACCENT, ls=style, marker="_" if not style else "")
    mark_failures(axes, values.numbers[~sound])
    values.dress(axes, room=5)
    axes.set_xlabel(axis_label(studied.dataset, name), fontsize=8)
    axes.tick_params(labelsize=7)


def _explanations(studied: Studied, found: Effects, shown: int) -> Sequence[str]:
    count = int(np.isfinite(found.residual).sum())
    failed = found.residual.size - count
    left_out = len(studied.varied) - shown
    sentences = [
        f"{count} cases; {failed} did not complete (crosses)." if failed else f"{count} cases."
    ]
    if found.is_fitted:
        total = float(np.nanstd(studied.computed))
        explained = 1.0 - (found.spread / total) ** 2 if total > 0.0 else 1.0
        sentences.append(
            "Each dot is a case, less the effects of all other parameters; the line is this "
            "parameter's effect, a parabola by least squares. The band is the standard deviation "
            f"of what the fit leaves, {number(found.spread)}; the fit explains {explained:.0%} of "
            "the variance."
        )
    else:
        sentences.append("Each dot is a case as it was computed: they are too few for a fit.")
    if left_out:
        sentences.append(
            f"Of {len(studied.varied)} parameters the {shown} of most effect are shown."
        )
    return sentences
