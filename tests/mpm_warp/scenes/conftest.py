"""The observed order of a scene's error."""

import math
from collections.abc import Callable

import pytest
import xarray as xr

Order = Callable[[Callable[[int], xr.Dataset], int], float]


@pytest.fixture
def order() -> Order:
    """Gives the order of `error` between a resolution and its double, from runs at both."""

    def observed(run: Callable[[int], xr.Dataset], resolution: int) -> float:
        coarse, fine = (float(run(it).error) for it in (resolution, 2 * resolution))
        return math.log2(coarse / fine)

    return observed
