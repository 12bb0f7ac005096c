"""The contact law, branch by branch, through a kernel that does nothing but call it."""

import numpy as np
import pytest
import warp as wp

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


ROUGH = {"friction": 0.3, "adhesion": 0.2}


@pytest.mark.parametrize(
    ("normal_speed", "slip", "given", "normal", "tangential"),
    [
        # An approach without friction stops the normal motion alone.
        (0.5, 3.0, {}, MASS * 0.5, 0.0),
        # Bodies that part exchange nothing, not even adhesion.
        (-0.5, 3.0, {"friction": 0.5, "adhesion": 100.0}, 0.0, 0.0),
        # Sticking cancels the slip.
        (0.5, 0.1, {"friction": 0.3}, MASS * 0.5, MASS * 0.1),
        # Sliding transmits friction and adhesion against the slip.
        (0.5, 3.0, ROUGH, MASS * 0.5, 0.3 * MASS * 0.5 + 0.2),
        (0.5, -3.0, ROUGH, MASS * 0.5, -0.3 * MASS * 0.5 - 0.2),
        # Adhesion does not depend on the normal impulse.
        (1e-6, 1e3, {"adhesion": 0.2}, MASS * 1e-6, 0.2),
        (1e6, 1e3, {"adhesion": 0.2}, MASS * 1e6, 0.2),
        # Excess tension up to the in-situ pressure is carried; friction feels the total.
        (-0.5, 3.0, {"friction": 0.3, "pressure": 1.5}, -MASS * 0.5, 0.3 * (1.5 - 1.0)),
        # Beyond it the bodies part, and no total traction is left.
        (-1.0, 3.0, {**ROUGH, "pressure": 1.5}, -1.5, 0.0),
        # A node that parts in a pressed neighbourhood feels friction and adhesion alone.
        (-0.5, 3.0, {**ROUGH, "pressing": 2.0}, 0.0, 0.3 * 2.0 + 0.2),
    ],
)
def test_the_impulse_is_that_of_each_branch(
    normal_speed: float, slip: float, given: dict[str, float], normal: float, tangential: float
) -> None:
    """What presses the bodies is the node's own impulse where no other is given."""
    pressure = given.get("pressure", 0.0)
    pressing = given.get("pressing", MASS * normal_speed + pressure)
    jump = wp.array([normal_speed * NORMAL + slip * TANGENT], dtype=wp.vec2d, device="cpu")
    unit = wp.array([NORMAL], dtype=wp.vec2d, device="cpu")
    impulse = wp.zeros(1, dtype=wp.vec3d, device="cpu")
    limits = [given.get("friction", 0.0), given.get("adhesion", 0.0), pressure]
    wp.launch(apply_contact_law, 1, [MASS, jump, unit, pressing, *limits, impulse], device="cpu")
    expected = [normal, *(tangential * TANGENT)]
    rounding = ROUNDING * np.hypot(MASS * normal_speed, MASS * slip)
    np.testing.assert_allclose(impulse.numpy()[0], expected, rtol=ROUNDING, atol=rounding)
