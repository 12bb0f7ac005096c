"""A straight line of strength by depth in a layer, su = a + b z, in each draw.

The line is fitted to su of the layer by least squares, in each draw by itself. So the lines differ
by all that is common to the depths of a draw: inputs, errors of the test, factor of the site. What
differs from depth to depth averages out along the layer. It changes su of a draw by

    su within e + c r v,   e, v ~ N(0, 1),   c = sqrt(n / chi-square of n - 2)

before the fit. The first part is the departure of real clay at a depth, the second the scatter of
su about the line, with the residual r (wild bootstrap by clusters; Cameron, Gelbach & Miller 2008,
as commonly quoted) and the error of its size, c, by the number of pieces n. e and v are the same in
a piece of the layer and independent between pieces, c is the same in all of them.
"""

from collections.abc import Mapping

import numpy as np

from harness.interpret.inference.draws import Drawn
from harness.interpret.inference.real_clay import PERCENTILES, Stated
from harness.interpret.tables.model_factor import DEPTH, WITHIN
from mpm_warp.grid.fitted import Floats

PIECE = 1.0
"""Length of a piece [m]. At the measured sites the departures of neighbouring depths, 0.9 m apart
in the median, have a correlation of 0.08 +- 0.06 (`studies.laboratory.field`)."""
FEWEST_PIECES = 3
"""With fewer pieces the slope is 0."""
BAND = 0.05, 0.95
"""Quantiles of the slope by all but the departure of a depth; it is 0 if 0 is between them."""


def line_figures(
    depth: Floats,
    inside: np.ndarray,
    own_only: np.ndarray,
    drawn: Drawn,
    clay: Stated,
    chosen: np.ndarray,
    seed: int,
) -> Mapping[str, Floats]:
    """Percentiles of the line of a layer, by the names of the result; none if no depth is fitted.

    Args:
        depth: depths with draws [m], shape [depths].
        inside: whether a depth has a strength, shape [depths].
        own_only: whether it does not feel another layer; the line is fitted to these only.
        drawn: draws of simulated clay.
        clay: draws of real clay.
        chosen: indices of the draws that count, as often as they count.
        seed: of the random numbers.
    """
    fitted = inside & own_only
    if not fitted.any():
        return {}
    of_depth, none = clay.inputs.get(DEPTH, np.ones(1)), np.zeros(1)
    strength, within = clay.strength[fitted] * of_depth, drawn.inputs.get(WITHIN, none)
    line = strength_line(depth[fitted], strength, within, chosen, seed)
    ends = depth[inside][[0, -1]]
    both = line[0] + ends[:, None] * line[1]
    found = {"line_intercept": line[0], "line_slope": line[1], "line_strength": both}
    figures = {
        name: np.moveaxis(np.percentile(draws, PERCENTILES, axis=-1), 0, -1)
        for name, draws in found.items()
    }
    return {**figures, "line_depth": ends}


def strength_line(
    depth: Floats, strength: Floats, within: Floats, chosen: np.ndarray, seed: int
) -> Floats:
    """Intercept a [Pa] at depth 0 and slope b [Pa/m] of the line in each draw, shape [2, chosen].

    Args:
        depth: increasing [m], shape [depths].
        strength: without the departure of a depth [Pa], shape [depths, draws].
        within: deviation of ln su by this departure, shape [draws].
        chosen: indices of the draws that count, as often as they count.
        seed: of the random numbers.
    """
    piece = np.unique((depth - depth[0]) // PIECE, return_inverse=True)[1]
    count, middle = int(piece[-1]) + 1, float(depth.mean())
    random = np.random.default_rng(seed)
    of_clay, of_line = random.normal(size=(2, count, strength.shape[1]))[:, piece]
    for terms in (2, 1):
        basis = (depth[:, None] - middle) ** np.arange(terms)
        fit = np.linalg.pinv(basis)
        line = fit @ strength
        size = np.sqrt(count / random.chisquare(max(count - terms, 1), strength.shape[1]))
        line += fit @ ((strength - basis @ line) * size * of_line)
        low, high = np.quantile(line[-1, chosen], BAND)
        if terms == 1 or (count >= FEWEST_PIECES and low * high > 0.0):
            break
    line = (line + fit @ (strength * within * of_clay))[:, chosen]
    slope = line[1] if len(line) > 1 else np.zeros(len(chosen))
    return np.stack([line[0] - middle * slope, slope])
