"""A penetrometer, and its contact in a small grid that is fitted to it."""

import math

import pytest

from mpm_warp.grid.fitted import Grid
from mpm_warp.scenes.cone.penetrometer import Penetrometer, PenetrometerContact


@pytest.fixture
def penetrometer() -> Penetrometer:
    """A 60 degree cone of unit radius."""
    return Penetrometer(radius=1.0, apex_angle=math.radians(60.0))


@pytest.fixture
def contact(penetrometer: Penetrometer, fitted: Grid) -> PenetrometerContact:
    """The penetrometer in the fitted grid, adhesive and in the ground under stress."""
    return PenetrometerContact.of(
        penetrometer, fitted, face_adhesion=3.0, shaft_adhesion=1.0, in_situ_stress=10.0
    )
