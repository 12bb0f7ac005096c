"""The pictures `effects` and `tornado`: a row for each parameter, with its effect on the result.

The effect is found by a fit where parameters vary together, and seen where each changes alone.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import MISSING, Role, over_cases
from harness.compare.compared import stored_references, where_it_applies
from harness.compare.effects import Effects, Input, effects_of
from harness.pictures.drawing.caption import captioned, not_completed
from harness.pictures.drawing.plot_parts import draw_values, once
from harness.pictures.drawing.quantities import (
    MOST_LETTERS,
    Floats,
    Values,
    axis_label,
    in_words,
    number,
    plain,
    shortened,
    wrapped,
)
from harness.pictures.drawing.rows import MOST_ROWS, height_in_row, label_of_row, labelled_rows
from harness.pictures.drawing.style import ACCENT, BAND, DOT, GREY, INK, OTHER_DASHES, STYLED, THIN
from harness.pictures.literature import colours_of
from harness.pictures.studied import Studied, changing
from harness.references.reference import COMPARED

LEAST_PARAMETERS = 3
ROW_HEIGHT = 0.6
"""Height of the row of a parameter [inch]."""
OF_HEIGHTS = "The height in a row is the parameter's value, the first at the bottom."
OF_REFERENCES = "Dashed, in colour: the same fit of references, of the cases where they are valid."


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


def _effects(studied: Studied, values: Floats | None = None) -> Effects:
    """The effects of what is varied in the headline, or in other values of the cases."""
    inputs = {
        name: Input(it.numbers, bool(it.categories), it.scale == "log")
        for name, it in studied.varied.items()
    }
    return effects_of(inputs, studied.computed if values is None else values)


@STYLED
def effects_figure(dataset: xr.Dataset) -> Figure | None:
    """A row for each parameter, largest effect first, with the effect of all others removed.

    References have the effect that the same fit finds in their values, from the cases for which
    they are valid.
    """
    studied = much_varied(dataset)
    if studied is None or has_few_cases(studied):
        return None
    found = _effects(studied)
    used = np.isfinite(found.residual)
    names, more = _largest({name: np.ptp(part[used]) for name, part in found.parts.items()})
    figure, axes = _rows(studied, [studied.varied[name] for name in names])
    references = _of_references(studied) if found.is_fitted else []
    for place, name in enumerate(names):
        values = studied.varied[name]
        heights = height_in_row(place, values, values.numbers)
        if found.is_fitted:
            order, effect = np.argsort(heights, kind="stable"), found.mean + found.parts[name]
            low, high = (effect[order] + side * found.spread for side in (-1, 1))
            axes.fill_betweenx(heights[order], low, high, color=ACCENT, **BAND)
            _draw_effect(axes, place, values, found, label="computed", color=INK)
        for reference, look in references:
            if name in reference.parts:
                _draw_effect(axes, place, values, reference, **look)
        alone = found.mean + found.parts[name] + found.residual
        style = {"fmt": "o", "ms": DOT, "color": GREY, "zorder": 1}
        style |= {"elinewidth": THIN, "capsize": 0}
        draw_values(axes, heights, alone, studied.half_width, of_rows=True, **style)
    failed = int((~used).sum())
    return captioned(
        figure,
        dataset,
        f"{used.sum()} cases{f'; {failed} did not complete (crosses)' if failed else ''}.",
        OF_HEIGHTS,
        "Each dot is a case, less the effects of all other parameters; the line is this "
        "parameter's effect, a parabola by least squares. The band is the standard deviation of "
        f"the error at cases left out of the fit, {found.spread:.2g}; of their variance it "
        f"explains {100.0 * found.explained:.3g} %."
        if found.is_fitted
        else "Each dot is a case as it was computed: there are too few for a fit.",
        OF_REFERENCES if references else "",
        _joined(found.joined),
        studied.bars,
        more,
        legend=axes if references else None,
    )


@STYLED
def tornado_figure(dataset: xr.Dataset) -> Figure | None:
    """A row for each parameter that is changed alone, with the start and the cases that change it.

    The parameter with the largest change of the headline is on top.
    """
    studied = Studied.of(dataset)
    if studied is None or not studied.is_one_at_a_time or not np.isfinite(studied.computed[0]):
        return None
    varied = list(studied.varied.values())
    ran, is_start = over_cases(dataset, "status") != MISSING, np.arange(studied.computed.size) == 0
    changed = {
        values.name: np.flatnonzero(ran & (own | is_start))
        for values, own in zip(varied, changing(dataset, varied), strict=True)
    }
    start = float(studied.computed[0])
    reach = {
        name: float(np.ptp(np.nan_to_num(studied.computed[cases] - start)))
        for name, cases in changed.items()
        if cases.size > 1
    }
    if not any(reach.values()):
        return None
    names, more = _largest(reach)
    rows = [studied.varied[name].at(changed[name]) for name in names]
    figure, axes = _rows(studied, rows)
    axes.axvline(start, color=INK, label=f"start: {number(start)}")
    for place, values in enumerate(rows):
        heights = height_in_row(place, values, values.numbers)
        order = np.argsort(-heights, kind="stable")
        cases = changed[values.name][order]
        style = {"fmt": "o-", "color": ACCENT, "zorder": 3}
        half_widths = studied.widths(cases)
        draw_values(
            axes, heights[order], studied.computed[cases], half_widths, of_rows=True, **style
        )
        axes.plot(start, heights[0], "o", color=INK, zorder=4)
    return captioned(
        figure,
        dataset,
        "Each case differs from the start in one parameter.",
        OF_HEIGHTS,
        more,
        not_completed(dataset),
        studied.bars,
        legend=axes,
    )


def _largest(changes: Mapping[str, float]) -> tuple[list[str], str]:
    """The parameters with the largest changes, and a sentence on those left out."""
    names = sorted(changes, key=lambda name: changes[name], reverse=True)
    left = len(names) - MOST_ROWS
    told = f"{left} more parameters change the result less." if left > 0 else ""
    return names[:MOST_ROWS], told


def _rows(studied: Studied, rows: Sequence[Values]) -> tuple[Figure, Axes]:
    """Rows of parameters over the headline."""
    dataset = studied.dataset
    labels = [label_of_row(dataset, values) for values in rows]
    figure, axes = labelled_rows(labels, ROW_HEIGHT)
    axes.margins(x=0.05)
    axes.set_xlabel(wrapped(axis_label(dataset, studied.headline), 40))
    return figure, axes


def _of_references(studied: Studied) -> list[tuple[Effects, dict[str, Any]]]:
    """The effects in the values of each reference with enough valid cases, and how it is drawn."""
    dataset, found = studied.dataset, []
    if studied.headline != COMPARED:
        return []
    references = stored_references(dataset)
    looks = zip(references, colours_of(references), itertools.cycle(OTHER_DASHES), strict=False)
    for reference, colour, dashes in looks:
        values = over_cases(dataset, f"{Role.REFERENCE}_{reference.id}").astype(float)
        is_valid = over_cases(dataset, where_it_applies(dataset, reference.id)).astype(bool)
        is_valid &= np.isfinite(studied.computed)
        if is_valid.any():
            effects = _effects(studied, np.where(is_valid, values, np.nan))
            label = plain(shortened(reference.label, MOST_LETTERS))
            found += [
                (effects, {"label": label, "color": colour, "ls": dashes})
            ] * effects.is_fitted
    return found


def _joined(joined: Mapping[str, Sequence[str]]) -> str:
    """Sentences on the parameters without an effect of their own."""
    words = {name: in_words(name) for name in joined}
    constant = ", ".join(words[name] for name, others in joined.items() if not others)
    together = [
        f"{words[name]} goes with {' and '.join(in_words(it) for it in others)}"
        for name, others in joined.items()
        if others
    ]
    told = f"The same in all completed cases: {constant}." if constant else ""
    one = f"One effect, not told apart: {'; '.join(together)}." if together else ""
    return " ".join(filter(None, (one, told)))


def _draw_effect(
    axes: Axes, place: int, values: Values, found: Effects, label: str, **look: Any
) -> None:
    """Draw the effect over the range of the cases that it was found from."""
    used = np.flatnonzero(np.isfinite(found.residual))
    order = used[np.argsort(values.numbers[used], kind="stable")]
    look |= {"ls": "", "marker": "|"} if values.categories else {}
    effect = found.mean + found.parts[values.name][order]
    heights = height_in_row(place, values, values.numbers[order])
    axes.plot(effect, heights, label=once(axes, label), **look)
