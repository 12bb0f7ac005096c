"""When the resistance of a penetrometer is steady, and what is still to come where it is not quite.

All lengths are over the radius of the penetrometer.
"""

import math
from collections.abc import Sequence
from statistics import fmean

import xarray as xr

from mpm_warp.grid.fitted import Floats

SAMPLE_SPACING = 0.1
"""Penetration between two samples of a curve."""
STEADY_SAMPLES = 20
"""Samples whose mean is the steady value: two radii."""
MEANS = 2.0 * STEADY_SAMPLES * SAMPLE_SPACING
"""Penetration over which two means of the resistance are compared."""
STILL_TO_COME = 1.5
"""Half width of the change that is still to come, over the last change of the mean."""
FORGETTING, FORGETTING_OF_STIFFNESS, LONGEST_FORGETTING = 1.5, 150.0, 10.0
"""Penetration at the final speed in which the soil forgets the approach: at least the first, the
second over the rigidity index, and at most the third."""
ALL_PASSED = 1.5
"""Penetration beyond the extent of the window above the shoulder at which all soil beside the shaft
has been passed by the cone."""


def forgetting(rigidity_index: float) -> float:
    """Penetration at the final speed in which the soil forgets the approach."""
    return min(LONGEST_FORGETTING, max(FORGETTING, FORGETTING_OF_STIFFNESS / rigidity_index))


def steady_penetration(rigidity_index: float) -> float:
    """Penetration at the final speed before a resistance counts as steady."""
    return forgetting(rigidity_index) + MEANS


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


def last_part(curve: xr.DataArray) -> Floats:
    """The samples of a curve over its last two radii, or its last half."""
    count = min(STEADY_SAMPLES, len(curve) // 2)
    return curve.values[-count:]


def steady_mean(curve: xr.DataArray) -> tuple[float, str]:
    """Mean of a curve over its last two radii or its last half, and over what it is in words."""
    last = last_part(curve)
    return float(last.mean()), f"over the last {len(last) * SAMPLE_SPACING:g} radii"


def last_change(curve: Floats) -> float:
    """What the mean of a curve over two radii is above that over the two before; NaN if short."""
    before, last = (
        curve[begin:end].mean() if curve.size >= 2 * STEADY_SAMPLES else math.nan
        for begin, end in ((-2 * STEADY_SAMPLES, -STEADY_SAMPLES), (-STEADY_SAMPLES, None))
    )
    return float(last - before)
