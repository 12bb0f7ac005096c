"""The model factor: how far real clay departs from the clay that is simulated.

    ln(qnet / su) = ln Nkt + b + s + e,   s ~ N(0, between),   e ~ N(0, within)

Nkt is computed from the inputs of a layer, for su in the mode that is asked. b belongs to the mode,
s to the site, e to the depth. b and both deviations are those of measured sites, each site counted
once (`studies/field_sites.csv`). With y the mean of ln(qnet / su) - ln Nkt at a site, and v the
variance of this mean by the scatter of its depths and by the inputs,

    y ~ N(b, between^2 + v)

b has a flat prior, and so has the deviation between sites from 0 to MOST_BETWEEN. The deviation
within a site is that of one of the sites. What is uncertain of all three counts: each draw of a
layer has its own.

A mode without pairs takes b of practice, if practice states factors of it. Practice's formulas are
evaluated at each site; their mean is b, their difference its deviation. Any other mode has b half
way between both, and the whole difference as its deviation. The deviations of sites and depths are
those of the pairs, which are the widest known.
"""

import csv
import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from harness.references.registry import BANDS
from harness.study.distributions import Input, normal
from harness.study.files import read_text, studies_folder
from mpm_warp.fields.plain_numbers import number_of
from mpm_warp.grid.fitted import Floats

SITES = "field_sites.csv"
SIMULATED, MEASURED, OF_PRACTICE = "isotropic", "mobilised", "triaxial_compression"
"""Modes of su: of simulated clay, which has no model factor; of the measured pairs; of the factors
that practice states."""
PRACTICE = ("mayne_peuchen_2018", "karlsrud_2005")
"""Entries of `harness references` with formulas of Nkt in triaxial compression."""
RATIOS: Mapping[str, tuple[float, float]] = {
    "simple_shear_ratio": (0.6, 0.9),
    "extension_ratio": (0.35, 0.7),
}
"""Usual ranges of su in simple shear and in extension, over that in compression."""
SITE, DEPTH = "site_factor", "depth_factor"
"""The model factor in draws: that of the site for a mode of su, and that of a depth."""
BETWEEN, WITHIN = "between", "within"
"""Deviations of ln Nkt between sites and within the site, in draws."""
MOST_BETWEEN, CANDIDATES = 1.5, 301
"""Largest deviation of ln Nkt between sites, and number of candidates from 0 to it."""


class SiteFigures(NamedTuple):
    """What a measured site says, over its depths; empty cells of the file are NaN."""

    site: float  # its number in the database
    depths: float  # with su and qnet
    measured: float  # mean of ln(qnet / su)
    measured_deviation: float
    computed: float  # mean of ln Nkt, the median of the draws
    computed_deviation: float  # of this mean, by the draws of the inputs
    within: float  # deviation of ln(qnet / su) - ln Nkt
    OCR: float  # medians
    Bq: float
    Ip: float  # [%]
    pressure: float  # mean of ln Bq - ln Bq computed

    @property
    def factor(self) -> float:
        """Mean of ln(qnet / su) - ln Nkt."""
        return self.measured - self.computed


@dataclass(frozen=True, eq=False)
class ModelFactor:
    """What is known of b and both deviations before a test of the site itself."""

    between: Floats  # candidates of the deviation between sites, shape [candidates]
    probability: Floats  # that it is at most this, shape [candidates]
    mean: Floats  # of b of the measured mode, by candidate
    variance: Floats  # of the same
    within: Floats  # deviations within the measured sites, increasing, shape [sites]
    practice: tuple[float, float]  # mean and deviation of b of OF_PRACTICE

    def between_at(self, share: Floats) -> Floats:
        """Quantiles of the deviation between sites."""
        return np.interp(share, self.probability, self.between)

    def within_at(self, share: Floats) -> Floats:
        """Quantiles of the deviation within a site."""
        places = (np.arange(len(self.within)) + 0.5) / len(self.within)
        return np.interp(share, places, self.within)

    def of_mode(self, mode: str, between: Floats) -> tuple[Floats, Floats]:
        """Mean and variance of b of a mode, given deviations between sites, shape [...]."""
        of_pairs = np.interp(between, self.between, self.mean)
        variance = np.interp(between, self.between, self.variance)
        mean, deviation = self.practice
        if mode == MEASURED:
            return of_pairs, variance
        if mode == OF_PRACTICE:
            return np.full_like(of_pairs, mean), np.full_like(of_pairs, deviation**2)
        return 0.5 * (of_pairs + mean), (of_pairs - mean) ** 2 + variance

    def of_site(self, mode: str, between: Floats) -> tuple[Floats, Floats]:
        """Mean and variance of b + s of a site without a test of its own."""
        mean, variance = self.of_mode(mode, between)
        return mean, between**2 + variance


