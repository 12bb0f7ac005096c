"""The fit of a curve of degradation."""

import numpy as np
import pytest

from mpm_warp.scenes.full_flow.cyclic import fitted_degradation

CYCLE = 0.25 + 0.5 * np.arange(10)
SEARCHED_TO = 1e-4
"""The logarithm of n_95 is found to 1e-5 by the search; the others hang on it linearly."""


@pytest.mark.parametrize(("remoulded", "cycles"), [(0.2, 1.5), (0.5, 4.0), (0.1, 0.6)])
def test_a_curve_that_is_exactly_one_is_found(remoulded: float, cycles: float) -> None:
    resistance = 10.0 * (remoulded + (1.0 - remoulded) * np.exp(-3.0 * CYCLE / cycles))
    fit = fitted_degradation(CYCLE, resistance)
    assert fit.intact == pytest.approx(10.0, rel=SEARCHED_TO)
    assert fit.remoulded_share == pytest.approx(remoulded, rel=SEARCHED_TO)
    assert fit.cycles == pytest.approx(cycles, rel=SEARCHED_TO)
    assert fit.misfit < SEARCHED_TO


def test_the_misfit_is_what_the_fit_leaves() -> None:
    """Noise of alternating sign hardly moves the fit, which cannot follow it."""
    noise = 0.01 * (-1.0) ** np.arange(CYCLE.size)
    fit = fitted_degradation(CYCLE, 10.0 * (0.3 + 0.7 * np.exp(-CYCLE) + noise))
    assert fit.misfit == pytest.approx(0.01, rel=0.3)
