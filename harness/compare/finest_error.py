"""Errors without an exact solution: the difference of each case from the most accurate one."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    Role,
    alike,
    error_of_settings,
    headline_values,
    over_cases,
    parameter_names,
    spoken,
    uncertainty_of,
    with_role,
)
from harness.compare.compared import NothingToCompareError
from harness.study.compared import ERROR, ERROR_FINEST

FLOOR = "error_floor"
"""Relative uncertainty of the reference; an error below it cannot be distinguished from 0."""


def error_name(dataset: xr.Dataset) -> str | None:
    """Name of the error in a result, preferably that against an exact solution; None without."""
    return next((name for name in (ERROR, ERROR_FINEST) if name in dataset), None)


def states_its_error(dataset: xr.Dataset) -> np.ndarray:
    """Whether each case states its own uncertainty; all true if no case of the result does.

    A case without one may be near the reference only because two errors cancel.
    """
    known: np.ndarray = np.isfinite(uncertainty_of(dataset))
    return known if known.any() else np.ones_like(known)


def credited_error(dataset: xr.Dataset) -> np.ndarray:
    """The relative error by which the settings of each case are judged, shape [case].

    It is the greatest of three: the measured error, the uncertainty of the reference, and the
    stated half width over the headline. The last is included because a measured error may be small
    in this soil only, where two errors cancel. NaN where no error is known.
    """
    measured = over_cases(dataset, str(error_name(dataset))).astype(float)
    floor = over_cases(dataset, FLOOR).astype(float)
    error: np.ndarray = np.fmax(measured, np.where(np.isfinite(measured), floor, np.nan))
    half_width = uncertainty_of(dataset)
    if not np.isfinite(half_width).any():
        return error
    headline = np.abs(headline_values(dataset))
    return np.where(states_its_error(dataset), np.fmax(error, half_width / headline), np.nan)


def with_finest_error(
    dataset: xr.Dataset, method: Sequence[str], reference: xr.Dataset | None = None
) -> xr.Dataset:
    """Add the difference of each case from the most accurate one, unless exact errors are known.

    Only cases that differ in nothing but parameters of the method are compared. The most accurate
    of them is, in this order: the case of the reference, if one is given; the case with the
    smallest stated uncertainty, without the parts of it that a longer run makes smaller; the case
    with most particle updates. It has no error itself. Its
    relative uncertainty becomes `error_floor`, below which an error means nothing. A case whose
    headline has not settled gets no error and is never the most accurate one.

    The dataset has one scene; `method` has the names of the parameters of its method.
    """
    headlines = with_role(dataset, Role.HEADLINE)
    if ERROR in dataset or not (method and headlines and "particle_updates" in dataset):
        return dataset
    values, _, is_settled = _settled_headlines(dataset)
    given = {} if reference is None else _best_known(reference, method)
    groups = _alike(dataset, method)
    if given and not given.keys() & groups.keys():
        raise NothingToCompareError("none of its cases has the soil and cone of a case here")
    best = _best_known(dataset, method)
    error, floor = np.full(values.shape, np.nan), np.full(values.shape, np.nan)
    for soil in groups.keys() & {*given, *best}:
        known = given.get(soil) or best[soil]
        others = groups[soil][is_settled[groups[soil]]]
        if soil not in given:
            others = others[others != known.case]
        error[others] = np.abs(values[others] / known.value - 1.0)
        floor[others] = known.half_width / known.value
    description = (
        "relative difference from the most accurate of the cases that differ only in the method: "
        "that with the smallest U (without steadiness and noise), or else with most particle "
        "updates, which has no error itself"
        if reference is None
        else f"relative difference from the result of the study {reference.attrs['study']}"
    )
    of_error = {"long_name": f"error of the {spoken(headlines[0])}", "description": description}
    of_floor = {
        "long_name": "relative uncertainty of the reference of the error",
        "description": "an error below it cannot be distinguished from 0",
    }
    status = dataset["status"]
    added = {
        name: (status.dims, values.reshape(status.shape), {"units": "1"} | labels)
        for name, values, labels in (
            (ERROR_FINEST, error, of_error | {"role": Role.ERROR}),
            (FLOOR, floor, of_floor),
        )
        if np.isfinite(values).any()
    }
    return dataset.assign(added)


class _Known(NamedTuple):
    """The most accurate case of a group, and its headline."""

    case: int
    value: float
    half_width: float


def _best_known(dataset: xr.Dataset, method: Sequence[str]) -> dict[tuple[object, ...], _Known]:
    """The most accurate case of each group of cases that differ only in the method."""
    values, half_width, is_settled = _settled_headlines(dataset)
    own, cost = error_of_settings(dataset), over_cases(dataset, "particle_updates")
    best = {}
    for soil, group in _alike(dataset, method).items():
        cases = group[is_settled[group]]
        with_half_width = cases[np.isfinite(half_width[cases])]
        if len(with_half_width):
            cases = with_half_width[[np.argmin(own[with_half_width])]]
        if len(cases):
            case = int(cases[np.argmax(cost[cases])])
            best[soil] = _Known(case, float(values[case]), float(half_width[case]))
    return best


def _settled_headlines(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Headline and half width of each case, and whether the headline is finite and has settled."""
    values = over_cases(dataset, with_role(dataset, Role.HEADLINE)[0])
    settled = over_cases(dataset, next(iter(with_role(dataset, Role.SETTLED)), 1.0)) != 0.0
    return values, uncertainty_of(dataset), np.isfinite(values) & settled


def _alike(dataset: xr.Dataset, method: Sequence[str]) -> dict[tuple[object, ...], np.ndarray]:
    """Indices of the cases that agree in all parameters but those of the method, by group."""
    stored = {name: own for name, own in parameter_names(dataset).items() if name not in method}
    names = sorted(stored)
    groups = alike(dataset, [stored[name] for name in names])
    return {(*names, *values): np.array(group) for values, group in groups.items()}
