"""Order and limit of values that come from finer and finer settings."""

from typing import NamedTuple

import numpy as np

from mpm_warp.grid.fitted import Floats

LEAST_POINTS = 3
"""Values needed to observe an order and a limit."""
ORDERS = 0.3, 3.0
"""Range of observed orders that are accepted; outside, the values do not yet approach a limit."""


class Approach(NamedTuple):
    """How values approach their limit: as ``limit + factor * h**order``."""

    order: float
    limit: float
    factor: float

    def at(self, h: Floats) -> Floats:
        """The value at a refinement."""
        value: Floats = self.limit + self.factor * h**self.order
        return value


def approach(h: Floats, values: Floats) -> Approach | None:
    """The order and limit observed from the three finest values; None where there are none.

    Richardson's extrapolation, with the order that follows from the three values: so they have to
    change in one direction, and by less and less. None also where the order is not within `ORDERS`.
    `h` > 0 goes to zero with refinement; values that are not a number are left out.
    """
    from scipy.optimize import brentq

    known = np.flatnonzero(np.isfinite(values))
    finest = known[np.argsort(h[known])][:LEAST_POINTS]
    if finest.size < LEAST_POINTS:
        return None
    first, second = np.diff(values[finest])
    if first * second <= 0.0:
        return None
    a, b, c = h[finest]

    def misfit(order: float) -> float:
        return float((c**order - b**order) / (b**order - a**order) - second / first)

    if misfit(ORDERS[0]) * misfit(ORDERS[1]) > 0.0:
        return None
    order = float(brentq(misfit, *ORDERS))
    factor = float(first / (b**order - a**order))
    return Approach(order, float(values[finest[0]] - factor * a**order), factor)


def order_of_error(h: Floats, error: Floats) -> float | None:
    """The order between the two finest errors, sorted by refinement; None without two."""
    known = np.flatnonzero(np.isfinite(error) & (error > 0.0))[:2]
    if known.size < 2:
        return None
    return float(np.diff(np.log(error[known])).item() / np.diff(np.log(h[known])).item())
