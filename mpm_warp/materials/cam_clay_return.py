"""The return of modified Cam clay to its yield surface: implicit, one scalar equation.

After Borja & Lee (1990). Symbols are those of `modified_cam_clay`; x plastic volume strain of a
step, e its strain, a = v / kappa, b = v / (lambda - kappa), k = 3 / M^2, so that q^2 / M^2 = k J2.

    p_c <- p_c exp(b x)
    p   <- p exp(a (e_v - x))
    s   <- share (s + 2 G dev e),    share = N / D,  N = 2 p - p_c,  D = N + 2 G k x
    0    = k J2 N^2 + p (p - p_c) D^2

The root x of f lies between 0, where f > 0, and the x of the critical state, 2 p = p_c, where
f < 0. This holds on the wet side, on the dry side and at the tip. The path of p over q at constant
volume is exact in steps of any size. The strain along it has an error of first order, so a long
step is divided into parts. The flow is along s, also where M depends on the Lode angle.

Where M follows the Lode angle, w = q / M is the greatest root of a cubic equation. Tension is
positive in J3; M is that in compression, and 1 / (1 / M + 1 / 3) is that in extension:

    w^3 = (1 + T / 3) J2 w + (1 + T / 2) J3,    T = (3 - M) (3 + 2 M) / M^2
"""

import functools
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.kernel_types import half, one, quarter, real, third, two, vec2, vec3, vec4, vec7, zero
from mpm_warp.materials.von_mises import j2
from mpm_warp.materials.yield_check import YIELD_ROUNDINGS

PART, MOST_PARTS = 0.1, 40
"""Greatest elastic change of q in one part of a step, over M p_c; greatest number of parts."""
ITERATIONS = 100
"""Greatest number of Newton's iterations between bounds; as many bisections would converge too."""
ROOTS = 40
"""Greatest number of iterations for w; 2 are needed near the surface."""
WATER = 5
"""Position of K_w / n in the properties (M, a, b, r, G, K_w / n, least p)."""

three = wp.constant(real(3.0))
# Over p_c. At the tip a stress is then beyond the surface by half of what the watch allows.
rounding = wp.constant(real(0.25 * YIELD_ROUNDINGS * np.finfo(float).eps))
tolerance = wp.constant(real(1e-10))
tiny = wp.constant(real(1e-60))  # J2 [Pa2] below which a deviator has no direction
small = wp.constant(real(1e-3))
longest, most_parts = wp.constant(real(PART)), wp.constant(real(MOST_PARTS))
near = wp.constant(real(1e-10))  # distance from the critical state, over p_c
last_change = wp.constant(real(1e-5))  # relative change of w; the error left is of third order


@wp.func
def cubic(s: vec4, J2: real, M: real) -> vec2:
    """(A, B) of w^3 = A w + B."""
    T = (three - M) * (three + two * M) / (M * M)
    J3 = s[3] * (s[0] * s[1] - s[2] * s[2])
    return vec2((one + third * T) * J2, (one + half * T) * J3)


@wp.func
def k_in_compression(M: real) -> real:
    """The k of compression, the least k."""
    return three / (M * M)


@wp.func
def k_in_extension(M: real) -> real:
    """The k of extension, the greatest k, where M follows the Lode angle."""
    root = one / M + third
    return three * root * root


@wp.func
def deviator(tensor: vec4) -> vec4:
    """The deviator of a tensor."""
    mean = third * (tensor[0] + tensor[1] + tensor[3])
    return vec4(tensor[0] - mean, tensor[1] - mean, tensor[2], tensor[3] - mean)


@wp.func
def growth(x: real) -> real:
    """exp(x), for small x by its series, which is faster and exact to rounding."""
    if wp.abs(x) < small:
        return one + x * (one + half * x * (one + third * x * (one + quarter * x)))
    return wp.exp(x)


@wp.func
def shear_modulus(p: real, properties: vec7) -> real:
    """G at the effective mean stress p."""
    return properties[3] * properties[1] * p + properties[4]


@wp.func
def moduli(stress: vec4, properties: vec7, state: vec3) -> vec2:
    """(G, K) of skeleton and water."""
    p = state[0]
    return vec2(shear_modulus(p, properties), properties[1] * p + properties[wp.static(WATER)])


@wp.func
def strength_at_critical_state(stress: vec4, properties: vec7, state: vec3) -> real:
    """M p / sqrt(3), p at the critical state, which undrained shear does not change."""
    share = properties[1] / (properties[1] + properties[2])  # Lam = a / (a + b)
    last = state[0] * wp.pow(half * state[1] / state[0], share)
    return properties[0] * last / wp.sqrt(three)


