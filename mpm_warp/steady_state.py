"""When a curve that levels off has become steady."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import fmean


def is_steady(values: Sequence[float], span: int, tolerance: float) -> bool:
    """Whether the mean of the last values differs little from the mean of those before.

    What decays exponentially by the factor q over a span, and differs by `tolerance` from one span
    to the next, has tolerance q / (1 - q) to go: about as much where a span halves it.

    Args:
        values: the curve so far, at even distances, from where it may be steady at all.
        span: how many of them a mean is over, >= 1; never steady before two spans.
        tolerance: difference of the two means over the last one, dimensionless; never steady at 0.
    """
    if len(values) < 2 * span:
        return False
    before, last = fmean(values[-2 * span : -span]), fmean(values[-span:])
    return abs(last - before) < tolerance * abs(last)
