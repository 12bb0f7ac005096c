"""The picture `effects`: the effect of each parameter, from a fit."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import Role, over_cases, spoken
from harness.compare.compared import stored_references, where_it_applies
from harness.compare.linear_fit import linear_fit, shared_variance
from harness.pictures.drawing.caption import captioned
from harness.pictures.drawing.plot_parts import (
    ACCENT,
    INK,
    MOST_LABELS,
    STYLED,
    mark_failures,
)
from harness.pictures.drawing.quantities import (
    MOST_LETTERS,
    Floats,
    Values,
    axis_label,
    plain,
    shortened,
    spelt,
)
from harness.pictures.literature import colours_of
from harness.pictures.studied import Studied
from harness.references.reference import COMPARED

LEAST_PARAMETERS = 3
COLUMNS = 3


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


OF_REFERENCES = "Coloured lines: the same fit of references, of the cases where they are valid."
MOST_SHARED = 0.9
"""Share of a parameter's variance that others may explain; with more no effect is its own.

There the error of its effect is three times that of a parameter independent of all others.
"""


class _Effects(NamedTuple):
    """A fit of the headline by a sum of functions of one parameter each."""

    parts: dict[str, Floats]  # of each parameter with an effect of its own; mean 0 over cases used
    mean: float  # of the values over the cases used
    residual: Floats  # NaN for a case that was not used
    spread: float  # standard deviation of the error at cases that are left out of the fit
    explained: float  # share of the variance that the fit explains in such cases
    is_fitted: bool  # whether there were enough cases for a fit; if not, the parts are 0
    joined: dict[str, list[str]]  # parameters without an effect of their own; with which they go


def _effects(studied: Studied, values: Floats | None = None) -> _Effects:
    """Fit the headline, or other values of the cases, by least squares.

    A number, or its logarithm on a logarithmic axis, contributes a parabola, or a straight line if
    there are fewer than two cases for each coefficient. A category contributes a constant. Columns
    that go with those of earlier parameters are left out: there is one effect of all of them.
    """
    values = studied.computed if values is None else values
    used = np.isfinite(values)
    for degree in (2, 1):
        columns, joined = _independent(studied.varied, used, degree)
        matrix = np.hstack([np.ones((values.size, 1)), *columns.values()])
        is_fitted = bool(used.sum() >= 2 * matrix.shape[1])
        if is_fitted:
            break
    if not is_fitted:  # with so few cases parameters go together by chance
        every = {name: np.zeros(values.size) for name in studied.varied}
        mean = float(values[used].mean())
        residual = values - mean
        return _Effects(every, mean, residual, float(np.nanstd(residual)), 0.0, False, {})
    fit = linear_fit(matrix[used], values[used])
    ends = np.cumsum([1, *(column.shape[1] for column in columns.values())])[:-1]
    (mean,), *found = np.split(fit.weights, ends)
    parts = dict(zip(columns, map(np.matmul, columns.values(), found), strict=True))
    return _Effects(
        parts,
        float(mean),
        values - mean - np.sum(list(parts.values()), axis=0),
        float(np.sqrt(np.mean(fit.left_out**2))),
        fit.explained(values[used]),
        is_fitted,
        joined,
    )


def _independent(
    varied: Mapping[str, Values], used: np.ndarray, degree: int
) -> tuple[dict[str, Floats], dict[str, list[str]]]:
    """The terms of parameters with an effect of their own, and with what each of the others goes.

    A parameter that is the same in all cases used goes with none.
    """
    kept: dict[str, Floats] = {}
    joined: dict[str, list[str]] = {}
    for name, values in varied.items():
        columns = _columns(values, used, degree)
        if not columns.size:
            joined[name] = []
            continue
        alone = [it for it, own in kept.items() if _go_together(columns[used], own[used])]
        if alone:
            joined[name] = alone[:1]
        elif kept and _go_together(columns[used], np.hstack(list(kept.values()))[used]):
            joined[name] = list(kept)
        else:
            kept[name] = columns
    return kept, joined


def _go_together(columns: Floats, others: Floats) -> bool:
    return shared_variance(columns, others) > MOST_SHARED


def _columns(values: Values, used: np.ndarray, degree: int) -> Floats:
    """The terms of the fit, shape [case, :]; over the cases used their mean is 0, and none is 0."""
    if values.categories:
        columns = (values.numbers[:, None] == np.unique(values.numbers[used])[1:]).astype(float)
    else:
        place = np.log(values.numbers) if values.scale == "log" else values.numbers
        count = np.unique(place[used]).size
        place = (place - place.min()) / np.ptp(place)
        columns = place[:, None] ** np.arange(1, 1 + min(degree, count - 1))
    centred: Floats = columns - columns[used].mean(axis=0)
    return centred


@STYLED
def effects_figure(dataset: xr.Dataset) -> Figure | None:
    """A panel for each parameter, largest effect first, with the effect of all others removed.

    References have the effect that the same fit finds in their values, from the cases for which
    they are valid.
    """
    studied = much_varied(dataset)
    if studied is None or has_few_cases(studied):
        return None
    found = _effects(studied)
    used = np.isfinite(found.residual)
    strength = {name: np.ptp(part[used]) for name, part in found.parts.items()}
    names = sorted(strength, key=lambda name: strength[name], reverse=True)[:MOST_LABELS]
    column_count = min(len(names), COLUMNS)
    row_count = math.ceil(len(names) / column_count)
    figure = Figure()
    figure.set_figheight(1.75 * row_count + 0.9)
    grid = figure.subplots(row_count, column_count, squeeze=False, sharey=True)
    for axes in grid.flat[len(names) :]:
        axes.remove()
    references = _of_references(studied) if found.is_fitted else []
    for axes, name in zip(grid.flat, names, strict=False):
        _draw_panel(axes, studied, found, name)
        for reference, label, colour in references:
            if name in reference.parts:
                _draw_effect(axes, studied.varied[name], reference, name, colour, label=label)
    for axes in grid[:, 0]:
        axes.set_ylabel(textwrap.fill(axis_label(dataset, studied.headline), 24), fontsize=8)
    failed = int((~used).sum())
    return captioned(
        figure,
        dataset,
        f"{used.sum()} cases{f'; {failed} did not complete (crosses)' if failed else ''}.",
        "Each dot is a case, less the effects of all other parameters; the line is this "
        "parameter's effect, a parabola by least squares. The band is the standard deviation of "
        f"the error at cases left out of the fit, {found.spread:.2g}; of their variance it "
        f"explains {100.0 * found.explained:.3g} %."
        if found.is_fitted
        else "Each dot is a case as it was computed: there are too few for a fit.",
        OF_REFERENCES if references else "",
        _joined(found.joined),
        studied.bars,
        f"Of {len(found.parts)} parameters the {len(names)} with most effect are shown."
        if len(found.parts) > len(names)
        else "",
        legend=grid.flat[0] if references else None,
    )


def _of_references(studied: Studied) -> list[tuple[_Effects, str, str]]:
    """The effects in the values of each reference with enough valid cases; label and colour."""
    dataset, found = studied.dataset, []
    if studied.headline != COMPARED:
        return []
    references = stored_references(dataset)
    for reference, colour in zip(references, colours_of(references), strict=True):
        values = over_cases(dataset, f"{Role.REFERENCE}_{reference.id}").astype(float)
        is_valid = over_cases(dataset, where_it_applies(dataset, reference.id)).astype(bool)
        is_valid &= np.isfinite(studied.computed)
        if is_valid.any():
            effects = _effects(studied, np.where(is_valid, values, np.nan))
            found += [
                (effects, plain(shortened(reference.label, MOST_LETTERS)), colour)
            ] * effects.is_fitted
    return found


def _joined(joined: Mapping[str, Sequence[str]]) -> str:
    """Sentences on the parameters without an effect of their own."""
    words = {name: plain(spelt(spoken(name))) for name in joined}
    constant = ", ".join(words[name] for name, others in joined.items() if not others)
    together = [
        f"{words[name]} goes with {' and '.join(plain(spelt(spoken(it))) for it in others)}"
        for name, others in joined.items()
        if others
    ]
    told = f"The same in all completed cases: {constant}." if constant else ""
    one = f"One effect, not told apart: {'; '.join(together)}." if together else ""
    return " ".join(filter(None, (one, told)))


def _draw_panel(axes: Axes, studied: Studied, found: _Effects, name: str) -> None:
    values = studied.varied[name]
    effect = found.mean + found.parts[name]
    used = np.isfinite(found.residual)
    axes.errorbar(
        values.numbers[used],
        (effect + found.residual)[used],
        studied.widths(used),
        fmt="o",
        ms=max(1.5, 4.0 - 0.005 * values.numbers.size),
        color="0.65",
        elinewidth=0.6,
        capsize=0,
        zorder=1,
    )
    if found.is_fitted:
        order = np.argsort(values.numbers, kind="stable")
        low, high = (effect[order] + side * found.spread for side in (-1, 1))
        axes.fill_between(values.numbers[order], low, high, color=ACCENT, alpha=0.3, lw=0, zorder=2)
        _draw_effect(axes, values, found, name, INK, label="computed")
    mark_failures(axes, values.numbers[~used])
    values.dress(axes, room=5)
    axes.set_xlabel(axis_label(studied.dataset, name), fontsize=8)
    axes.tick_params(labelsize=7)


def _draw_effect(
    axes: Axes, values: Values, found: _Effects, name: str, colour: str, label: str
) -> None:
    """Draw the effect over the range of the cases that it was found from."""
    used = np.flatnonzero(np.isfinite(found.residual))
    order = used[np.argsort(values.numbers[used], kind="stable")]
    line, marker = ("", "_") if values.categories else ("-", "")
    effect = found.mean + found.parts[name][order]
    axes.plot(values.numbers[order], effect, color=colour, ls=line, marker=marker, label=label)