@wp.func
def to_surface(trial: real, size: real, square: real, rate: real, properties: vec7) -> vec3:
    """(p, p_c, share of the deviator) at f = 0.

    Arguments are p, p_c, w^2 of the trial stress, 2 G k and the properties.
    """
    a, b = properties[1], properties[2]
    p, pc, N = one * trial, one * size, two * trial - size
    if wp.abs(N) < near * size:
        return vec3(trial, two * trial, wp.min(one, trial / wp.sqrt(square)))
    # f > 0 at x = low, f < 0 at x = high; Newton's method from low, bisection where it fails.
    # At first high is at or beyond the critical state, since ln y is between 1 - 1 / y and y - 1.
    # Beyond this state f has another root, at which the deviator would have changed its sign.
    is_wet = zero < N
    low, high, x = real(0.0), N / (wp.min(two * trial, size) * (a + b)), real(0.0)
    D = one * N
    for _k in range(wp.static(ITERATIONS)):
        p, pc = trial * growth(-a * x), size * growth(b * x)
        N = two * p - pc
        D = N + rate * x
        below, DD = p * (p - pc), D * D
        f = square * N * N + below * DD
        is_before = (zero < N) == is_wet
        if is_before and wp.abs(f) <= tolerance * p * pc * DD:
            break
        if f > zero and is_before:
            low = x
        else:
            high = x
        dN = -two * a * p - b * pc
        df = two * (square * N * dN + below * D * (dN + rate)) - p * (a * N + b * pc) * DD
        x -= f / df
        if not (is_before and (x - low) * (x - high) < zero):
            x = half * (low + high)
    share = N / D
    # The error left goes into the size of the surface.
    return vec3(p, wp.max(pc, p + square * share * share / p), share)


@functools.cache
def make_functions(by_angle: bool) -> tuple[Any, Any]:
    """The update and the yield function; `by_angle`: M follows the Lode angle."""

    @wp.func
    def is_outside(s: vec4, J2: real, p: real, pc: real, properties: vec7) -> bool:
        # Whether f > 0 beyond rounding, without solving for w.
        M = properties[0]
        square = p * (pc - p + rounding * pc)  # w^2 on the surface
        if square < k_in_compression(M) * J2:
            return True
        if wp.static(by_angle):
            if square < k_in_extension(M) * J2:
                w, AB = wp.sqrt(square), cubic(s, J2, M)
                return w * (square - AB[0]) < AB[1]
        return False

    @wp.func
    def k_along(s: vec4, J2: real, guess: real, properties: vec7) -> real:
        # k in the direction of s, from a guess of w^2.
        M = properties[0]
        k = k_in_compression(M)
        if wp.static(by_angle):
            if tiny < J2:
                AB = cubic(s, J2, M)
                w = wp.sqrt(wp.clamp(guess, k * J2, k_in_extension(M) * J2))
                for _k in range(wp.static(ROOTS)):  # Halley's method
                    f, df = w * (w * w - AB[0]) - AB[1], three * w * w - AB[0]
                    change = f * df / (df * df - three * w * f)
                    w -= change
                    if wp.abs(change) <= last_change * w:
                        break
                k = w * w / J2
        return k

    @wp.func
    def measure_and_size(stress: vec4, properties: vec7, state: vec3) -> vec2:
        # Distance from the middle of the ellipse, p_c / 2.
        J2, p, middle = j2(stress), state[0], half * state[1]
        k = k_along(deviator(stress), J2, p * (state[1] - p), properties)
        return vec2(wp.sqrt(k * J2 + (p - middle) * (p - middle)), middle)

    @wp.func
    def consolidate_and_shear(
        stress: vec4, strain: vec4, time_step: real, properties: vec7, state: vec3
    ):
        e, e_v = deviator(strain), -(strain[0] + strain[1] + strain[3])
        a_e_v, water, floor = properties[1] * e_v, properties[wp.static(WATER)] * e_v, properties[6]
        before, p, pc = deviator(stress), one * state[0], one * state[1]
        G = shear_modulus(p, properties)
        s = before + (two * G) * e
        p = wp.max(p * growth(a_e_v), floor)
        J2 = j2(s)
        if is_outside(s, J2, p, pc, properties):
            parts, share, length = 1, real(1.0), longest * properties[0] * pc
            change = two * two * three * G * G * j2(e)  # square of the elastic change of q
            if change > length * length:  # starts again, in parts
                parts = 1 + int(wp.min(wp.sqrt(change) / length, most_parts - one))
                share = one / real(parts)
                s, p = one * before, one * state[0]
            for _k in range(parts):
                if parts > 1:
                    G = shear_modulus(p, properties)
                    s += (two * G * share) * e
                    p = wp.max(p * growth(share * a_e_v), floor)
                    J2 = j2(s)
                if parts == 1 or is_outside(s, J2, p, pc, properties):
                    k = k_along(s, J2, p * (pc - p), properties)
                    returned = to_surface(p, pc, k * J2, two * G * k, properties)
                    p, pc = wp.max(returned[0], floor), returned[1]
                    s *= returned[2]
        mean = third * (stress[0] + stress[1] + stress[3]) - (p - state[0]) - water
        total = s + mean * vec4(one, one, zero, one)
        return total, vec3(p, pc, state[2] + water)

    return consolidate_and_shear, measure_and_size
