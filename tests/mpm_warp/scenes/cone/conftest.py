"""A penetrometer, and its contact in a small grid that is fitted to it."""

import math
from dataclasses import replace

import pytest
import xarray as xr

from mpm_warp.grid.fitted import Grid
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.penetrometer import Penetrometer, PenetrometerContact

LONGER = ConePenetration(
    cells_per_radius=2,
    penetration=3,
    domain_radius=20,
    domain_above=6,
    domain_below=6,
    steady_tolerance=0,
)
"""A cone test that slips everywhere in the end."""


@pytest.fixture(scope="session")
def rough() -> xr.Dataset:
    """That test with some adhesion, and with the balance of its energy."""
    return replace(LONGER, adhesion_factor=0.5, energy_audit="balance").run()


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
