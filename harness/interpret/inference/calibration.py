"""What laboratory tests of a site tell of its model factor, by conjugate normal updates.

For each draw of the inputs of a layer, and of both deviations, the factors a = b + s of the modes
and kinds of test are jointly normal before any test:

    cov(a_i, a_j) = between^2 + [same mode] var(b) + [same kind] var(ratio) + [same layer] var(Nkt)

The last part is that of other layers and soundings: what their inputs leave open of their factors.
A test of kind i whose ln(qnet / su) - ln Nkt is y is a measurement of a_i with the variance
within^2 + error^2. Each test changes mean and covariance of all factors, and the draw is weighted
by how likely the test is by it. With n tests of the mode that is asked, and no error, the variance
of its factor becomes

    1 / (1 / (between^2 + var(b)) + n / within^2)
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from harness.interpret.laboratory import KINDS, LaboratoryTest
from harness.interpret.tables.model_factor import ModelFactor
from mpm_warp.grid.fitted import Floats


@dataclass(frozen=True, eq=False)
class Compared:
    """Laboratory tests in one layer of a sounding, beside its resistance."""

    tests: tuple[LaboratoryTest, ...]
    factor: Floats  # ln(qnet / su) - ln Nkt, for the mode of each test, shape [tests, draws]

    def at_tests(self, depth: Floats, values: Floats) -> Floats:
        """Values of the layer by depth, at the depths of its tests, shape [tests]."""
        return np.interp([test.depth for test in self.tests], depth, values)

    @property
    def variance(self) -> float:
        """Variance of the factors by the inputs of the layer, which its tests share."""
        return float(np.mean(np.var(self.factor, axis=1)))


@dataclass(frozen=True, eq=False)
class Belief:
    """What is known of the factors in each draw; the first is that of the mode asked."""

    mean: Floats  # shape [draws, factors]
    covariance: Floats  # shape [draws, factors, factors]
    log_likelihood: Floats  # of the tests so far, shape [draws]

    def updated(self, place: int, measured: Floats, variance: Floats) -> "Belief":
        """After a measurement of one factor, with its variance in each draw."""
        column = self.covariance[:, :, place]
        total = column[:, place] + variance
        gain, innovation = column / total[:, None], measured - self.mean[:, place]
        return Belief(
            self.mean + gain * innovation[:, None],
            self.covariance - gain[:, :, None] * column[:, None, :],
            self.log_likelihood - 0.5 * (np.log(total) + innovation**2 / total),
        )


class Measurement(NamedTuple):
    """A test as a measurement of one of the factors."""

    place: int  # of this factor
    factor: Floats  # shape [draws]
    error: float  # deviation of the error of the test


@dataclass(frozen=True, eq=False)
class Calibration:
    """The tests of a site as they count for one layer."""

    prior: Belief
    measurements: Sequence[Measurement]  # those of the layer first
    within: Floats  # deviation within the site of each draw, shape [draws]

    def belief(self, without: int | None = None) -> Belief:
        """What is known by all tests, or by all but one."""
        belief = self.prior
        for number, (place, factor, error) in enumerate(self.measurements):
            if number != without:
                belief = belief.updated(place, factor, self.within**2 + error**2)
        return belief

    def expected(self, number: int, site: Floats, depth: Floats) -> tuple[Floats, Floats]:
        """Draws of the factor of a test as the other tests have it, and their log-likelihood.

        Args:
            number: of the test among the measurements.
            site: standard normal draws for the site, shape [draws].
            depth: the same for a depth.
        """
        place, _, error = self.measurements[number]
        belief = self.belief(number)
        deviation = np.sqrt(belief.covariance[:, place, place])
        of_depth = np.sqrt(self.within**2 + error**2)
        return belief.mean[:, place] + deviation * site + of_depth * depth, belief.log_likelihood


def calibration(
    known: ModelFactor,
    mode: str,
    deviations: tuple[Floats, Floats],
    own: Compared,
    others: Sequence[Compared],
) -> Calibration:
    """The tests of a site for a layer.

    Args:
        known: what is known without them.
        mode: of the strength that is asked.
        deviations: between sites and within the site, of each draw, each of shape [draws].
        own: the tests in the layer.
        others: those in other layers and soundings.
    """
    between, within = deviations
    places: list[tuple[str, str, int]] = [(mode, "", 0)]  # mode, kind and layer of each factor
    measurements = []
    for layer, group in enumerate((own, *others)):
        for test, factor in zip(group.tests, group.factor, strict=True):
            kind = test.kind
            place = kind.mode, test.test if kind.deviation > 0.0 else "", layer
            if place not in places:
                places.append(place)
            seen = factor if group is own else np.full_like(within, factor.mean())
            measurements.append(Measurement(places.index(place), seen + kind.mean, test.error))
    modes, kinds, layers = map(np.array, zip(*places, strict=True))
    of_mode = [known.of_mode(it, between) for it in modes]
    parts = (
        (modes, [variance for _, variance in of_mode]),
        (kinds, [KINDS[it].deviation ** 2 if it else 0.0 for it in kinds]),
        (layers, [0.0 if it == 0 else others[it - 1].variance for it in layers]),
    )
    covariance = np.repeat(between[:, None, None] ** 2, len(places), axis=1)
    covariance = np.repeat(covariance, len(places), axis=2)
    for names, variances in parts:
        shared = names[:, None] == names
        columns = np.stack([np.broadcast_to(it, between.shape) for it in variances], axis=-1)
        covariance += shared * columns[:, None, :]
    mean = np.stack([it for it, _ in of_mode], axis=-1)
    return Calibration(Belief(mean, covariance, np.zeros_like(within)), measurements, within)
