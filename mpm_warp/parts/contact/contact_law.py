"""The adhesive contact law: what impulse an interface transmits in a step.

After Ceccato, Beuth & Simonini (2017, Procedia Engineering 175:182-188) and Bardenhagen et al.
(2001, CMES 2:509-522): a corrector on the velocities predicted for a body alone.

Symbols: m mass of the body at the node, d its predicted velocity less that of the combined system
(of a rigid body: the prescribed one), n unit normal, outward from the body, P impulse that presses
the bodies together, mu friction coefficient, a A adhesion times contact area, p A in-situ pressure
times contact area, which the simulated stress leaves out.

    J_n = m d.n, at least -p A dt: there the bodies part
    J_t = m |w|, w = d - d.n n,     at most mu P + a A dt      (stick, slip)  while P > 0, else 0
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.precision import Precision


@functools.cache
def make_contact_law(precision: Precision) -> Any:
    """The function (m, d, n, P, mu, a A dt, p A dt) -> (J_n, J_t w/|w|): impulse from the body."""
    real, vec2, vec3 = precision.real, precision.vec2, precision.vec3
    zero = wp.constant(real(0.0))

    @wp.func
    def contact_law(
        m: real, d: vec2, n: vec2, pressing: real, friction: real, adhesion: real, pressure: real
    ) -> vec3:
        normal_speed = wp.dot(d, n)
        J_n = wp.max(m * normal_speed, -pressure)
        if pressing <= zero:
            return vec3(J_n, zero, zero)
        w = d - normal_speed * n
        slip = m * wp.length(w)
        limit = friction * pressing + adhesion
        transmitted = m * w
        if slip > limit:
            transmitted = (limit / slip) * transmitted
        return vec3(J_n, transmitted[0], transmitted[1])

    return contact_law
