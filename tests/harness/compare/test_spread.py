"""The spread of a study by the distributions of its inputs: closed forms."""

import math

import numpy as np
import pytest
import xarray as xr
from scipy.stats.qmc import LatinHypercube

from harness.archive.conventions import COMPLETED, DISTRIBUTION
from harness.compare.spread import NUMERICAL, TOGETHER, first_order, spread_rows, spreads_of

COUNT = 1024
DRAWN = dict(zip("abc", LatinHypercube(3, rng=1).random(COUNT).T, strict=True))
"""Numbers from 0 to 1, whose variance is 1/12."""


def study(values: np.ndarray, half_width: float, **inputs: np.ndarray) -> xr.Dataset:
    """A study whose parameters are distributions, with its headline."""
    case = ("case",)
    dataset = xr.Dataset(
        {
            "factor": (case, values, {"role": "headline"}),
            "factor_uncertainty": (case, np.full(len(values), half_width), {"role": "uncertainty"}),
            "status": (case, np.full(len(values), COMPLETED)),
        },
        {name: (case, it, {DISTRIBUTION: "low 0, high 1"}) for name, it in inputs.items()},
    )
    return dataset.assign_coords(case=np.arange(len(values)))


def test_first_order_shares_are_those_of_a_polynomial() -> None:
    """Of a + b^2 + (c - 1/2)(a - 1/2): 1/12, 4/45 and 1/144 by both together."""
    a, b, c = DRAWN.values()
    shares = first_order(DRAWN, a + b**2 + (c - 0.5) * (a - 0.5))
    total = 1 / 12 + 4 / 45 + 1 / 144
    # Chance correlates two inputs by 1 over the root of the count, 0.03.
    assert shares["a"] == pytest.approx(1 / 12 / total, abs=0.02)
    assert shares["b"] == pytest.approx(4 / 45 / total, abs=0.02)
    assert shares["c"] == pytest.approx(0.0, abs=0.01)


def test_what_the_polynomial_does_not_tell_is_left() -> None:
    noise = np.random.default_rng(1).normal(size=COUNT)
    (found,) = spreads_of(study(DRAWN["a"] + noise / math.sqrt(12.0), math.nan, **DRAWN))
    assert found.shares["a"] == pytest.approx(0.5, abs=0.08)
    assert found.shares[TOGETHER] == pytest.approx(0.5, abs=0.08)
    assert NUMERICAL not in found.shares


def test_the_numerical_error_is_added_as_squares() -> None:
    values = np.exp(DRAWN["a"])
    (found,) = spreads_of(study(values, 1.96 * 3.0 * values.std(ddof=1), **DRAWN))
    assert found.mean == pytest.approx(math.e - 1.0, abs=1e-3)
    assert found.combined == pytest.approx(1.96 * math.sqrt(10.0) * values.std(ddof=1))
    assert found.shares[NUMERICAL] == pytest.approx(0.9)
    assert sum(found.shares.values()) == pytest.approx(1.0)
    assert found.percentiles == pytest.approx(np.exp([0.05, 0.5, 0.95]), abs=0.01)


def test_of_few_cases_no_shares_are_told() -> None:
    few = {name: it[:19] for name, it in DRAWN.items()}
    (found,) = spreads_of(study(few["a"], 0.1, **few))
    assert dict(spread_rows(found))["share of the variance"] == "not told: 20 cases are needed"


def test_a_study_without_distributions_has_no_spread() -> None:
    dataset = study(DRAWN["a"], 0.1, **DRAWN)
    for name in DRAWN:
        dataset[name].attrs.clear()
    assert spreads_of(dataset) == []
