"""Inputs that are not known exactly: a number, a range, or a distribution, and samples of them.

In the file of a site, and under [vary] of a study, each is written as harness/interpret/README.md
says. Percentiles are joined by straight lines, and the lines of the two outermost pairs go on to 0
and 100 %.

SciPy takes half a second to load; what has no distributions does not wait for it.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.study.tables import Table, is_number
from mpm_warp.arguments import Range
from mpm_warp.grid.fitted import Floats

Quantiles = Callable[[Floats], Floats]
"""Of shares between 0 and 1, shape [...], the values that so much lies below."""
WIDE_RANGE = 3.0
"""High over low from which on a range is uniform in its logarithm."""
FORMS = (
    ("low", "high"),
    ("low", "mode", "high"),
    ("mean", "deviation"),
    ("mean", "deviation", "shape"),
)
"""Keys that an input may have together; the other form is percentiles, p5, p50 say."""
PERCENTILE = r"p\d{1,2}"
HOW = (
    "a number, { low, high }, { low, mode, high }, { mean, deviation, shape } or { p10, p50, p90 }"
)
SURELY = 1e-6
"""Share beyond which the tails of a distribution are cut."""

INSIDE = 1e-9
"""From a bound that is not allowed itself, a sample beyond it; parameters have 12 digits."""


@dataclass(frozen=True)
class Input:
    """One input: how it is written, and its distribution."""

    text: str
    quantiles: Quantiles

    def at(self, share: float) -> float:
        """The value that a share, 0 to 1, lies below."""
        return float(self.quantiles(np.array(share)))


def known(value: float) -> Input:
    """An input that is one number."""
    return Input(f"{value:g}", lambda share: np.full_like(share, value))


def normal(deviation: float) -> Input:
    """An error around 0 [of the unit of `deviation`]."""
    if deviation == 0.0:
        return known(0.0)
    from scipy.stats import norm

    return Input(f"0 +- {deviation:g}", lambda share: norm.ppf(share, scale=deviation))


def is_distribution(value: Mapping[str, Any]) -> bool:
    """Whether a table is meant as a distribution: has a key that only these have."""
    names = {name for form in FORMS for name in form}
    return any(word in names or re.fullmatch(PERCENTILE, word) for word in value)


def read_input(table: Table, key: str, allowed: Range, words: Sequence[str] = ()) -> Input:
    """An input of a table of a file.

    Args:
        table: where it stands.
        key: its name.
        allowed: the range of what it may be; samples beyond are moved to its bounds, and a
            distribution whose middle is beyond is refused.
        words: what it may be besides, for the message.

    Raises:
        StudyError: it is none of the forms, or not allowed.
    """
    value = table.values[key]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if not allowed.holds(value, value):
            raise table.refuse(key, f"must be a number {allowed.allowed}")
        return known(float(value))
    if not isinstance(value, dict):
        raise table.refuse(key, f"must be {' or '.join([*words, HOW])}")
    for name, entry in value.items():
        if name != "shape" and not is_number(entry):
            raise table.refuse(key, f"{name} must be a number")
    quantiles = _distribution(table, key, value)
    middle, ends = quantiles(np.array(0.5)), quantiles(np.array([SURELY, 1.0 - SURELY]))
    if not (np.isfinite(ends).all() and allowed.holds(middle, middle)):
        raise table.refuse(key, f"its median {middle:g} must be {allowed.allowed}")
    if "mean" not in value and not allowed.holds(*ends):
        raise table.refuse(key, f"goes from {ends[0]:g} to {ends[1]:g}, must be {allowed.allowed}")
    low = max(allowed.minimum, allowed.above + INSIDE)
    high = min(allowed.maximum, allowed.below - INSIDE)
    text = ", ".join(f"{name} {entry}" for name, entry in value.items())
    return Input(
        text, lambda share: np.clip(quantiles(np.clip(share, SURELY, 1 - SURELY)), low, high)
    )


def _distribution(table: Table, key: str, value: dict[str, float | str]) -> Quantiles:
    """The quantiles of a distribution as it is written."""
    from scipy import stats

    if len(value) > 1 and all(re.fullmatch(PERCENTILE, name) for name in value):
        return _of_percentiles(table, key, value)
    if not any(value.keys() == set(form) for form in FORMS):
        raise table.refuse(key, f"must be {HOW}")
    shape = value.get("shape", "normal")
    chosen: Any
    match {name: float(entry) for name, entry in value.items() if name != "shape"}:
        case {"low": low, "high": high} if not low < high:
            raise table.refuse(key, "low must be below high")
        case {"low": low, "mode": mode, "high": high}:
            if not low <= mode <= high:
                raise table.refuse(key, "mode must be from low to high")
            chosen = stats.triang((mode - low) / (high - low), low, high - low)
        case {"low": low, "high": high} if low > 0.0 and high / low > WIDE_RANGE:
            chosen = stats.loguniform(low, high)
        case {"low": low, "high": high}:
            chosen = stats.uniform(low, high - low)
        case {"deviation": deviation} if not deviation > 0.0:
            raise table.refuse(key, "deviation must be > 0; without one it is a number")
        case {"mean": mean, "deviation": deviation} if shape == "lognormal" and mean > 0.0:
            width = np.sqrt(np.log1p((deviation / mean) ** 2))
            chosen = stats.lognorm(width, scale=mean * np.exp(-0.5 * width**2))
        case {"mean": mean, "deviation": deviation} if shape == "normal":
            chosen = stats.norm(mean, deviation)
        case _:
            raise table.refuse(key, "shape must be normal, or lognormal with a mean > 0")
    quantiles: Quantiles = chosen.ppf
    return quantiles


def _of_percentiles(table: Table, key: str, value: dict[str, float | str]) -> Quantiles:
    pairs = sorted((int(name[1:]) / 100.0, float(entry)) for name, entry in value.items())
    shares, values = np.array(pairs).T
    if not (np.diff(values) > 0.0).all():
        raise table.refuse(key, "percentiles must rise")
    slopes = np.diff(values) / np.diff(shares)
    ends = values[0] - shares[0] * slopes[0], values[-1] + (1.0 - shares[-1]) * slopes[-1]
    x, y = np.array([0.0, *shares, 1.0]), np.array([ends[0], *values, ends[1]])
    return lambda share: np.interp(share, x, y)


def sampled(inputs: dict[str, Input], count: int, seed: int) -> dict[str, Floats]:
    """Samples of inputs that are independent of each other, a Latin hypercube; each [count]."""
    from scipy.stats.qmc import LatinHypercube

    shares = LatinHypercube(len(inputs), rng=seed).random(count)
    columns = zip(inputs.items(), shares.T, strict=True)
    return {name: distribution.quantiles(share) for (name, distribution), share in columns}
