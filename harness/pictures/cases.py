"""The pictures `cases` and `scenes`, with a row for each case or soil."""

from statistics import mode

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from harness.archive.conventions import (
    COMPLETED,
    alike,
    headline_values,
    headlines_of,
    over_cases,
    scenes_of,
    uncertainty_of,
    varied_within,
)
from harness.pictures.drawing.caption import captioned, not_completed, of_half_widths
from harness.pictures.drawing.plot_parts import draw_values, series
from harness.pictures.drawing.quantities import assigned, axis_label, in_words, named, unit_of
from harness.pictures.drawing.rows import labelled_rows
from harness.pictures.drawing.style import INK, STYLED
from harness.pictures.effects import has_few_cases, much_varied
from harness.pictures.studied import BARS

CASE_HEIGHT, SOIL_HEIGHT = 0.32, 0.45
"""Heights [inch] of the row of a case, and of a soil."""


@STYLED
def cases_figure(dataset: xr.Dataset) -> Figure | None:
    """A row for each case, if much varies but there are too few cases for the effects."""
    studied = much_varied(dataset)
    if studied is None or not has_few_cases(studied):
        return None
    count, varied = studied.computed.size, studied.varied
    usual = {name: mode(parameter.numbers.tolist()) for name, parameter in varied.items()}
    labels = [
        studied.label(case, [name for name in varied if varied[name].numbers[case] != usual[name]])
        for case in range(count)
    ]
    figure, axes = labelled_rows([label or "as most" for label in labels], CASE_HEIGHT)
    rows, style = np.arange(float(count)), {"fmt": "o", "color": INK}
    draw_values(axes, rows, studied.computed, studied.half_width, of_rows=True, **style)
    axes.set_xlabel(axis_label(dataset, studied.headline))
    most = [assigned(dataset, name, varied[name].value(usual[name])) for name in varied]
    beside = f"Beside each case: where it differs from {', '.join(most)}."
    failed = not_completed(dataset)
    return captioned(figure, dataset, beside, studied.bars, failed, legend=axes)


def _soils(dataset: xr.Dataset) -> tuple[list[str], dict[str, list[int]]]:
    """Labels of soils, and the cases of each scene in the order of the soils.

    Both are empty if not all scenes have the same soils.
    """
    scenes, names = scenes_of(dataset), varied_within(dataset)
    kinds, soils = list(dict.fromkeys(scenes)), alike(dataset, names)
    own = [sorted(cases, key=lambda case: kinds.index(scenes[case])) for cases in soils.values()]
    if any([scenes[case] for case in cases] != kinds for cases in own):
        return [], {}
    labels = [
        ", ".join(assigned(dataset, *pair) for pair in zip(names, soil, strict=True))
        for soil in soils
    ]
    return labels, dict(zip(kinds, map(list, zip(*own, strict=True)), strict=True))


@STYLED
def scenes_figure(dataset: xr.Dataset) -> Figure | None:
    """A row for each soil, with a mark for each scene; the first of the study on top.

    It is for up to 24 soils that all scenes share, and results of one unit.
    """
    if "scene" not in dataset.coords:
        return None
    headlines, (labels, soils) = headlines_of(dataset), _soils(dataset)
    units = {unit_of(dataset, name) for name in headlines}
    if len(soils) < 2 or len(units) != 1 or len(labels) > 24:
        return None
    figure, axes = labelled_rows(labels, SOIL_HEIGHT)
    completed = over_cases(dataset, "status").astype(str) == COMPLETED
    values = np.where(completed, headline_values(dataset), np.nan)
    half_width = uncertainty_of(dataset).astype(float)
    beside = np.linspace(-0.25, 0.25, len(soils))  # of the height of a row
    for (kind, cases), line in series(soils.items(), None):
        rows = np.arange(len(cases)) + beside[line.place]
        style = {"fmt": line.marker, "color": line.colour, "label": in_words(kind)}
        draw_values(axes, rows, values[cases], half_width[cases], of_rows=True, **style)
    unit = units.pop() or "-"
    axes.set_xlabel(f"{', '.join(named(dataset, name) for name in headlines)} [{unit}]")
    bars = of_half_widths(dataset, BARS, are_shown=bool(np.isfinite(half_width).any()))
    return captioned(figure, dataset, bars, not_completed(dataset), legend=axes)
