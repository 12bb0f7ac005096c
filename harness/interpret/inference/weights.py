"""How well the draws of a layer meet its sleeve friction and pore pressure.

The error of a test is constant along it, and that of the model in a layer. So the depths of a layer
are one observation, the mean of fs or of u2 - u0, and each draw has a likelihood by this mean:

    ln L = -1/2 ((ln(mean measured / mean expected) - shift) / deviation)^2

For real clay the shift and deviation of u2 - u0 are those of the measured sites, of Bq measured
over computed; that of fs is not measured. Over the sites the shift has nothing to do with the
factor of the tip, so sleeve and pore pressure tell the inputs and not the model factor.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.interpret.measured import error_of
from harness.interpret.site import MeasuredTest
from harness.interpret.tables.factors import PRESSURE, SLEEVE, factors
from harness.interpret.tables.model_factor import SIMULATED, pressure_factor
from mpm_warp.grid.fitted import Floats

HALF_WIDTH = 1.96
"""Half width of 95 % over a deviation."""
ALLOWED = 0.98
"""Share of the draws by which a measured mean is called allowed by the inputs."""
LEFT_OUT = 0.2
"""Standard deviation of the error of fs, and of u2 of simulated clay, by what the simulation leaves
out, over them: a judgement."""


@dataclass(frozen=True, eq=False)
class Measure:
    """What a test measures beside its resistance, at the depths of a layer."""

    quantity: str  # of the table of factors that is simulated of it, over su
    values: Floats  # measured values [Pa], NaN where one is missing, shape [depths]
    half_width: Floats  # of 95 %, of the measured values [Pa], shape [depths]
    shift: float = 0.0  # of the logarithm, by what the simulation leaves out
    left_out: float = LEFT_OUT  # standard deviation of the same

    @property
    def width(self) -> float:
        """Standard deviation of the error of table and model, over the value."""
        return math.hypot(self.left_out, factors().half_widths[self.quantity] / HALF_WIDTH)

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

    def beside(self, expected: Floats, seed: int) -> Floats:
        """What is measured, and the least and largest value that ALLOWED of the draws have [Pa].

        Args:
            expected: values of each draw [Pa], shape [depths, draws].
            seed: of the random errors.

        Returns:
            The mean of the layer, then each depth, NaN where none is measured; shape [1 + depths,
            3].
        """
        known = np.isfinite(self.values)
        found = np.full((1 + len(known), 3), np.nan)
        if known.any():
            of_model, of_test = np.random.default_rng(seed).normal(size=(2, expected.shape[1]))
            drawn = expected[known] * np.exp(self.shift + self.width * of_model)
            drawn += self.half_width[known, None] / HALF_WIDTH * of_test
            values = np.vstack([drawn.mean(axis=0), drawn])
            ends = np.quantile(values, [0.5 * (1.0 - ALLOWED), 0.5 * (1.0 + ALLOWED)], axis=1)
            measured = [self.mean, *self.values[known]]
            found[np.concatenate([[True], known])] = np.stack([measured, *ends], axis=1)
        return found

    def log_likelihood(self, expected: Floats) -> Floats:
        """Log-likelihood of each draw, shape [draws]. A mean not above 0 tells nothing.

        Args:
            expected: values of each draw [Pa], shape [depths, draws].
        """
        if not self.mean > 0.0:
            return np.zeros(expected.shape[1])
        known = np.isfinite(self.values)
        distance = np.log(self.mean / np.maximum(expected[known].mean(axis=0), 1.0)) - self.shift
        of_test = self.half_width[known].mean() / self.mean / HALF_WIDTH
        deviation = math.hypot(self.width, of_test)
        likelihood: Floats = -0.5 * (distance / deviation) ** 2
        return likelihood


def measures_of(
    told: MeasuredTest, test: xr.Dataset, here: np.ndarray, mode: str
) -> Mapping[str, Measure]:
    """Sleeve friction and excess pore pressure, by the names that `use` has for them.

    Args:
        told: what the site file says of the test.
        test: the measured test.
        here: indices of the depths.
        mode: of the strength that is asked; that of simulated clay has no model factor.
    """
    fs, u2 = test.sleeve_friction.values[here], test.pore_pressure.values[here]
    excess = u2 - test.water_pressure.values[here]
    of_pressure = (0.0, LEFT_OUT) if mode == SIMULATED else pressure_factor()
    return {
        "sleeve": Measure(SLEEVE, fs, error_of(told, "fs", fs)),
        "pore_pressure": Measure(PRESSURE, excess, error_of(told, "u2", u2), *of_pressure),
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
