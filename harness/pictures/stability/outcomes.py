"""What a stability map is made of: outcomes of cases over a parameter's values."""

from __future__ import annotations

import re

import numpy as np
import xarray as xr

from harness.archive.conventions import (
    COMPLETED,
    MISSING,
    limits_of,
    over_cases,
    spoken,
    varied_names,
)
from harness.pictures.drawing.quantities import Floats, Texts
from harness.study.designs import LATIN_HYPERCUBE, ONE_AT_A_TIME


def shows_stability(dataset: xr.Dataset) -> bool:
    """Whether a study's result shows where it is stable.

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
