"""When the resistance of a penetrometer is steady, and how much it may still change.

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
"""Number of samples whose mean is the steady value; they cover two radii."""
COMPARED_PENETRATION = 2.0 * STEADY_SAMPLES * SAMPLE_SPACING
"""Penetration that the two compared means of the resistance cover together."""
REMAINING_CHANGE = 1.5
"""Half width of the change expected after the end of the run, over the last change of the mean."""
SHORTEST_TRANSIENT, TRANSIENT_INDEX, LONGEST_TRANSIENT = 1.5, 150.0, 10.0
"""Penetration at the final speed after which the approach no longer acts: the second over the
rigidity index, but at least the first and at most the third."""
SETTLING_MARGIN = 1.5
"""The cone has passed all soil beside the shaft once its penetration is this much greater than the
extent of the window above the shoulder."""


def transient_penetration(rigidity_index: float) -> float:
    """Penetration at the final speed after which the approach no longer acts."""
    return min(LONGEST_TRANSIENT, max(SHORTEST_TRANSIENT, TRANSIENT_INDEX / rigidity_index))


def steady_penetration(rigidity_index: float) -> float:
    """Penetration at the final speed before a resistance counts as steady."""
    return transient_penetration(rigidity_index) + COMPARED_PENETRATION


def is_steady(values: Sequence[float], span: int, tolerance: float) -> bool:
    """Whether the means of the last two spans of a curve differ by less than a tolerance.

    A transient that decays by the factor q over a span, and changes by `tolerance` between two
    spans, will change by tolerance q / (1 - q) more: by the same amount again where q is a half.

    Args:
        values: the curve so far, evenly spaced, from the first value that may be steady.
        span: number of values in a mean, >= 1; a curve shorter than two spans is not steady.
        tolerance: allowed difference of the two means over the last one, dimensionless; at 0 no
            curve is steady.
    """
    if len(values) < 2 * span:
        return False
    before, last = fmean(values[-2 * span : -span]), fmean(values[-span:])
    return abs(last - before) < tolerance * abs(last)


def last_part(curve: xr.DataArray) -> Floats:
    """The samples of the last two radii of a curve, or of its last half if that is shorter."""
    count = min(STEADY_SAMPLES, len(curve) // 2)
    return curve.values[-count:]


def steady_mean(curve: xr.DataArray) -> tuple[float, str]:
    """Mean of `last_part` of a curve, and what it covers in words: "over the last 2 radii"."""
    last = last_part(curve)
    return float(last.mean()), f"over the last {len(last) * SAMPLE_SPACING:g} radii"


def last_change(curve: Floats) -> float:
    """Mean over the last two radii less mean over the two before; NaN for a shorter curve."""
    before, last = (
        curve[begin:end].mean() if curve.size >= 2 * STEADY_SAMPLES else math.nan
        for begin, end in ((-2 * STEADY_SAMPLES, -STEADY_SAMPLES), (-STEADY_SAMPLES, None))
    )
    return float(last - before)
