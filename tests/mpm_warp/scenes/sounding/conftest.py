"""A sounding of next to no cost."""

import dataclasses

from mpm_warp.scenes.sounding.sounding import Sounding
from tests.mpm_warp.conftest import SMALL_WINDOW

COARSE = Sounding(
    cone_radius=1.0,
    from_depth=12.0,
    to_depth=15.0,
    cells_per_radius=1.5,
    adhesion_factor=0.5,
    speed_ratio=0.2,
    **{**SMALL_WINDOW, "domain_below": 4},
)


def changed(**changes: object) -> Sounding:
    """A sounding in a small window, coarse and fast, with other parameters.

    What it gives is a curve, but no good cone factor.
    """
    return dataclasses.replace(COARSE, **changes)
