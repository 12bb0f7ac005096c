"""The error of a mesh by least squares over several, as Eca and Hoekstra (2014) estimate it.

A value on meshes of cells h is fitted by

    value = limit + a h^p

with the weights 1/h and without, and the fit of less scatter s is kept whose order p is 0.5 to 2.
Where none is, p is set to 1 or 2, and for p below 0.5 a h + b h^2 is tried too. With d the range of
the values over their number less 1, e = |fit - limit|, r = |value - fit|, of a mesh, its half width
of 95 % is

    F e + s + r                where s < d, F = 1.25 for an order of 0.5 to 2, else 3
    3 s / d (e + s + r)        elsewhere

Source: L. Eca, M. Hoekstra, J. Comput. Phys. 262 (2014) 104-130.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import alike, over_cases, stated, varied_names
from harness.compare.compared import NothingToCompareError
from harness.compare.result_table import (
    MISSING,
    RESOLUTION,
    column,
    half_width_column,
    parameter_columns,
    table,
)
from mpm_warp.uncertainty.laws import CURVATURE_POWER

ORDERS = np.linspace(0.05, 8.0, 1591)
"""Among which the order of a fit is sought; steps of 0.005."""
LEAST, GREATEST = 0.5, 2.0
"""Orders that are taken as they are fitted."""
FEWEST = 4
"""Meshes that a fit needs."""
SIMULATED, CORRECTED = "cone_factor_simulated", "cone_factor"
"""What is fitted, and what stands beside it."""
TRUSTED, DOUBTED = 1.25, 3.0
"""F of an order that is taken as it is fitted, and of others."""


@dataclass(frozen=True)
class Fit:
    """A fit of values over meshes."""

    order: float  # fitted, the mean of both weights where it was not taken
    is_taken: bool  # whether the order is within `LEAST` to `GREATEST`
    limit: float  # the value with cells of no width
    half_widths: np.ndarray  # of each value, 95 %, shape [n]


def fit(sizes: Sequence[float], values: Sequence[float]) -> Fit:
    """The fit of values on meshes whose cells are h = `sizes`, four at least, all > 0."""
    size, value = np.array(sizes), np.array(values)
    weights = [np.ones(size.size), size.size / size / (1.0 / size).sum()]
    free = [
        min(
            ((order, *_line([size**order], value, weight, 3)) for order in ORDERS.tolist()),
            key=lambda it: it[1],
        )
        for weight in weights
    ]
    taken = [tried_fit for tried_fit in free if LEAST <= tried_fit[0] <= GREATEST]
    order = float(np.mean([tried_fit[0] for tried_fit in free]))
    if taken:
        order, scatter, fitted, limit = min(taken, key=lambda it: it[1])
    else:
        terms = [[size], [size**2]] + [[size, size**2]] * any(
            tried_fit[0] < LEAST for tried_fit in free
        )
        tried = [_line(of, value, weight, 1 + len(of)) for of in terms for weight in weights]
        scatter, fitted, limit = min(tried, key=lambda it: it[0])
    spread = np.ptp(value) / (size.size - 1)
    error, residual = np.abs(fitted - limit), np.abs(value - fitted)
    if scatter < spread:
        half = (TRUSTED if taken else DOUBTED) * error + scatter + residual
    else:
        half = DOUBTED * scatter / spread * (error + scatter + residual)
    return Fit(order, bool(taken), limit, half)


def _line(
    terms: Sequence[np.ndarray], value: np.ndarray, weight: np.ndarray, unknowns: int
) -> tuple[float, np.ndarray, float]:
    """Scatter, fit and limit of a sum of terms, by weighted least squares."""
    system = np.stack([np.ones(value.size), *terms], axis=1)
    root = np.sqrt(weight)
    found, *_ = np.linalg.lstsq(system * root[:, None], value * root, rcond=None)
    fitted = system @ found
    scatter = np.sqrt((weight * (value - fitted) ** 2).sum() / (value.size - unknowns))
    return float(scatter), fitted, float(found[0])


def least_squares_table(dataset: xr.Dataset) -> str:
    """A text table for a terminal: cone factors with U by least squares, and with their own."""
    names = [parameter for parameter in varied_names(dataset) if parameter != RESOLUTION]
    values = over_cases(dataset, SIMULATED).astype(float)
    sizes = 1.0 / over_cases(dataset, RESOLUTION).astype(float)
    texts = np.full((3, values.size), MISSING, dtype=object)
    is_known = np.isfinite(values) & np.isfinite(sizes)
    for group in alike(dataset, names).values():
        cases = [case for case in group if is_known[case]]
        if np.unique(sizes[cases]).size >= FEWEST:
            found = fit(sizes[cases].tolist(), values[cases].tolist())
            told = map(stated, values[cases].tolist(), found.half_widths.tolist())
            texts[0, cases] = list(told)
            texts[1, cases] = f"{found.limit:.2f}"
            texts[2, cases] = f"{found.order:.1f}{'' if found.is_taken else ', not taken'}"
    if (texts == MISSING).all():
        raise NothingToCompareError(
            f"least squares: no cone factor on {FEWEST} values of {RESOLUTION} with all else alike"
        )
    headings = ("as simulated,_U by least squares", "its_limit", "its_order")
    columns = [
        *parameter_columns(dataset),
        *(column(heading, row) for heading, row in zip(headings, texts, strict=True)),
        half_width_column(dataset, CORRECTED, "cone factor,_its own U"),
    ]
    notes = [
        "least squares: Eca & Hoekstra, J. Comput. Phys. 262 (2014) 104, of the mesh alone;",
        f"an order outside {LEAST:g} to {GREATEST:g} is not taken, and U is then large",
        "its own U: of mesh, speed, window and noise, of the corrected value; the error of the",
        f"mesh, B h + Q h^{CURVATURE_POWER:g} + C g^1.5 h^1.3, whose terms cancel: no power fits",
    ]
    return table(columns, notes)
