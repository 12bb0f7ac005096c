"""The effect of each input on a result, from cases that vary several: a sum of functions of one.

A number, or its logarithm, contributes a parabola by least squares, or a straight line if there are
fewer than two cases for each coefficient. A text contributes a constant for each of its values.
Inputs that go together have one effect.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from harness.compare.linear_fit import linear_fit, shared_variance
from mpm_warp.grid.fitted import Floats

MOST_SHARED = 0.9
"""Share of an input's variance that others may explain; with more no effect is its own.

There the error of its effect is three times that of an input independent of all others.
"""


class Input(NamedTuple):
    """The values of an input in all cases, shape [case]."""

    numbers: Floats  # of a text: the index of its value
    are_texts: bool
    is_logarithmic: bool  # whether its logarithm is used


class Effects(NamedTuple):
    """A fit of values by a sum of functions of one input each."""

    parts: dict[str, Floats]  # of each input with an effect of its own; mean 0 over cases used
    mean: float  # of the values over the cases used
    residual: Floats  # NaN for a case that was not used
    spread: float  # standard deviation of the error at cases that are left out of the fit
    explained: float  # share of the variance that the fit explains in such cases
    is_fitted: bool  # whether there were enough cases for a fit; if not, the parts are 0
    joined: dict[str, list[str]]  # inputs without an effect of their own; with which they go


def effects_of(inputs: Mapping[str, Input], values: Floats) -> Effects:
    """Fit the values of the cases; those that are NaN are not used.

    Columns that go with those of earlier inputs are left out: there is one effect of all of them.
    """
    used = np.isfinite(values)
    for degree in (2, 1):
        columns, joined = _independent(inputs, used, degree)
        matrix = np.hstack([np.ones((values.size, 1)), *columns.values()])
        is_fitted = bool(used.sum() >= 2 * matrix.shape[1])
        if is_fitted:
            break
    if not is_fitted:  # with so few cases inputs go together by chance
        every = {name: np.zeros(values.size) for name in inputs}
        mean = float(values[used].mean())
        residual = values - mean
        return Effects(every, mean, residual, float(np.nanstd(residual)), 0.0, False, {})
    fit = linear_fit(matrix[used], values[used])
    ends = np.cumsum([1, *(column.shape[1] for column in columns.values())])[:-1]
    (mean,), *found = np.split(fit.weights, ends)
    parts = dict(zip(columns, map(np.matmul, columns.values(), found), strict=True))
    return Effects(
        parts,
        float(mean),
        values - mean - np.sum(list(parts.values()), axis=0),
        float(np.sqrt(np.mean(fit.left_out**2))),
        fit.explained(values[used]),
        is_fitted,
        joined,
    )


def _independent(
    inputs: Mapping[str, Input], used: np.ndarray, degree: int
) -> tuple[dict[str, Floats], dict[str, list[str]]]:
    """The terms of inputs with an effect of their own, and with what each of the others goes.

    An input that is the same in all cases used goes with none.
    """
    kept: dict[str, Floats] = {}
    joined: dict[str, list[str]] = {}
    for name, values in inputs.items():
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


def _columns(values: Input, used: np.ndarray, degree: int) -> Floats:
    """The terms of the fit, shape [case, :]; over the cases used their mean is 0, and none is 0."""
    numbers = values.numbers
    if values.are_texts:
        columns = (numbers[:, None] == np.unique(numbers[used])[1:]).astype(float)
    else:
        place = np.log(numbers) if values.is_logarithmic else numbers
        count = np.unique(place[used]).size
        place = (place - place.min()) / np.ptp(place)
        columns = place[:, None] ** np.arange(1, 1 + min(degree, count - 1))
    centred: Floats = columns - columns[used].mean(axis=0)
    return centred
