"""The spread of results in a study whose parameters have distributions.

The cases of such a study are a Latin hypercube sample of the inputs. So mean, standard deviation
and percentiles are those of the cases; a case that several samples give is counted as often. The
numerical error, with a standard deviation of U / 1.96, is added in squares:

    combined U = 1.96 sqrt(deviation^2 + mean of (U / 1.96)^2)

The first-order share of an input is the fraction of the variance that vanishes if that input is
known (Saltelli et al. 2008, chapter 4). `scipy.stats.sobol_indices` computes it from a quadratic
polynomial fitted to the cases. The logarithm of an input is used if it is more symmetric than the
input. The share `together` is the rest: what the polynomial misses by leave-one-out
cross-validation, and what only several inputs do together.
"""

import functools
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    DISTRIBUTION,
    DRAWS,
    freely_varied,
    headlines_of,
    known_digits,
    over_cases,
    stated,
    uncertainty_of,
)
from harness.compare.linear_fit import linear_fit
from mpm_warp.grid.fitted import Floats

PERCENTILES = (5, 50, 95)
DEVIATIONS = 1.96
"""Ratio of the half width of 95 % to the standard deviation."""
CASES_A_TERM = 2
"""Cases needed for each term of the polynomial; with fewer no shares are given."""
SAMPLES = 2**12
"""Samples of the polynomial, which give its shares to 1 %."""
NUMERICAL, TOGETHER = "numerical error", "together"


@dataclass(frozen=True)
class Spread:
    """The spread of a result."""

    name: str
    values: Floats  # of the samples that have one, shape [samples]
    mean: float  # mean, deviation and percentiles are without the numerical error
    deviation: float
    percentiles: Floats  # at `PERCENTILES`
    numerical: float  # standard deviation of the numerical error; 0 if that of a case is unknown
    # shares of the inputs, the numerical error and the rest in the total variance; their sum is 1;
    # empty if there are too few samples
    shares: Mapping[str, float]
    needed: int  # samples needed to give shares

    @property
    def combined(self) -> float:
        """Half width of 95 % from inputs and numerical error, for a normal distribution."""
        return DEVIATIONS * math.hypot(self.deviation, self.numerical)

    @property
    def called(self) -> str:
        """Name of `combined`, which depends on whether the numerical error is known."""
        return "combined U" if self.numerical else "U of the inputs"


def spreads_of(dataset: xr.Dataset) -> list[Spread]:
    """The spread of each headline in a study of one scene; empty without distributions."""
    names = freely_varied(dataset) if "status" in dataset else []
    if "scene" in names or not any(DISTRIBUTION in dataset[name].attrs for name in names):
        return []
    columns = {name: over_cases(dataset, name) for name in names}
    inputs = {
        name: column.astype(float) for name, column in columns.items() if column.dtype.kind in "if"
    }
    half_widths = uncertainty_of(dataset).astype(float)
    draws = over_cases(dataset, dataset.get(DRAWS, 1))
    found = []
    for name in headlines_of(dataset):
        values = over_cases(dataset, name)
        sound = np.repeat(np.arange(len(values)), np.where(np.isfinite(values), draws, 0))
        if len(sound) > 1:
            drawn = {name: numbers[sound] for name, numbers in inputs.items()}
            found.append(_spread(name, drawn, values[sound], half_widths[sound]))
    return found


def _spread(name: str, inputs: Mapping[str, Floats], values: Floats, half_widths: Floats) -> Spread:
    numerical = math.sqrt(np.mean((half_widths / DEVIATIONS) ** 2))
    if not math.isfinite(numerical):
        numerical = 0.0
    variance = values.var(ddof=1)
    needed = CASES_A_TERM * len(_exponents(len(inputs)))
    shares: dict[str, float] = {}
    if len(values) >= needed and variance > 0.0:
        of_inputs = variance / (variance + numerical**2)
        shares = {it: of_inputs * share for it, share in first_order(inputs, values).items()}
        if numerical:
            shares[NUMERICAL] = 1.0 - of_inputs
        shares[TOGETHER] = max(0.0, 1.0 - sum(shares.values()))
    return Spread(
        name=name,
        values=values,
        mean=float(values.mean()),
        deviation=math.sqrt(variance),
        percentiles=np.percentile(values, PERCENTILES),
        numerical=numerical,
        shares=shares,
        needed=needed,
    )


def first_order(inputs: Mapping[str, Floats], values: Floats) -> dict[str, float]:
    """First-order share of each independent input, shape [cases], in the variance of `values`."""
    from scipy.stats import sobol_indices

    drawn = [_straightened(numbers) for numbers in inputs.values()]
    exponents = _exponents(len(drawn))

    def terms(points: Floats) -> Floats:
        product: Floats = np.prod(points[:, None, :] ** exponents.T[:, :, None], axis=0)
        return product.T  # [points, terms]

    matrix = terms(np.stack(drawn))
    weights, _ = fit = linear_fit(matrix, values)
    explained = fit.explained(values)
    if len(drawn) == 1:  # SciPy needs at least two inputs
        return dict.fromkeys(inputs, explained)
    found = sobol_indices(
        func=lambda points: terms(points) @ weights,
        n=SAMPLES,
        dists=[SimpleNamespace(ppf=functools.partial(np.quantile, it)) for it in drawn],
        rng=np.random.default_rng(1),
    )
    shares = explained * np.maximum(found.first_order, 0.0)
    return dict(zip(inputs, shares.tolist(), strict=True))


def _straightened(values: Floats) -> Floats:
    """An input, or its logarithm if that is more symmetric, scaled to -1 to 1."""
    from scipy.stats import skew

    if values.min() > 0.0 and abs(skew(np.log(values))) < abs(skew(values)):
        values = np.log(values)
    low, high = values.min(), values.max()
    scaled: Floats = (2.0 * values - (low + high)) / max(high - low, 1e-300)
    return scaled


def _exponents(count: int) -> np.ndarray:
    """Exponent of each input in each term of the polynomial, shape [terms, inputs]."""
    powers = np.eye(count + 1, dtype=int)[:, 1:]  # the first row is the constant
    return np.array([a + b for a, b in itertools.combinations_with_replacement(powers, 2)])


def spread_rows(spread: Spread) -> list[tuple[str, str]]:
    """Names and values of the parts of a spread, in words."""
    half = DEVIATIONS * spread.numerical
    low, middle, high = (
        known_digits(percentile, spread.deviation / 3.0) for percentile in spread.percentiles
    )
    rows = [
        (f"mean with the {spread.called}", stated(spread.mean, spread.combined)),
        ("deviation by the inputs", f"{spread.deviation:.3g}"),
        ("median", middle),
        ("90 % of the samples", f"{low} to {high}"),
        ("U of the inputs alone", f"{DEVIATIONS * spread.deviation:.2g}"),
        ("numerical U", f"{half:.2g}" if half else "not known"),
    ]
    shares = sorted(spread.shares.items(), key=lambda it: -it[1])
    text = ", ".join(f"{name} {share:.0%}" for name, share in shares)
    too_few = f"unknown: {spread.needed} samples are needed"
    return [*rows, ("share of the variance", text or too_few)]


def spread_notes(dataset: xr.Dataset) -> list[str]:
    """Lines on the spread of each headline; empty without distributions."""
    notes = []
    for spread in spreads_of(dataset):
        notes += [
            "",
            f"{spread.name} by the distributions of its inputs, {len(spread.values)} samples:",
        ]
        notes += [f"  {what}: {value}" for what, value in spread_rows(spread)]
    return notes
