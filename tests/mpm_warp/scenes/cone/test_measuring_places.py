"""The places where a standard penetrometer measures, and the mean over its sleeve."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mpm_warp.scenes.cone.measuring_places import SLEEVE_BEGIN, SLEEVE_LENGTH, sleeve_mean


def test_the_sleeve_of_a_cone_of_10_cm2_has_150_cm2() -> None:
    assert 2.0 * math.pi * SLEEVE_LENGTH * 1.785**2 == pytest.approx(150.0, rel=1e-3)


@pytest.mark.parametrize("count", [3, 8, 40])
def test_mean_over_the_sleeve_of_what_is_linear(count: int) -> None:
    """That of its middle, whatever the heights; what is beside the sleeve does not count."""
    heights = np.linspace(-1.0, 9.0, count)
    middle = SLEEVE_BEGIN + 0.5 * SLEEVE_LENGTH
    assert sleeve_mean(heights, 3.0 - 2.0 * heights) == pytest.approx(3.0 - 2.0 * middle)


def test_mean_over_the_sleeve_of_what_bends_at_a_height() -> None:
    heights = np.array([0.0, 4.0, 9.0])
    end = SLEEVE_BEGIN + SLEEVE_LENGTH
    # Nothing up to the height of 4, from there on a slope of 1.
    expected = 0.5 * (end - 4.0) ** 2 / SLEEVE_LENGTH
    assert sleeve_mean(heights, np.array([0.0, 0.0, 5.0])) == pytest.approx(expected)


def test_there_is_no_mean_where_the_sleeve_ends_higher() -> None:
    heights = np.linspace(-1.0, 8.0, 10)
    assert math.isnan(sleeve_mean(heights, np.ones(10)))
