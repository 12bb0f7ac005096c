"""Shares of the causes of an error in its variance.

The share of a cause is the part of the variance that vanishes, on average, when the cause is known:
Var(E[y | x]) / Var(y), the first-order index of Sobol (Saltelli et al. 2008, chapter 4). E[y | x]
is a least-squares fit to the draws, by straight lines between knots. Knots are at quantiles of x,
closer towards both ends: an error as large as qnet bends ln su most there. The fit also follows
some of the scatter of the other causes. That part is estimated from residuals e and leverages h, as
the sum of h e^2 / (1 - h) (MacKinnon & White 1985, HC2), and subtracted.
"""

import math
from collections.abc import Mapping

import numpy as np
from scipy.special import expit

from mpm_warp.grid.fitted import Floats, Integers

TOGETHER = "causes_together"
"""The part of the variance that several causes have only jointly."""
KNOTS = 24
"""Knots between the smallest and the largest draw. One cause alone then has 99 % or more."""
END_DRAWS = 8
"""Draws beyond the outermost of these knots, at each end."""


def error_shares(
    inputs: Mapping[str, Floats], values: Floats, weights: Integers
) -> dict[str, Floats]:
    """Share of each input in the variance of values, and the share of their joint effects.

    Args:
        inputs: draws by name, shape [draws]. One that is the same in all draws has no share.
        values: shape [depths, draws].
        weights: how often each draw counts, at least once, shape [draws].

    Returns:
        Shares by name, `TOGETHER` among them, shape [depths]; they add up to 1.
    """
    root = np.sqrt(weights / weights.sum())
    scaled = root * (values - np.average(values, axis=1, weights=weights)[:, None])
    ends = expit(math.log(len(root) / END_DRAWS) * np.linspace(-1.0, 1.0, KNOTS))
    shares = {}
    for name, draws in inputs.items():
        if np.ptp(draws) > 0.0:
            knots = np.unique(np.quantile(draws, [0.0, *ends, 1.0], method="nearest"))
            hats = [np.interp(draws, knots, hat) for hat in np.eye(len(knots))]
            basis = np.linalg.qr(root[:, None] * np.stack(hats, axis=-1)).Q
            leverage = np.sum(basis**2, axis=1)
            fit = (scaled @ basis) @ basis.T
            # A draw that is alone at its knot has leverage 1 and no residual.
            scatter = leverage / (1.0 + 1e-12 - leverage) * (scaled - fit) ** 2
            shares[name] = np.maximum(np.sum(fit**2 - scatter, axis=1), 0.0)
    total = np.sum(list(shares.values()), axis=0)
    whole = np.maximum(total, np.sum(scaled**2, axis=1))
    return {name: share / whole for name, share in shares.items()} | {TOGETHER: 1 - total / whole}
