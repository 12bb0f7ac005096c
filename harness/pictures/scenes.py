"""The picture of several scenes in the same soils: the headline of each, with its bar."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from harness.archive.conventions import (
    COMPLETED,
    Role,
    is_there,
    over_cases,
    scenes_of,
    spoken,
    uncertainty_of,
    varied_names,
    with_role,
)
from harness.pictures.drawing.caption import write_caption
from harness.pictures.drawing.plot_parts import MARKERS, STYLED, legend_above, series_colour
from harness.pictures.drawing.quantities import Floats, assigned, named, unit_of

ROW_HEIGHT, MARGIN = 0.45, 1.6
"""Inches of a row, and of axis, legend and caption."""
SPREAD = 0.5
"""Height that the scenes of a row take, over its own."""
MOST_ROWS = 24
"""Rows on a page."""


@dataclass(frozen=True)
class _Rows:
    """Cases of several scenes, those with the same values of what varies in one row.

    Attributes:
        dataset: the result.
        headlines: names of what the scenes were run for.
        labels: of the rows.
        cases: number of the case of each scene in each row, by scene.
    """

    dataset: xr.Dataset
    headlines: list[str]
    labels: list[str]
    cases: dict[str, list[int]]

    @classmethod
    def of(cls, dataset: xr.Dataset) -> _Rows | None:
        """The rows; None where the scenes do not share them, or have results of several units."""
        if "status" not in dataset or "scene" not in dataset.coords:
            return None
        dims = set(dataset["status"].dims)
        named_headlines = with_role(dataset, Role.HEADLINE)
        headlines = [name for name in named_headlines if set(dataset[name].dims) <= dims]
        scenes = np.array(scenes_of(dataset))
        kinds = list(dict.fromkeys(scenes.tolist()))
        names = _varied_within(dataset, scenes)
        columns = [over_cases(dataset, name).tolist() for name in names]
        values = list(zip(*columns, strict=True)) or [()] * scenes.size
        found = {kind: [values[case] for case in np.flatnonzero(scenes == kind)] for kind in kinds}
        rows = found[kinds[0]]
        alike = all(len(own) == len(set(own)) and set(own) == set(rows) for own in found.values())
        units = {unit_of(dataset, name) for name in headlines}
        if len(kinds) < 2 or not alike or len(units) != 1 or len(rows) > MOST_ROWS:
            return None
        labels = [
            ", ".join(assigned(dataset, *it) for it in zip(names, row, strict=True)) for row in rows
        ]
        cases = {
            kind: [int(np.flatnonzero(scenes == kind)[found[kind].index(row)]) for row in rows]
            for kind in kinds
        }
        return cls(dataset, headlines, labels, cases)

    @property
    def values(self) -> Floats:
        """The headline of each case, not a number where it did not complete."""
        values = np.full(self.dataset["status"].size, np.nan)
        for name in self.headlines:
            own = over_cases(self.dataset, name).astype(float)
            values = np.where(np.isnan(values), own, values)
        completed = over_cases(self.dataset, "status").astype(str) == COMPLETED
        drawn: Floats = np.where(completed, values, np.nan)
        return drawn


def shows_scenes(dataset: xr.Dataset) -> bool:
    """Whether several scenes were run with the same values of what varies."""
    return _Rows.of(dataset) is not None


@STYLED
def scenes_figure(dataset: xr.Dataset) -> Figure:
    """A row for each soil, with a mark for each scene; the first of the study on top."""
    rows = _Rows.of(dataset)
    assert rows is not None, "the scenes share no rows"
    count, kinds = len(rows.labels), list(rows.cases)
    figure = Figure(figsize=(Figure().get_figwidth(), ROW_HEIGHT * count + MARGIN))
    axes = figure.subplots()
    values, half_width = rows.values, uncertainty_of(dataset).astype(float)
    for number, (kind, cases) in enumerate(rows.cases.items()):
        axes.errorbar(
            values[cases],
            np.arange(count) + SPREAD * (number / (len(kinds) - 1) - 0.5),
            xerr=half_width[cases],
            fmt=MARKERS[number % len(MARKERS)],
            color=series_colour(number, len(kinds)),
            ms=4,
            capsize=3,
            label=spoken(kind),
        )
    axes.set_yticks(range(count), rows.labels, fontsize=8)
    axes.set_ylim(count - 0.5, -0.5)
    unit = unit_of(dataset, rows.headlines[0]) or "-"
    axes.set_xlabel(f"{', '.join(named(dataset, name) for name in rows.headlines)} [{unit}]")
    legend_above(figure, axes)
    lost = int(np.isnan(values).sum())
    write_caption(
        figure,
        dataset,
        "Error bars hold the value with 95 %." if np.isfinite(half_width).any() else "",
        f"{lost} of {values.size} cases did not complete." if lost else "",
    )
    return figure


def _varied_within(dataset: xr.Dataset, scenes: np.ndarray) -> list[str]:
    """What differs between cases of the same scene."""

    def differs(name: str) -> bool:
        values = over_cases(dataset, name)
        return any(
            len({it for it in values[scenes == kind].tolist() if is_there(it)}) > 1
            for kind in set(scenes.tolist())
        )

    return [name for name in varied_names(dataset) if name != "scene" and differs(name)]
