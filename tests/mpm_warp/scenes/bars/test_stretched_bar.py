"""A bar that is drawn out, less than in `harness verify --extreme`, against its closed form."""

from __future__ import annotations

import math

import pytest

from mpm_warp.scenes.bars import stretched_bar
from mpm_warp.scenes.bars.stretched_bar import StretchedBar


@pytest.mark.parametrize("stretch", [1.5, 4.0])
def test_bar_that_is_drawn_out(stretch: float) -> None:
    bar = StretchedBar(stretch=stretch)
    result = bar.run()
    # Inertia takes rho L^2 / 8 times the growth of the stretch rate from the force in the middle.
    assert float(result.error) <= (math.log(stretch) / stretched_bar.SLOWNESS) ** 2 / 8 + spread(
        bar
    )
    assert float(result.stress_error) <= spread(bar)


def spread(bar: StretchedBar) -> float:
    """A quadratic spline spreads by half a cell: second order in that over the bar's length."""
    return (0.5 / bar.cell_count) ** 2
