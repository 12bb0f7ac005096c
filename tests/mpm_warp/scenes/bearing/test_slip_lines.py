"""Slip lines against closed forms, and against limit loads integrated by others or before."""

import math

import pytest

from mpm_warp.scenes.bearing.slip_lines import SlipLines

DISC = 0.5 * math.pi
CONE = math.radians(30.0)


@pytest.mark.parametrize(
    ("half_angle", "adhesion_factor"), [(CONE, 0.0), (CONE, 0.5), (CONE, 1.0), (DISC, 0.0)]
)
def test_uniform_soil_has_its_closed_form(half_angle: float, adhesion_factor: float) -> None:
    """1 + beta + D + cos D + alpha cot(beta / 2), D = asin(alpha): each step is exact there.

    That of a smooth strip is 2 + pi.
    """
    lines = SlipLines(half_angle=half_angle, adhesion_factor=adhesion_factor, planar=True)
    turn = math.asin(adhesion_factor)
    shear = adhesion_factor / math.tan(half_angle)
    exact = 1.0 + 2.0 * half_angle + turn + math.cos(turn) + shear
    assert lines.limit_load == pytest.approx(exact, rel=1e-9)


def test_a_strip_bears_more_than_its_lower_bound() -> None:
    """2 + pi + k B / 4 su0 is in equilibrium and nowhere beyond the strength."""
    for kappa in (0.5, 2.0, 8.0):
        lines = SlipLines(half_angle=DISC, planar=True, strength_gradient_ratio=kappa)
        assert 2.0 + math.pi + 0.5 * kappa < lines.limit_load < (2.0 + math.pi) * (1.0 + kappa)


@pytest.mark.parametrize(
    ("half_angle", "adhesion_factor", "loads"),
    [
        (DISC, 0.0, {0.0: 5.69, 0.25: 5.982, 1.0: 6.723, 2.0: 7.556}),  # 5.69 by Shield 1955
        (CONE, 0.0, {0.0: 4.443, 0.25: 5.126, 0.5: 5.803, 2.0: 9.826}),
        (CONE, 0.5, {0.0: 5.679}),
        (CONE, 1.0, {0.0: 6.690, 0.25: 7.789, 1.0: 10.985, 2.0: 15.171}),
    ],
)
def test_loads_are_those_integrated_by_others(
    half_angle: float, adhesion_factor: float, loads: dict[float, float]
) -> None:
    """By kappa; to 0.2 %: what is left of the error of second order in the spacing of the lines."""
    for kappa, load in loads.items():
        lines = SlipLines(
            half_angle=half_angle, adhesion_factor=adhesion_factor, strength_gradient_ratio=kappa
        )
        assert lines.limit_load == pytest.approx(load, rel=2e-3)
