"""Spacing of columns: their sum, and how they grow."""

from __future__ import annotations

import numpy as np
import pytest

from mpm_warp.grid.fitted import graded


@pytest.mark.parametrize(("first", "length", "growth"), [(0.25, 39.0, 1.2), (1.0, 1.5, 1.1)])
def test_graded_edges_reach_the_end_in_equal_ratios(
    first: float, length: float, growth: float
) -> None:
    edges = graded(first, length, growth)
    ratios = np.diff(edges)[1:] / np.diff(edges)[:-1]
    assert edges[0] == 0.0
    assert edges[-1] == length
    np.testing.assert_allclose(ratios, ratios[:1].repeat(len(ratios)), rtol=1e-9)


@pytest.mark.parametrize("cells_per_radius", [20, 40, 100])
def test_columns_of_any_number_are_graded(cells_per_radius: int) -> None:
    """1,500 and more widths, each a little more than the one before, that add up."""
    first, length, growth = 1.0 / cells_per_radius, 999.0, 1.0 + 0.1 / cells_per_radius
    widths = np.diff(graded(first, length, growth))
    assert len(widths) > 900
    assert widths.sum() == pytest.approx(length, rel=1e-12)
    assert widths[0] == pytest.approx(first, rel=1e-6)
    np.testing.assert_allclose(widths[1:] / widths[:-1], growth, rtol=1e-4)
