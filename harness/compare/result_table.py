"""The result of a study as a table: beside the literature's cone factors, or exact solutions."""

from __future__ import annotations

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    CASE,
    COMPLETED,
    Role,
    limits_of,
    over_cases,
    scenes_of,
    spoken,
    with_role,
)
from harness.compare.cone_factor_table import cone_factor_table
from harness.compare.cone_factors import NothingToCompareError
from harness.compare.finest_error import error_name
from harness.compare.text_table import (
    Column,
    heading,
    number,
    parameter_columns,
    run_columns,
    table_lines,
    with_half_width,
)
from harness.references.cone_factors import COMPARED


def result_table(dataset: xr.Dataset) -> str:
    """A text table for a terminal: one row a case, and how to read it below.

    Where cone factors stand beside results of other scenes, these have a table of their own.

    Raises:
        NothingToCompareError: no case has a result, or a cone factor lacks its parameters.
    """
    if COMPARED not in dataset:
        return _exact_table(dataset)
    scenes = np.array(scenes_of(dataset))
    of_cones = np.isin(scenes, scenes[np.isfinite(over_cases(dataset, COMPARED).astype(float))])
    if of_cones.all() or not of_cones.any():
        return cone_factor_table(dataset)
    tables = cone_factor_table(_cases(dataset, of_cones)), _exact_table(_cases(dataset, ~of_cones))
    return "\n\n".join(tables)


def _cases(dataset: xr.Dataset, chosen: np.ndarray) -> xr.Dataset:
    """Some cases of several scenes, with the variables that they have."""
    part = dataset.isel({CASE: np.flatnonzero(chosen)})
    return part.drop_vars([name for name, it in part.data_vars.items() if it.isnull().all()])


def _exact_table(dataset: xr.Dataset) -> str:
    """What each case was run for, its exact value, and its error."""
    headlines = [it for it in with_role(dataset, Role.HEADLINE) if _is_one_a_case(dataset, it)]
    error = error_name(dataset)
    headlines = [it for it in headlines if it != error]
    if not headlines and error is None:
        raise NothingToCompareError(_why_nothing(dataset))
    columns = parameter_columns(dataset)
    notes = []
    for name in headlines:
        columns.append(_headline_column(dataset, name))
        notes.append(_note(dataset, name))
        exact = f"{name}_exact"
        if exact in dataset and _is_one_a_case(dataset, exact):
            columns.append(_column(dataset, exact, ".4g"))
            notes.append(_note(dataset, exact))
    if error is not None:
        columns.append(_column(dataset, error, ".2%"))
        notes.append(_note(dataset, error))
    for name, limit in limits_of(dataset).items():
        if name != error and name not in headlines and _is_one_a_case(dataset, name):
            columns.append(_column(dataset, name, ".2%"))
            notes.append(f"{_note(dataset, name)}; at most {limit:g}")
    lines = table_lines([*columns, *run_columns(dataset)])
    return "\n".join([*lines, "", *notes])


def _is_one_a_case(dataset: xr.Dataset, name: str) -> bool:
    return set(dataset[name].dims) <= set(dataset["status"].dims)


def _column(dataset: xr.Dataset, name: str, form: str) -> Column:
    return Column(heading(name), [number(value, form) for value in over_cases(dataset, name)])


def _headline_column(dataset: xr.Dataset, name: str) -> Column:
    half_width = f"{name}_uncertainty"
    if half_width not in with_role(dataset, Role.UNCERTAINTY):
        return _column(dataset, name, ".4g")
    pairs = zip(over_cases(dataset, name), over_cases(dataset, half_width), strict=True)
    return Column(heading(name), [with_half_width(value, half) for value, half in pairs])


def _note(dataset: xr.Dataset, name: str) -> str:
    """What a variable is, in its own words."""
    said = dataset[name].attrs
    unit = "" if said.get("units", "1") == "1" else f" [{said['units']}]"
    told = f"; {said['description']}" if "description" in said else ""
    return f"{name}: {said.get('long_name', spoken(name))}{unit}{told}"


def _why_nothing(dataset: xr.Dataset) -> str:
    completed = int((dataset["status"] == COMPLETED).sum())
    if completed == 0:
        return f"nothing to compare: no case of {dataset['status'].size} completed"
    return "nothing to compare: the scene has neither a headline nor an error"