def fitted(sites: Sequence[SiteFigures]) -> ModelFactor:
    """The model factor by the figures of measured sites, at least three."""
    own = np.array([site.factor for site in sites])
    within = np.array([site.within for site in sites])
    of_mean = within**2 / np.array([site.depths for site in sites])
    of_mean += np.array([site.computed_deviation for site in sites]) ** 2
    between = np.linspace(0.0, MOST_BETWEEN, CANDIDATES)
    variances = between[:, None] ** 2 + of_mean
    variance = 1.0 / np.sum(1.0 / variances, axis=1)
    mean = variance * np.sum(own / variances, axis=1)
    misfit = (own - mean[:, None]) ** 2 / variances + np.log(variances)
    likelihood = 0.5 * np.log(variance) - 0.5 * np.sum(misfit, axis=1)
    density = np.exp(likelihood - likelihood.max())
    probability = np.cumsum(density) / np.sum(density)
    return ModelFactor(between, probability, mean, variance, np.sort(within), practice_at(sites))


def practice_at(sites: Sequence[SiteFigures]) -> tuple[float, float]:
    """Mean and deviation of b by the formulas of practice, at sites within their ranges."""
    middle = (0.5 * (low + high) for low, high in RATIOS.values())
    compression = float(over_average(*middle)[OF_PRACTICE])
    means = []
    for band in (BANDS[name] for name in PRACTICE):
        inside = [
            (site, own)
            for site in sites
            if all(
                low <= (own := site._asdict())[name] <= high
                for name, (low, high) in band.range.items()
            )
        ]
        factors = [
            math.log(float(band.formula.value(own)) * compression) - site.computed
            for site, own in inside
        ]
        means.append(float(np.mean(factors)))
    return float(np.mean(means)), float(np.ptp(means))


def measured_sites() -> tuple[SiteFigures, ...]:
    """The figures of the measured sites that ship."""
    lines = read_text(studies_folder() / SITES, "a table").splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return tuple(
        SiteFigures(*(number_of(row[name]) if row[name] else math.nan for name in row))
        for row in rows
    )


def typical(name: str) -> float:
    """Median of a figure over the measured sites."""
    return float(np.nanmedian([getattr(site, name) for site in measured_sites()]))


@functools.cache
def model_factor() -> ModelFactor:
    """The model factor by the sites that ship."""
    return fitted(measured_sites())


def over_average(shear: Floats | float, extension: Floats | float) -> Mapping[str, Floats]:
    """Strength by mode of shear over the average of three, given those over compression."""
    average = np.asarray((1.0 + shear + extension) / 3.0)
    return {
        "triaxial_compression": 1.0 / average,
        "simple_shear": shear / average,
        "triaxial_extension": extension / average,
    }


@functools.cache
def pressure_factor() -> tuple[float, float]:
    """Mean and deviation of ln Bq - ln Bq computed, of a further site, by the sites that ship."""
    return predicted([site.pressure for site in measured_sites()])


def predicted(values: Sequence[float]) -> tuple[float, float]:
    """Mean and deviation of a further value of a sample, which its number makes wider."""
    known = np.asarray(values)
    return float(known.mean()), float(known.std(ddof=1) * math.sqrt(1.0 + 1.0 / len(known)))


def model_causes(known: ModelFactor) -> dict[str, Input]:
    """What is drawn for a model factor: both deviations, and the place of site and depth."""
    return {
        BETWEEN: Input("by the measured sites", known.between_at),
        WITHIN: Input("by the measured sites", known.within_at),
        SITE: normal(1.0),
        DEPTH: normal(1.0),
    }


def with_model_factor(
    inputs: Mapping[str, Floats], mean: Floats, variance: Floats
) -> dict[str, Floats]:
    """Draws of inputs, with the model factors of site and depth in place of `model_causes`.

    Args:
        inputs: draws, each of shape [draws].
        mean: of the logarithm of the factor of the site, in each draw.
        variance: of the same.
    """
    own = {name: draws for name, draws in inputs.items() if name not in (BETWEEN, WITHIN)}
    own[SITE] = np.exp(mean + np.sqrt(variance) * inputs[SITE])
    own[DEPTH] = np.exp(inputs[WITHIN] * inputs[DEPTH])
    return own
