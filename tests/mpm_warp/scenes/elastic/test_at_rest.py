"""Elastic soil at rest against closed forms, tolerances from the method's order."""

from collections.abc import Callable

import pytest
import xarray as xr

from mpm_warp.scenes.elastic.columns import GravityColumn
from mpm_warp.scenes.elastic.thick_cylinder import ThickCylinder

pytestmark = pytest.mark.slow

Order = Callable[[Callable[[int], xr.Dataset], int], float]


@pytest.mark.parametrize("settlement_ratio", [1e-4, 1e-5])
def test_gravity_column_is_exact_for_small_strain(settlement_ratio: float) -> None:
    # Linear cells give the stress of their middle exactly; what is left is the strain at the base.
    result = GravityColumn(cell_count=8, settlement_ratio=settlement_ratio).run()
    assert float(result.error) <= 2 * settlement_ratio


@pytest.mark.parametrize("poissons_ratio", [0.0, 0.3, 0.49])
def test_thick_cylinder_is_of_second_order(poissons_ratio: float, order: Order) -> None:
    def run(cells: int) -> xr.Dataset:
        return ThickCylinder(cell_count=cells, poissons_ratio=poissons_ratio).run()

    assert order(run, 10) == pytest.approx(2, abs=0.1)
    assert float(run(10).error) <= (2 / 10) ** 2  # (h/a)^2


def test_ring_in_plane_strain() -> None:
    """Of second order in a cell, which here is a tenth of the wall and of a quarter turn."""
    result = ThickCylinder(section="plane_strain", cell_count=10).run()
    assert float(result.error) <= 1 / 10**2


def test_order_of_the_ring_in_plane_strain(order: Order) -> None:
    rate = order(lambda n: ThickCylinder(section="plane_strain", cell_count=n).run(), 5)
    assert rate == pytest.approx(2, abs=0.1)
