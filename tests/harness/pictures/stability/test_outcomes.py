"""What the stability map is made of: values along an axis, and why a case did not complete."""

from __future__ import annotations

import numpy as np
import pytest

from harness.pictures.drawing.quantities import Values
from harness.pictures.stability.outcomes import short_reason

VELOCITY = (
    "SimulationDiverged: velocity of particle 12 at [ 0.01, -0.1] m is [ 3, -4], at step 500, "
    "t = 1 s; healthy at step 0; try a smaller step"
)
STRESS = (
    "SimulationDiverged: stress of particle 7 at [0.1, 0.2] m is [1, 2, 3, 4], outside the yield "
    "surface by 0.02 of the strength, at step 500, t = 1 s; healthy at step 0; try a smaller step"
)


@pytest.mark.parametrize(
    ("numbers", "logarithmic"),
    [
        ([1.0, 10.0], True),
        ([1.0, 9.0], False),
        ([0.0, 1.0, 10.0], True),
        ([-1.0, 1.0, 10.0], False),
        ([0.0], False),
    ],
)
def test_an_axis_is_logarithmic_over_a_decade(numbers: list[float], logarithmic: bool) -> None:
    values = Values(name="stress", unit="Pa", numbers=np.array(numbers))
    assert values.logarithmic == logarithmic


@pytest.mark.parametrize(
    ("message", "short"),
    [
        (VELOCITY, "velocity of particle 12"),
        (
            STRESS,
            "stress of particle 7, outside the yield surface by 0.02 of the strength",
        ),
        ("worker killed by SIGSEGV, at 45% of the case", "worker killed by SIGSEGV"),
        ("ended after 200 s, at 4% of the case", "ended after 200 s"),
        ("", ""),
    ],
)
def test_a_reason_is_what_gave_way(message: str, short: str) -> None:
    assert short_reason(message) == short
