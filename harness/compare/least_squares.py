"""The error of the mesh by least squares over several meshes, after Eca and Hoekstra (2014).

A value on meshes with cells of width h is fitted by

    value = limit + a h^p

with weights 1/h and without weights. Of the fits with an order p of 0.5 to 2 the one with the
smaller scatter s is kept. If there is none, fits with p = 1 and p = 2 are tried, and if p is below
0.5 also limit + a h + b h^2. Let d be the range of the values divided by their number less 1,
e = |fit - limit| and r = |value - fit|. Then the half width of 95 % of a mesh is

    F e + s + r                if s < d; F = 1.25 for an order of 0.5 to 2, else 3
    3 s / d (e + s + r)        otherwise

Source: L. Eca, M. Hoekstra, J. Comput. Phys. 262 (2014) 104-130.
"""

import operator
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import alike, over_cases, stated, varied_names
from harness.compare.columns import MISSING, column, half_width_column, parameter_columns, table
from harness.compare.compared import NothingToCompareError
from harness.compare.result_table import RESOLUTION
from mpm_warp.uncertainty.laws import CURVATURE_POWER

ORDERS = np.linspace(0.05, 8.0, 1591)
"""Orders that a fit tries, in steps of 0.005."""
LEAST, GREATEST = 0.5, 2.0
"""Range of fitted orders that are accepted."""
FEWEST = 4
"""Number of meshes that a fit needs."""
SIMULATED, CORRECTED = "cone_factor_simulated", "cone_factor"
"""The result that is fitted, and the one shown beside it."""
SAFE, UNSAFE = 1.25, 3.0
"""Safety factor F with an accepted order, and without."""


@dataclass(frozen=True)
class Fit:
    """A fit of values over meshes."""

    order: float  # the accepted order, or the mean of both fitted orders if none was accepted
    is_accepted: bool  # whether an order was from `LEAST` to `GREATEST`
    limit: float  # the value for h = 0
    half_widths: np.ndarray  # of each value, 95 %, shape [n]


def fit(sizes: Sequence[float], values: Sequence[float]) -> Fit:
    """Fit values on at least four meshes with cells of width h = `sizes` > 0."""
    size, value = np.array(sizes), np.array(values)
    weights = [np.ones(size.size), size.size / size / (1.0 / size).sum()]
    # Each fit is its scatter, fitted values, limit and order.
    best = [
        min(
            ((*_fitted([size**order], value, weight, 3), order) for order in ORDERS.tolist()),
            key=_scatter,
        )
        for weight in weights
    ]
    accepted = [one for one in best if LEAST <= one[3] <= GREATEST]
    if accepted:
        scatter, fitted, limit, order = min(accepted, key=_scatter)
    else:
        order = float(np.mean([one[3] for one in best]))
        sums = [[size], [size**2]] + [[size, size**2]] * any(one[3] < LEAST for one in best)
        fits = [_fitted(sum_, value, weight, 1 + len(sum_)) for sum_ in sums for weight in weights]
        scatter, fitted, limit = min(fits, key=_scatter)
    spread = np.ptp(value) / (size.size - 1)
    error, residual = np.abs(fitted - limit), np.abs(value - fitted)
    if scatter < spread:
        half = (SAFE if accepted else UNSAFE) * error + scatter + residual
    else:
        half = UNSAFE * scatter / spread * (error + scatter + residual)
    return Fit(order, bool(accepted), limit, half)


_scatter = operator.itemgetter(0)


def _fitted(
    terms: Sequence[np.ndarray], value: np.ndarray, weight: np.ndarray, unknowns: int
) -> tuple[float, np.ndarray, float]:
    """Scatter, fitted values and limit of a sum of terms, by weighted least squares."""
    system = np.stack([np.ones(value.size), *terms], axis=1)
    root = np.sqrt(weight)
    found, *_ = np.linalg.lstsq(system * root[:, None], value * root, rcond=None)
    fitted = system @ found
    scatter = np.sqrt((weight * (value - fitted) ** 2).sum() / (value.size - unknowns))
    return float(scatter), fitted, float(found[0])


def least_squares_table(dataset: xr.Dataset) -> str:
    """A text table of cone factors with U by least squares, beside their stated U."""
    names = [parameter for parameter in varied_names(dataset) if parameter != RESOLUTION]
    values = over_cases(dataset, SIMULATED).astype(float)
    sizes = 1.0 / over_cases(dataset, RESOLUTION).astype(float)
    texts = np.full((3, values.size), MISSING, dtype=object)
    is_known = np.isfinite(values) & np.isfinite(sizes)
    for group in alike(dataset, names).values():
        cases = [case for case in group if is_known[case]]
        if np.unique(sizes[cases]).size >= FEWEST:
            found = fit(sizes[cases].tolist(), values[cases].tolist())
            texts[0, cases] = list(map(stated, values[cases].tolist(), found.half_widths.tolist()))
            texts[1, cases] = f"{found.limit:.2f}"
            texts[2, cases] = f"{found.order:.1f}{'' if found.is_accepted else ', not accepted'}"
    if (texts == MISSING).all():
        raise NothingToCompareError(
            f"least squares: needs cone factors with {FEWEST} values of {RESOLUTION} and all else "
            "equal"
        )
    headings = ("as simulated,_U by least squares", "its_limit", "its_order")
    columns = [
        *parameter_columns(dataset),
        *(column(heading, row) for heading, row in zip(headings, texts, strict=True)),
        half_width_column(dataset, CORRECTED, "cone factor,_its own U"),
    ]
    notes = [
        "U by least squares: mesh only, by Eca & Hoekstra, J. Comput. Phys. 262 (2014) 104;",
        f"an order outside {LEAST:g} to {GREATEST:g} is not accepted, and U is then large",
        "its own U: of the corrected value, from mesh, speed, window and noise; the error of",
        f"the mesh is B h + Q h^{CURVATURE_POWER:g} + C g^1.5 h^1.3, whose terms partly cancel, so",
        "that no single power of h fits it",
    ]
    return table(columns, notes)
