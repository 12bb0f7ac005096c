"""The force on a cylinder in full flow against the exact one."""

from __future__ import annotations

import pytest

from mpm_warp.scenes.full_flow.limit_load.full_flow_cylinder import FullFlowCylinder

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
def test_force_on_a_cylinder_in_full_flow(adhesion_factor: float) -> None:
    cells = 4
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    result = FullFlowCylinder(cells_per_radius=cells, adhesion_factor=adhesion_factor).run()
    assert float(result.error) <= 1 / (cells * result.bearing_capacity_exact)
