"""When a curve counts as steady."""

from __future__ import annotations

import numpy as np
import pytest
from mpm_warp.steady_state import is_steady


def first_steady(curve: list[float], span: int, tolerance: float) -> int:
    return next(n for n in range(len(curve)) if is_steady(curve[:n], span, tolerance))


@pytest.mark.parametrize("halving", [10, 20, 40])
def test_what_is_left_of_an_exponential_is_what_its_decay_says(halving: int) -> None:
    """No more than that at the first value that counts as steady, and more at the one before."""
    span, tolerance = 20, 0.003
    curve = [1.0 - 0.5 ** (n / halving) for n in range(1000)]
    stop = first_steady(curve, span, tolerance)
    decay = 0.5 ** (span / halving)
    left = 1.0 - np.mean(curve[stop - span : stop])
    # Of the last mean, 1 less what is left; and that mean differs by left (1 / decay - 1).
    most = 1.0 / (1.0 + (1.0 - decay) / (decay * tolerance))
    assert 0.5 ** (1 / halving) * most <= left < most


def test_nothing_is_steady_before_two_spans_or_without_tolerance() -> None:
    assert not is_steady([1.0] * 39, 20, 0.1)
    assert is_steady([1.0] * 40, 20, 0.1)
    assert not is_steady([1.0] * 40, 20, 0.0)
