"""Grids of every shape of cells with horizontal rows."""

from __future__ import annotations

import pytest

from mpm_warp.grid.fitted import Grid


@pytest.fixture(params=["fitted", "rectilinear"])
def grid(request: pytest.FixtureRequest) -> Grid:
    """Either grid."""
    value: Grid = request.getfixturevalue(request.param)
    return value
