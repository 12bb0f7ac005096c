"""Uncertain inputs: a number, a range or a distribution, and random samples of them.

They stand in site files and under [vary] of a study; harness/interpret/README.md lists the ways to
write them. Given percentiles are joined by straight lines. The first and the last line are extended
to 0 and 100 %.

The quantiles are written out: `scipy.stats` takes a second to load.
"""

import functools
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy  # loads special functions where they are first used: no other study waits for them

from harness.study.tables import is_number, table_schema
from mpm_warp.fields.declaration import Form, Parameter, Refused, Schema, bounds_schema, parameter
from mpm_warp.grid.fitted import Floats

Quantiles = Callable[[Floats], Floats]
"""Quantile function: from probabilities, 0 to 1, shape [...], to values of the same shape."""
WIDE_RANGE = 3.0
"""A positive range with a larger ratio high / low is uniform in its logarithm."""
FORMS = (
    ("low", "high"),
    ("low", "mode", "high"),
    ("mean", "deviation"),
    ("mean", "deviation", "shape"),
)
"""Sets of keys that describe a distribution. The other form is percentiles, such as p5 and p50."""
PERCENTILE = r"p[0-9]{1,2}"
HOW = (
    "a number, { low, high }, { low, mode, high }, { mean, deviation, shape } or { p10, p50, p90 }"
)
TAIL_SHARE = 1e-6
"""Probability at either end of a distribution that is cut off."""

BOUND_MARGIN = 1e-9
"""If a bound itself is not allowed, samples beyond it are moved this far inside it."""


@dataclass(frozen=True)
class Input:
    """One uncertain input."""

    text: str  # as the file gives it, for messages and tables
    quantiles: Quantiles

    def at(self, share: float) -> float:
        """The quantile of a probability `share`, 0 to 1."""
        return float(self.quantiles(np.array(share)))


def known(value: float) -> Input:
    """An input that is known exactly."""
    return Input(f"{value:g}", lambda share: np.full_like(share, value))


def normal(deviation: float) -> Input:
    """A normally distributed error with mean 0 and this standard deviation, in its unit."""
    if deviation == 0.0:
        return known(0.0)
    return Input(f"0 +- {deviation:g}", lambda share: deviation * scipy.special.ndtri(share))


def is_distribution(value: Mapping[str, Any]) -> bool:
    """Whether a table is meant as a distribution: it has a key that only distributions have."""
    names = {name for form in FORMS for name in form}
    return any(word in names or re.fullmatch(PERCENTILE, word) for word in value)


def _read(value: Any, field: Parameter) -> "Input | str":
    """An uncertain input, or one of the words that its field may be.

    Samples outside the bounds of the field are moved to the nearest. A distribution whose median is
    outside is refused.
    """
    allowed, words = field.bounds, field.choices or ()
    if isinstance(value, str) and value in words:
        return value
    if isinstance(value, int | float) and not isinstance(value, bool):
        if not allowed.holds(value, value):
            raise Refused(f"must be a number {allowed.allowed}")
        return known(float(value))
    if not isinstance(value, dict):
        raise Refused(f"must be {' or '.join([*map(str, words), HOW])}")
    for name, entry in value.items():
        if name != "shape" and not is_number(entry):
            raise Refused(f"{name} must be a number")
    quantiles = _distribution(value)
    middle, ends = quantiles(np.array(0.5)), quantiles(np.array([TAIL_SHARE, 1.0 - TAIL_SHARE]))
    if not (np.isfinite(ends).all() and allowed.holds(middle, middle)):
        raise Refused(f"its median {middle:g} must be {allowed.allowed}")
    if "mean" not in value and not allowed.holds(*ends):
        raise Refused(f"goes from {ends[0]:g} to {ends[1]:g}, must be {allowed.allowed}")
    low = max(allowed.minimum, allowed.above + BOUND_MARGIN)
    high = min(allowed.maximum, allowed.below - BOUND_MARGIN)
    text = ", ".join(f"{name} {entry}" for name, entry in value.items())
    return Input(
        text,
        lambda share: np.clip(quantiles(np.clip(share, TAIL_SHARE, 1 - TAIL_SHARE)), low, high),
    )


