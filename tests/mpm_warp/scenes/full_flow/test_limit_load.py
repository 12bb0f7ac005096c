"""The forces on a cylinder and a sphere in full flow against what is known of them."""

from typing import Any

import pytest

from mpm_warp.scenes.full_flow.limit_load import FullFlow, FullFlowCylinder, FullFlowSphere

pytestmark = pytest.mark.slow

CELLS = 4


@pytest.mark.parametrize(
    ("body", "changed"),
    [
        (FullFlowCylinder, {"adhesion_factor": 0.0}),
        (FullFlowCylinder, {"adhesion_factor": 1.0}),
        (FullFlowSphere, {"adhesion_factor": 0.0}),
        (FullFlowSphere, {"adhesion_factor": 1.0}),
        (FullFlowSphere, {"adhesion_factor": 1.0, "material": "von_mises"}),
    ],
)
def test_force_on_a_body_in_full_flow(body: type[FullFlow], changed: dict[str, Any]) -> None:
    """That which is known, or one within its bounds."""
    result = body(cells_per_radius=CELLS, **changed).run()
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    assert float(result.error) <= 1 / (CELLS * result.bearing_capacity)


def test_where_nothing_is_known_nothing_is_compared() -> None:
    result = FullFlowSphere(cells_per_radius=1, adhesion_factor=0.5, displacement=60.0).run()
    assert not {"error", "bearing_capacity_exact"} & set(result)
