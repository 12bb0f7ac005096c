"""The forces on a cylinder and a sphere in full flow against what is known of them."""

import pytest

from mpm_warp.scenes.full_flow.limit_load import FullFlowCylinder, FullFlowSphere

pytestmark = pytest.mark.slow

CELLS = 4


def test_force_on_a_rough_sphere_in_soil_of_von_mises() -> None:
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    sphere = FullFlowSphere(cells_per_radius=CELLS, adhesion_factor=1.0, material="von_mises")
    result = sphere.run()
    assert float(result.error) <= 1 / (CELLS * result.bearing_capacity_exact)


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
def test_force_on_a_sphere_in_soil_of_tresca_is_within_its_bounds(adhesion_factor: float) -> None:
    result = FullFlowSphere(cells_per_radius=CELLS, adhesion_factor=adhesion_factor).run()
    assert float(result.error) <= 1 / (CELLS * result.bearing_capacity)


def test_where_nothing_is_known_nothing_is_compared() -> None:
    result = FullFlowSphere(cells_per_radius=1, adhesion_factor=0.5, displacement=60.0).run()
    assert not {"error", "bearing_capacity_exact"} & set(result)


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
def test_force_on_a_cylinder_in_full_flow(adhesion_factor: float) -> None:
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    result = FullFlowCylinder(cells_per_radius=CELLS, adhesion_factor=adhesion_factor).run()
    assert float(result.error) <= 1 / (CELLS * result.bearing_capacity_exact)
