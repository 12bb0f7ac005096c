"""How well the draws of a layer meet its sleeve friction and pore pressure.

The error of a test is constant along it, and that of the model in a layer. So the depths of a layer
are one observation, the mean of fs or of u2 - u0, and each draw has a likelihood by this mean:

    ln L = -1/2 (ln(mean measured / mean expected) / deviation)^2
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.interpret.factors import PRESSURE, SLEEVE, factors
from harness.interpret.measured import error_of
from harness.interpret.site import MeasuredTest
from mpm_warp.grid.fitted import Floats

HALF_WIDTH = 1.96
"""Half width of 95 % over a deviation."""
LEFT_OUT = {SLEEVE: 0.2, PRESSURE: 0.2}
"""Standard deviations of the errors of fs and u2 by what the simulation leaves out, over them."""


@dataclass(frozen=True, eq=False)
class Measure:
    """What a test measures beside its resistance, at the depths of a layer."""

    quantity: str  # of the table of factors that is simulated of it, over su
    values: Floats  # measured values [Pa], NaN where one is missing, shape [depths]
    half_width: Floats  # of 95 %, of the measured values [Pa], shape [depths]

    @property
    def width(self) -> float:
        """Standard deviation of the error of table and model, over the value."""
        return math.hypot(
            LEFT_OUT[self.quantity], factors().half_widths[self.quantity] / HALF_WIDTH
        )

    @property
    def deviation(self) -> Floats:
        """Standard deviation of the errors of test, table and model [Pa], shape [depths]."""
        deviation: Floats = np.hypot(self.width * self.values, self.half_width / HALF_WIDTH)
        return deviation

    @property
    def mean(self) -> float:
        """Mean of the values that are there [Pa]; NaN if there is none."""
        known = self.values[np.isfinite(self.values)]
        return float(known.mean()) if known.size else math.nan

    def log_likelihood(self, expected: Floats) -> Floats:
        """Log-likelihood of each draw, shape [draws]. A mean not above 0 tells nothing.

        Args:
            expected: values of each draw [Pa], shape [depths, draws].
        """
        if not self.mean > 0.0:
            return np.zeros(expected.shape[1])
        known = np.isfinite(self.values)
        distance = np.log(self.mean / np.maximum(expected[known].mean(axis=0), 1.0))
        of_test = self.half_width[known].mean() / self.mean / HALF_WIDTH
        deviation = math.hypot(self.width, of_test)
        likelihood: Floats = -0.5 * (distance / deviation) ** 2
        return likelihood


def measures_of(told: MeasuredTest, test: xr.Dataset, here: np.ndarray) -> Mapping[str, Measure]:
    """Sleeve friction and excess pore pressure, by the names that `use` has for them.

    Args:
        told: what the site file says of the test.
        test: the measured test.
        here: indices of the depths.
    """
    fs, u2 = test.sleeve_friction.values[here], test.pore_pressure.values[here]
    excess = u2 - test.water_pressure.values[here]
    return {
        "sleeve": Measure(SLEEVE, fs, error_of(told, "fs", fs)),
        "pore_pressure": Measure(PRESSURE, excess, error_of(told, "u2", u2)),
    }


def chosen_draws(likelihood: Floats, seed: int) -> tuple[np.ndarray, float]:
    """Indices of draws, resampled by their weights, and the effective number of draws.

    The latter is 1 / sum of squared weights.

    Args:
        likelihood: log-likelihood of each draw, shape [draws].
        seed: of the one random number.
    """
    weights = np.exp(likelihood - likelihood.max())
    weights /= weights.sum()
    count = len(weights)
    start = np.random.default_rng(seed).random()
    places = np.searchsorted(np.cumsum(weights), (np.arange(count) + start) / count)
    return np.minimum(places, count - 1), float(1.0 / np.sum(weights**2))
