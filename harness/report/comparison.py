"""Studies beside each other: what they share, what differs, and how far their results are apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import is_there, over_cases, parameter_names
from harness.pictures.studied import Studied
from harness.report import words

MOST_VALUES = 6
"""Values of a parameter that are listed; of more the ends are."""

Key = tuple[tuple[str, str], ...]
"""Names and values of the parameters of a soil and its cone."""


@dataclass(frozen=True)
class Comparison:
    """Studies of one scene that have cases with the same parameters, the method's aside.

    Attributes:
        scene: name of the scene.
        headline: what is compared, with its unit.
        studies: their names.
        differing: parameters that are not the same in all of them: the name, and the value or
            values in each study.
        varied: parameters that tell the shared cases apart.
        rows: of each shared case the values of `varied`, the headline in each study, and how much
            the last differs from the first that has it.
    """

    scene: str
    headline: str
    studies: list[str]
    differing: list[tuple[str, list[str]]]
    varied: list[str]
    rows: list[tuple[list[str], list[str], str]]

    @property
    def shared_rows(self) -> list[list[str]]:
        """The shared cases as rows of a table."""
        return [[*values, *results, change] for values, results, change in self.rows]

    @property
    def differing_rows(self) -> list[list[str]]:
        """What differs as rows of a table."""
        return [[name, *values] for name, values in self.differing]


def comparisons(datasets: list[xr.Dataset]) -> list[Comparison]:
    """The comparisons that can be made among results, one for each scene of several studies."""
    groups: dict[tuple[str, str], list[Studied]] = {}
    for dataset in datasets:
        studied = Studied.of(dataset)
        if studied is not None:
            groups.setdefault((str(dataset.attrs["scene"]), studied.headline), []).append(studied)
    return [_comparison(scene, group) for (scene, _), group in groups.items() if len(group) > 1]


def _comparison(scene: str, group: list[Studied]) -> Comparison:
    soils = [_by_soil(studied) for studied in group]
    counts: dict[Key, int] = {}
    for soil in soils:
        for key in soil:
            counts[key] = counts.get(key, 0) + 1
    shared = [key for key, count in counts.items() if count > 1]
    different: dict[str, set[str]] = {}
    for name, value in (pair for key in shared for pair in key):
        different.setdefault(name, set()).add(value)
    varied = [name for name, values in different.items() if len(values) > 1]
    first = group[0]
    unit = words.unit(first.dataset, first.headline)
    label = f"{words.title(first.dataset, first.headline)} {unit}".rstrip()
    return Comparison(
        scene=scene,
        headline=label,
        studies=[str(studied.dataset.attrs["study"]) for studied in group],
        differing=_differing(group),
        varied=[name.replace("_", " ") for name in varied],
        rows=[_row(key, varied, soils) for key in shared],
    )


def _row(
    key: Key, varied: list[str], soils: list[dict[Key, float]]
) -> tuple[list[str], list[str], str]:
    found = [soil.get(key, np.nan) for soil in soils]
    known = [value for value in found if np.isfinite(value)]
    change = known[-1] / known[0] - 1.0 if len(known) > 1 and known[0] else np.nan
    values, results = (
        [dict(key)[name] for name in varied],
        [words.text(entry, digits=3) for entry in found],
    )
    return values, results, words.percent(change)


def _by_soil(studied: Studied) -> dict[Key, float]:
    """The headline by soil and cone; of several settings of the method the costliest counts."""
    dataset = studied.dataset
    names = {
        name: stored
        for name, stored in parameter_names(dataset).items()
        if stored not in studied.method
    }
    # By name: in which order a result holds its parameters depends on which of them vary.
    columns = [
        (name, over_cases(dataset, stored).tolist()) for name, stored in sorted(names.items())
    ]
    cost = over_cases(dataset, "particle_updates").astype(float)
    found: dict[Key, float] = {}
    for case in np.argsort(np.nan_to_num(cost), kind="stable").tolist():
        if np.isfinite(studied.computed[case]):
            key = tuple((name, words.text(values[case], digits=12)) for name, values in columns)
            found[key] = float(studied.computed[case])
    return found


def _differing(group: list[Studied]) -> list[tuple[str, list[str]]]:
    names = dict.fromkeys(name for studied in group for name in parameter_names(studied.dataset))
    rows = [
        (name.replace("_", " "), [_values(studied.dataset, name) for studied in group])
        for name in names
    ]
    return [row for row in rows if len(set(row[1])) > 1]


def _values(dataset: xr.Dataset, name: str) -> str:
    """The value of a parameter in a study, or its values."""
    stored = parameter_names(dataset).get(name)
    if stored is None:
        return words.MISSING
    values = [value for value in np.unique(over_cases(dataset, stored)).tolist() if is_there(value)]
    unit = words.unit(dataset, stored)
    if len(values) > MOST_VALUES:
        text = f"{words.text(values[0])} to {words.text(values[-1])}"
    else:
        text = ", ".join(map(words.text, values)) or "derived"
    return f"{text} {unit}".rstrip()
