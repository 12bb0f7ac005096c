"""Elastic soil at rest against closed forms, tolerances from the method's order."""

from collections.abc import Callable
from typing import Any

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


@pytest.mark.parametrize(
    ("cells", "changed"),
    [
        (10, {"poissons_ratio": 0.0}),
        (10, {"poissons_ratio": 0.3}),
        (10, {"poissons_ratio": 0.49}),
        (5, {"section": "plane_strain"}),
    ],
)
def test_thick_cylinder_is_of_second_order(
    cells: int, changed: dict[str, Any], order: Order
) -> None:
    def run(cells: int) -> xr.Dataset:
        return ThickCylinder(cell_count=cells, **changed).run()

    assert order(run, cells) == pytest.approx(2, abs=0.1)
    assert float(run(cells).error) <= (2 / cells) ** 2  # (h/a)^2
