"""What a stability map is made of: outcomes of cases over a parameter's values."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from harness.archive.conventions import (
    COMPLETED,
    MISSING,
    limits_of,
    over_cases,
    spoken,
    varied_names,
)
from harness.study.designs import LATIN_HYPERCUBE, ONE_AT_A_TIME

Floats = NDArray[np.float64]
Texts = NDArray[np.str_]


@dataclass(frozen=True, kw_only=True)
class Values:
    """A parameter's values in the cases that were run.

    Attributes:
        name: of the parameter.
        unit: SI unit, "1" for a dimensionless number.
        numbers: the value of each case, or its place among the categories.
        categories: the values in words, in the order of the study, where they are no numbers or
            the scene derives one of them; else none.
    """

    name: str
    unit: str
    numbers: Floats
    categories: tuple[str, ...] = ()

    @classmethod
    def of(cls, dataset: xr.Dataset, name: str) -> Values:
        """The values that a dataset has along its cases."""
        values, unit = dataset[name].values, str(dataset[name].attrs.get("units", "1"))
        if values.dtype.kind in "iuf" and np.isfinite(values).all():
            return cls(name=name, unit=unit, numbers=values.astype(float))
        texts = [_category(value) for value in values.tolist()]
        categories = tuple(dict.fromkeys(texts))
        numbers = np.array([float(categories.index(text)) for text in texts])
        return cls(name=name, unit=unit, numbers=numbers, categories=categories)

    @property
    def label(self) -> str:
        """Name and unit."""
        name = spoken(self.name)
        return name if self.unit == "1" else f"{name} [{self.unit}]"

    @property
    def logarithmic(self) -> bool:
        """Whether the numbers, zero aside, span a decade or more."""
        positive = self.numbers[self.numbers > 0.0]
        if positive.size == 0 or self.numbers.min() < 0.0:
            return False
        return bool(positive.max() >= 10.0 * positive.min())

    def text(self, number: float) -> str:
        """A value in words."""
        return self.categories[int(number)] if self.categories else f"{number:.6g}"


def shows_stability(dataset: xr.Dataset) -> bool:
    """Whether a study's result tells where it is stable.

    It does where it varies parameters of one scene one at a time or at random, and a case that was
    run did not complete or a result has a limit.
    """
    if dataset.attrs.get("design") not in (ONE_AT_A_TIME, LATIN_HYPERCUBE):
        return False
    several = len(str(dataset.attrs["scene"]).split()) > 1
    if several or not varied_names(dataset):
        return False
    ended = set(dataset["status"].values.tolist()) - {MISSING}
    return bool(ended) and (limits_of(dataset) != {} or ended != {COMPLETED})


def outcomes(dataset: xr.Dataset) -> tuple[Texts, Texts, Floats]:
    """Status and reason of each case, and its results' size over their limit.

    Of several results that have a limit the one nearest to it counts; where there is none the size
    is not a number.
    """
    status = over_cases(dataset, "status").astype(str)
    reason = np.array([short_reason(str(message)) for message in over_cases(dataset, "message")])
    sizes = [
        np.abs(over_cases(dataset, name)) / limit for name, limit in limits_of(dataset).items()
    ]
    none = np.full(status.shape, np.nan)
    return status, reason, np.fmax.reduce([none, *sizes])


def limit_label(dataset: xr.Dataset) -> str:
    """What is measured against a limit, and the limit, in words."""
    limits = limits_of(dataset).items()
    return " or ".join(f"{spoken(name)} over its limit of {limit:g}" for name, limit in limits)


def short_reason(message: str) -> str:
    """What gave way, out of a message: without the exception's name, places, times and remedy."""
    text = re.sub(r"^\w+: ", "", message)
    text = re.sub(r" (at|is) \[[^]]*\]( m)?", "", text)
    return re.split(r", at |, more than |; |: ", text)[0]


def _category(value: object) -> str:
    if isinstance(value, float):
        return "derived" if np.isnan(value) else f"{value:.6g}"
    return str(value) or "derived"
