"""The contact law, branch by branch, through a kernel that does nothing but call it."""

import numpy as np
import pytest
import warp as wp

from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.contact import contact_law

ROUNDING = 1e-14
NORMAL = np.array([-0.6, 0.8])
TANGENT = np.array([0.8, 0.6])
MASS = 2.0


@wp.kernel(enable_backward=False)
def apply_contact_law(
    mass: wp.float64,
    jump: wp.array(dtype=wp.vec2d),
    normal: wp.array(dtype=wp.vec2d),
    pressing: wp.float64,
    friction: wp.float64,
    adhesion: wp.float64,
    pressure: wp.float64,
    impulse: wp.array(dtype=wp.vec3d),
):
    k = wp.tid()
    impulse[k] = contact_law(mass, jump[k], normal[k], pressing, friction, adhesion, pressure)


def impulse_of(
    normal_speed: float,
    slip: float,
    *,
    friction: float = 0.0,
    adhesion: float = 0.0,
    pressure: float = 0.0,
    pressing: float | None = None,
) -> tuple[float, Floats]:
    """Normal impulse and tangential impulse vector of a body with the given velocity jump.

    What presses the bodies is the node's own impulse where no other is given.
    """
    if pressing is None:
        pressing = MASS * normal_speed + pressure
    jump = wp.array([normal_speed * NORMAL + slip * TANGENT], dtype=wp.vec2d, device="cpu")
    normal = wp.array([NORMAL], dtype=wp.vec2d, device="cpu")
    impulse = wp.zeros(1, dtype=wp.vec3d, device="cpu")
    arguments = [MASS, jump, normal, pressing, friction, adhesion, pressure, impulse]
    wp.launch(apply_contact_law, 1, arguments, device="cpu")
    values = impulse.numpy()[0]
    return float(values[0]), values[1:]


def test_approach_without_friction_stops_the_normal_motion_alone() -> None:
    normal, tangential = impulse_of(0.5, 3.0)
    assert normal == pytest.approx(MASS * 0.5, rel=ROUNDING)
    np.testing.assert_allclose(tangential, 0.0, atol=ROUNDING)


def test_bodies_that_part_exchange_nothing_not_even_adhesion() -> None:
    normal, tangential = impulse_of(-0.5, 3.0, friction=0.5, adhesion=100.0)
    assert normal == 0.0
    np.testing.assert_array_equal(tangential, 0.0)


def test_sticking_cancels_the_slip() -> None:
    _, tangential = impulse_of(0.5, 0.1, friction=0.3, adhesion=0.0)
    np.testing.assert_allclose(tangential, MASS * 0.1 * TANGENT, rtol=ROUNDING)


@pytest.mark.parametrize("slip", [3.0, -3.0])
def test_sliding_transmits_friction_and_adhesion_against_the_slip(slip: float) -> None:
    _, tangential = impulse_of(0.5, slip, friction=0.3, adhesion=0.2)
    limit = 0.3 * MASS * 0.5 + 0.2
    np.testing.assert_allclose(tangential, limit * np.sign(slip) * TANGENT, rtol=ROUNDING)


def test_adhesion_does_not_depend_on_the_normal_impulse() -> None:
    for normal_speed in (1e-6, 1.0, 1e6):
        _, tangential = impulse_of(normal_speed, 1e3, adhesion=0.2)
        np.testing.assert_allclose(tangential, 0.2 * TANGENT, rtol=1e-9)


def test_in_situ_pressure_keeps_contact_under_less_tension_than_itself() -> None:
    """Excess tension up to the in-situ pressure is carried; friction feels the total."""
    normal, tangential = impulse_of(-0.5, 3.0, friction=0.3, pressure=1.5)
    assert normal == pytest.approx(-MASS * 0.5, rel=ROUNDING)
    np.testing.assert_allclose(tangential, 0.3 * (1.5 - 1.0) * TANGENT, rtol=1e-13)


def test_beyond_the_in_situ_pressure_the_bodies_part_and_no_total_traction_is_left() -> None:
    normal, tangential = impulse_of(-1.0, 3.0, friction=0.3, adhesion=0.2, pressure=1.5)
    assert normal == -1.5
    np.testing.assert_array_equal(tangential, 0.0)


def test_a_node_that_parts_in_a_pressed_neighbourhood_feels_friction_and_adhesion_alone() -> None:
    normal, tangential = impulse_of(-0.5, 3.0, friction=0.3, adhesion=0.2, pressing=2.0)
    assert normal == 0.0
    np.testing.assert_allclose(tangential, (0.3 * 2.0 + 0.2) * TANGENT, rtol=1e-13)