def _distribution(value: dict[str, float | str]) -> Quantiles:
    """The quantiles of a distribution that is given as a table of the file."""
    if len(value) > 1 and all(re.fullmatch(PERCENTILE, name) for name in value):
        return _of_percentiles(value)
    if not any(value.keys() == set(form) for form in FORMS):
        raise Refused(f"must be {HOW}")
    shape = value.get("shape", "normal")
    match {name: float(entry) for name, entry in value.items() if name != "shape"}:
        case {"low": low, "high": high} if not low < high:
            raise Refused("low must be below high")
        case {"low": low, "mode": mode, "high": high}:
            if not low <= mode <= high:
                raise Refused("mode must be from low to high")
            return _triangular(low, mode, high)
        case {"low": low, "high": high} if low > 0.0 and high / low > WIDE_RANGE:
            start, factor = np.log(low), np.log(high) - np.log(low)
            return lambda share: np.exp(start + share * factor)
        case {"low": low, "high": high}:
            return lambda share: low + share * (high - low)
        case {"deviation": deviation} if not deviation > 0.0:
            raise Refused("deviation must be > 0; give an exact value as a number")
        case {"mean": mean, "deviation": deviation} if shape == "lognormal" and mean > 0.0:
            width = np.sqrt(np.log1p((deviation / mean) ** 2))
            median = mean * np.exp(-0.5 * width**2)
            return lambda share: median * np.exp(width * scipy.special.ndtri(share))
        case {"mean": mean, "deviation": deviation} if shape == "normal":
            return lambda share: mean + deviation * scipy.special.ndtri(share)
        case _:
            raise Refused("shape must be normal, or lognormal with a mean > 0")


def _triangular(low: float, mode: float, high: float) -> Quantiles:
    rising = (mode - low) / (high - low)

    def quantiles(share: Floats) -> Floats:
        before = np.sqrt(rising * share)
        after = 1.0 - np.sqrt((1.0 - rising) * (1.0 - share))
        return low + (high - low) * np.where(share < rising, before, after)

    return quantiles


def _of_percentiles(value: dict[str, float | str]) -> Quantiles:
    pairs = sorted((int(name[1:]) / 100.0, float(entry)) for name, entry in value.items())
    shares, values = np.array(pairs).T
    if not (np.diff(values) > 0.0).all():
        raise Refused("percentiles must rise")
    slopes = np.diff(values) / np.diff(shares)
    ends = values[0] - shares[0] * slopes[0], values[-1] + (1.0 - shares[-1]) * slopes[-1]
    x, y = np.array([0.0, *shares, 1.0]), np.array([ends[0], *values, ends[1]])
    return lambda share: np.interp(share, x, y)


def distributions() -> list[Schema]:
    """Schemas of all forms of an uncertain input that is not a single number."""
    kinds: Schema = {"shape": {"enum": ["normal", "lognormal"]}}
    number = {"type": "number"}
    tables = [
        table_schema({name: kinds.get(name, number) for name in form}, required=list(form))
        for form in FORMS
    ]
    percentiles = {"patternProperties": {f"^{PERCENTILE}$": number}, "minProperties": 2}
    return [*tables, table_schema({}, **percentiles)]


def _schemas(field: Parameter) -> list[Schema]:
    return [{"type": "number"} | bounds_schema(field.bounds), *distributions()]


INPUT = Form("an input", _read, _schemas)
"""The form of an uncertain input."""
an_input = functools.partial(parameter, form=INPUT)
"""Declares a field that is an uncertain input."""


def sampled(inputs: dict[str, Input], count: int, seed: int) -> dict[str, Floats]:
    """Samples of independent inputs from a Latin hypercube, each of shape [count]."""
    from scipy.stats.qmc import LatinHypercube

    shares = LatinHypercube(len(inputs), rng=seed).random(count)
    columns = zip(inputs.items(), shares.T, strict=True)
    return {name: distribution.quantiles(share) for (name, distribution), share in columns}
