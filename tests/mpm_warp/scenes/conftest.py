"""The observed order of a scene's error."""

import math
from collections.abc import Callable

import xarray as xr


def order(run: Callable[[int], xr.Dataset], resolution: int) -> float:
    """The order of `error` between a resolution and its double, from runs at both."""
    coarse, fine = (float(run(it).error) for it in (resolution, 2 * resolution))
    return math.log2(coarse / fine)
