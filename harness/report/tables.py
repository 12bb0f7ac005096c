"""The tables of the report: the cases of a study, and a comparison of studies."""

import functools
import itertools
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from harness.archive.conventions import (
    Role,
    is_there,
    limits_of,
    over_cases,
    parameter_names,
    reasons_of,
    stated,
    uncertainty_of,
    varied_names,
    with_role,
)
from harness.compare.compared import where_it_applies
from harness.compare.finest_error import error_name
from harness.compare.result_table import PRESSURE, own_reasons_of_pressure
from harness.pictures.studied import Studied
from harness.report import words
from mpm_warp.uncertainty.further_runs import REASON


@dataclass(frozen=True)
class Column:
    """One quantity of all cases; symbol and unit are "" if it has none."""

    title: str
    symbol: Markup
    unit: str
    is_number: bool
    cells: list[str]


def case_columns(dataset: xr.Dataset) -> list[Column]:
    """The columns of the table of cases: what varies, status, and results."""
    return [_column(dataset, name) for name in _names(dataset)]


def case_parameters(dataset: xr.Dataset) -> dict[str, list[Any]]:
    """The parameters of a result.

    `fixed` has name, value and unit of those that are the same in all cases; `own` has the headings
    of the others, and `values` their texts for each case.
    """
    parameters = parameter_names(dataset)
    own = {name: stored for name, stored in parameters.items() if dataset[stored].ndim}
    texts = [map(words.text, over_cases(dataset, name).tolist()) for name in own.values()]
    return {
        "fixed": [
            (name, words.text(dataset[stored].item()), words.unit(dataset, stored))
            for name, stored in parameters.items()
            if dataset[stored].ndim == 0 and is_there(dataset[stored].item())
        ],
        "own": [
            f"{name} [{unit}]" if (unit := words.unit(dataset, stored)) else name
            for name, stored in own.items()
        ],
        "values": list(zip(*texts, strict=True)),
    }


def _names(dataset: xr.Dataset) -> list[str]:
    """The variables that get a column; each has one value per case."""
    wanted = (
        *varied_names(dataset),
        "status",
        *with_role(dataset, Role.HEADLINE),
        PRESSURE,
        *(with_role(dataset, Role.REASON) if any(reasons_of(dataset)) else []),
        *([f"{PRESSURE}_{REASON}"] if any(own_reasons_of_pressure(dataset)) else []),
        *([error_name(dataset)] if error_name(dataset) else []),
        *with_role(dataset, Role.DEVIATION),
        *limits_of(dataset),
        *("run_time", "peak_memory"),
        *(["message"] if any(over_cases(dataset, "message").tolist()) else []),
    )
    dims = set(dataset["status"].dims)
    return [
        str(name)
        for name in dict.fromkeys(wanted)
        # Variables that are the same in all cases are listed elsewhere; a single case has no dims.
        if name in dataset and set(dataset[name].dims) <= dims and (dataset[name].ndim or not dims)
    ]


def _column(dataset: xr.Dataset, name: str) -> Column:
    values = [words.in_unit(dataset, name, value) for value in over_cases(dataset, name).tolist()]
    forms: dict[str, Callable[[Any], str]] = {
        Role.DEVIATION: words.percent,
        Role.PARAMETER: words.text,
    }
    role, usual = str(dataset[name].attrs.get("role")), functools.partial(words.text, digits=3)
    texts = list(map(forms.get(role, usual), values))
    if name in with_role(dataset, Role.HEADLINE):
        rows = zip(values, uncertainty_of(dataset).tolist(), reasons_of(dataset), strict=True)
        texts = list(itertools.starmap(_with_half_width, rows))
    elif (own := f"{name}_uncertainty") in dataset:
        reasons = [why if is_there(why) else "" for why in over_cases(dataset, f"{name}_{REASON}")]
        rows = zip(values, over_cases(dataset, own).tolist(), reasons, strict=True)
        texts = list(itertools.starmap(_with_half_width, rows))
    if role == Role.DEVIATION:
        applies = where_it_applies(dataset, name.removeprefix(f"{role}_"))
        pairs = zip(texts, over_cases(dataset, applies), strict=True)
        texts = [it if inside or it == words.MISSING else f"[{it}]" for it, inside in pairs]
    title = "outcome" if name == "status" else words.title(dataset, name)
    is_number = dataset[name].dtype.kind in "iuf"
    return Column(title, words.symbol(name), words.unit(dataset, name), is_number, texts)


def _with_half_width(value: float, half_width: float, reason: str) -> str:
    """A value as the command line states it, with its half width or why it has none."""
    if not math.isfinite(value):
        return words.MISSING
    return stated(value, half_width, reason).replace("+-", "±")


MOST_VALUES = 6
"""Up to so many values of a parameter are listed; of more only the ends."""

Key = tuple[tuple[str, str], ...]
"""Names and values of the parameters of a soil and cone, without those of the method."""


def comparisons(datasets: list[xr.Dataset]) -> list[dict[str, Any]]:
    """The variables of page.html for each scene that several studies have.

    `differing` has a row for each parameter that is not the same in all studies: name, and values
    in each study. `shared` has a row for each soil and cone that several studies have: the values
    of the parameters in `varied`, the headline in each study, and the relative difference of the
    last from the first.
    """
    groups: dict[tuple[str, str], list[Studied]] = {}
    for dataset in datasets:
        studied = Studied.of(dataset)
        if studied is not None:
            groups.setdefault((str(dataset.attrs["scene"]), studied.headline), []).append(studied)
    return [_comparison(scene, group) for (scene, _), group in groups.items() if len(group) > 1]


def _comparison(scene: str, group: list[Studied]) -> dict[str, Any]:
    soils = [_by_soil(studied) for studied in group]
    shared = [key for key, count in Counter(itertools.chain(*soils)).items() if count > 1]
    counts = Counter(name for name, _ in dict.fromkeys(itertools.chain(*shared)))
    varied = [name for name, count in counts.items() if count > 1]
    first = group[0]
    unit = words.unit(first.dataset, first.headline)
    parameters = dict.fromkeys(name for it in group for name in parameter_names(it.dataset))
    differing = [
        [name.replace("_", " "), *(_values(it.dataset, name) for it in group)]
        for name in parameters
    ]
    return {
        "scene": scene,
        "headline": f"{words.title(first.dataset, first.headline)} {unit}".rstrip(),
        "studies": [str(studied.dataset.attrs["study"]) for studied in group],
        "differing": [row for row in differing if len(set(row[1:])) > 1],
        "varied": [name.replace("_", " ") for name in varied],
        "shared": [_row(key, varied, soils) for key in shared],
    }


def _row(key: Key, varied: list[str], soils: list[dict[Key, float]]) -> list[str]:
    found = [soil.get(key, np.nan) for soil in soils]
    known = [value for value in found if np.isfinite(value)]
    change = known[-1] / known[0] - 1.0 if len(known) > 1 and known[0] else np.nan
    values = (dict(key).get(name, words.MISSING) for name in varied)
    return [*values, *(words.text(entry, digits=3) for entry in found), words.percent(change)]


def _by_soil(studied: Studied) -> dict[Key, float]:
    """The headline by soil and cone; of several settings of the method the costliest is used."""
    dataset = studied.dataset
    names = {
        name: stored
        for name, stored in parameter_names(dataset).items()
        if stored not in studied.method
    }
    # Sorted, because the order of parameters in a result depends on which of them vary.
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


def _values(dataset: xr.Dataset, name: str) -> str:
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
