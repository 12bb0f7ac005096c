"""Grids of every shape of cells with horizontal rows."""

import pytest

from mpm_warp.grid.fitted import Grid


@pytest.fixture(params=["fitted", "partly_upright", "rectilinear"])
def grid(request: pytest.FixtureRequest) -> Grid:
    """Each of the grids with horizontal rows."""
    return request.getfixturevalue(request.param)
