"""A result as pictures and reports see it: what its cases vary, and their headline."""

import functools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from harness.archive.conventions import (
    CHANGED,
    freely_varied,
    headlines_of,
    over_cases,
    parameter_names,
    scenes_of,
    uncertainty_of,
)
from harness.pictures.drawing.caption import of_half_widths
from harness.pictures.drawing.plot_parts import draw_values
from harness.pictures.drawing.quantities import DERIVED, Floats, Values, assigned
from harness.references.reference import COMPARED
from harness.study import scene_part
from harness.study.designs import LATIN_HYPERCUBE, ONE_AT_A_TIME
from mpm_warp.scenes import scene_class, scene_names

BARS = "Error bars hold the value"


@dataclass(frozen=True)
class Studied:
    """The cases of a result in their order, and the name of their headline."""

    dataset: xr.Dataset
    headline: str

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Self | None:
        """From a result of one scene with one headline; None for any other."""
        found = headlines_of(dataset) or [COMPARED] * (COMPARED in dataset)
        several = len(set(scenes_of(dataset))) > 1
        return None if several or len(found) != 1 else cls(dataset, found[0])

    @functools.cached_property
    def computed(self) -> Floats:
        """The headline of each case; NaN where it did not complete."""
        return over_cases(self.dataset, self.headline).astype(float)

    @functools.cached_property
    def half_width(self) -> Floats | None:
        """The half width of each case's headline (95 %); None if no case has one."""
        known = uncertainty_of(self.dataset).astype(float)
        return known if np.isfinite(known).any() else None

    def widths(self, cases: np.ndarray | int) -> Floats | None:
        """The half widths of some cases; None if no case of the study has one."""
        return None if self.half_width is None else self.half_width[cases]

    def draw(self, axes: Axes, x: Floats, cases: np.ndarray, **style: Any) -> None:
        """Draw the headline of some cases; `x` is for all cases."""
        draw_values(axes, x[cases], self.computed[cases], self.widths(cases), **style)

    @functools.cached_property
    def varied(self) -> dict[str, Values]:
        """The parameters with several values that follow from no others, in the study's order."""
        names = [name for name in freely_varied(self.dataset) if name != "scene"]
        values = {name: Values.of(self.dataset, name) for name in names}
        return {name: value for name, value in values.items() if value.different.size > 1}

    @property
    def numbers(self) -> list[str]:
        """The varied parameters that are numbers."""
        return [name for name, parameter in self.varied.items() if not parameter.categories]

    @property
    def is_one_at_a_time(self) -> bool:
        """Whether each case differs from the first in one parameter."""
        return self.dataset.attrs.get("design") == ONE_AT_A_TIME

    @property
    def is_combined(self) -> bool:
        """Whether values are combined: neither random nor changed one at a time."""
        return self.dataset.attrs.get("design") not in (ONE_AT_A_TIME, LATIN_HYPERCUBE)

    @functools.cached_property
    def table(self) -> tuple[Values, Values, Floats]:
        """Two parameters, the one of more values first, and the headline [second, first]."""
        x, y = sorted(self.varied.values(), key=lambda it: it.different.size, reverse=True)
        table = np.full((y.different.size, x.different.size), np.nan)
        row, column = (np.searchsorted(it.different, it.numbers) for it in (y, x))
        table[row, column] = self.computed
        return x, y, table

    @property
    def is_map(self) -> bool:
        """Whether two numbers vary in all combinations, with at least four values each."""
        if not self.is_combined or len(self.varied) != 2 or len(self.numbers) != 2:
            return False
        table = self.table[2]
        # Contours need neighbours; with many failed cases curves show more than a map.
        full = bool(np.isfinite(table).mean() > 0.5)
        return min(table.shape) >= 4 and self.computed.size == table.size and full

    @property
    def method(self) -> tuple[str, ...]:
        """The variables of the dataset that hold parameters of the method."""
        return method_of(self.dataset, str(self.dataset.attrs.get("scene", "")))

    @property
    def bars(self) -> str:
        """Sentences on what error bars are and why cases have none; see `of_half_widths`."""
        return of_half_widths(self.dataset, BARS, are_shown=self.half_width is not None)

    def label(self, case: int, names: Iterable[str] | None = None) -> str:
        """The label of a case: its values of these varied parameters, by default of all.

        In a one-at-a-time study only values that differ from the first case are included.
        """
        own = [self.varied[name] for name in (self.varied if names is None else names)]
        return label_of(self.dataset, own, case)

    def groups(self, name: str, along: Floats) -> list[tuple[np.ndarray, str]]:
        """Groups of cases that differ only in `name`, each with its label.

        The cases of a group are ordered by `along`, and the groups by their values, ascending.
        """
        others = [other for other in self.varied if other != name]
        columns = [np.zeros(self.computed.size), *(self.varied[other].numbers for other in others)]
        found, member = np.unique(np.stack(columns, axis=1), axis=0, return_inverse=True)
        order = np.argsort(along, kind="stable")
        groups = [order[member.ravel()[order] == place] for place in range(len(found))]
        return [(cases, self.label(cases[0], others)) for cases in groups]


def label_of(dataset: xr.Dataset, values: Iterable[Values], case: int, start: int = 0) -> str:
    """The values that a case has; one at a time only those that differ from case `start`."""
    shown = list(values)
    is_one_at_a_time = dataset.attrs.get("design") == ONE_AT_A_TIME
    if is_one_at_a_time:
        shown = [it for it in shown if it.numbers[case] != it.numbers[start]]
    shown = [it for it in shown if it.of_case(case) != DERIVED] or shown
    texts = [assigned(dataset, it.name, it.of_case(case)) for it in shown]
    return ", ".join(texts or ["start"] * is_one_at_a_time)


def changing(dataset: xr.Dataset, varied: Sequence[Values]) -> list[np.ndarray]:
    """In a one-at-a-time study: for each parameter which cases change it, each of shape [case].

    The result names the changed parameter, because values are not enough: defaults of others may
    follow it. If a file has no such names, cases that differ in a single parameter are taken.
    """
    if CHANGED in dataset:
        changed = over_cases(dataset, CHANGED).astype(str)
        return [changed == values.name for values in varied]
    differ = [values.numbers != values.numbers[0] for values in varied]
    alone = np.sum(differ, axis=0) == 1
    return [own & alone for own in differ]


def method_of(dataset: xr.Dataset, scene: str) -> tuple[str, ...]:
    """The variables of a dataset that hold parameters of a scene's method."""
    if scene not in scene_names():
        return ()
    stored = parameter_names(dataset)
    return tuple(stored.get(name, name) for name in scene_part.method_of(scene_class(scene)))
