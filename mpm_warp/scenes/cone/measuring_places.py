"""Where a standard penetrometer measures pore pressure and sleeve friction.

The standard penetrometer is 35.7 mm wide, which is 10 cm2. The cylindrical part of its cone reaches
10 mm above the shoulder, with the filter u2 in its middle. There begins the friction sleeve, of 150
cm2, and 5 mm above its end is the filter u3. All heights are over the radius, so that a larger
penetrometer has its places in proportion.
"""

from __future__ import annotations

import math

import numpy as np

from mpm_warp.grid.fitted import Floats

_RADIUS = 17.85
"""Of the standard penetrometer [mm]."""
SHOULDER_FILTER = 5.0 / _RADIUS
"""Height of the filter u2 above the shoulder, over the radius."""
SLEEVE_BEGIN = 10.0 / _RADIUS
"""Height of the lower end of the sleeve above the shoulder, over the radius."""
SLEEVE_LENGTH = 133.7 / _RADIUS
"""Length of the sleeve over the radius."""
SHAFT_FILTER = SLEEVE_BEGIN + SLEEVE_LENGTH + 5.0 / _RADIUS
"""Height of the filter u3 above the shoulder, over the radius."""


def sleeve_mean(heights: Floats, values: Floats) -> float:
    """Mean over the sleeve of what is linear between some heights; not a number beyond the highest.

    Args:
        heights: above the shoulder, over the radius, rising, shape [n].
        values: at these heights, shape [n].
    """
    begin, end = SLEEVE_BEGIN, SLEEVE_BEGIN + SLEEVE_LENGTH
    if heights[-1] < end:
        return math.nan
    between = heights[(heights > begin) & (heights < end)]
    at = np.concatenate([[begin], between, [end]])
    return float(np.trapezoid(np.interp(at, heights, values), at)) / SLEEVE_LENGTH
