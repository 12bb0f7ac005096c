"""Small scenes to take apart."""

from __future__ import annotations

import math

import numpy as np
import pytest
from mpm_warp.penetrometer import Penetrometer, PenetrometerSurface

from mpm_warp.grid.fitted import Grid


@pytest.fixture
def penetrometer() -> Penetrometer:
    """A 60 degree cone of unit radius."""
    return Penetrometer(radius=1.0, apex_angle=math.radians(60.0))


@pytest.fixture
def fitted(penetrometer: Penetrometer) -> Grid:
    """A grid fitted to it, small."""
    return penetrometer.fitted_grid(
        cell_size=0.5, cell_growth=0.8, outer_radius=6.0, depth_below=2.0, height_above=2.0
    )


@pytest.fixture
def rectilinear() -> Grid:
    """A grid without a surface."""
    return Grid(
        columns=np.linspace(0.0, 1.0, 5) ** 1.5,
        rows=np.array([0.0, 0.3, 1.0, 1.4]),
        surface_radius=np.zeros(4),
        outer_radius=2.0,
    )


@pytest.fixture
def surface(penetrometer: Penetrometer, fitted: Grid) -> PenetrometerSurface:
    """The penetrometer's surface in the fitted grid, adhesive and in the ground under stress."""
    return PenetrometerSurface(
        penetrometer=penetrometer,
        grid=fitted,
        face_adhesion=3.0,
        shaft_adhesion=1.0,
        friction=0.0,
        in_situ_stress=10.0,
    )
