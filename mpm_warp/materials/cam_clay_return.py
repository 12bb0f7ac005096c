"""The return of modified Cam clay to its yield surface: implicit, one scalar equation.

After Borja & Lee (1990). Symbols are those of `modified_cam_clay`; x plastic volume strain of a
step, e its strain, a = v / kappa, b = v / (lambda - kappa).

    p_c <- p_c exp(b x)
    p   <- p exp(a (e_v - x))
    s   <- share (s + 2 G dev e),    share = M^2 (2 p - p_c) / (M^2 (2 p - p_c) + 6 G x)

x is where f = 0: between 0, where f > 0, and the x of the critical state, 2 p = p_c, where f < 0,
on the wet side, on the dry side and at the tip. So the path of p over q at constant volume is exact
in steps of any size. The strain along it has an error of first order: a long step is taken in
parts. The flow is along s, whatever M follows.
"""

import functools
import math
from typing import Any

import warp as wp

from mpm_warp.kernel_types import (
    half,
    one,
    quarter,
    real,
    third,
    two,
    vec2,
    vec3,
    vec4,
    vector,
    zero,
)
from mpm_warp.materials.von_mises import j2

PART, MOST_PARTS = 0.1, 40
"""Elastic change of q in one part of a step, over M p_c, and most parts of a step."""
ITERATIONS = 60
"""Of Newton's method between bounds that each iteration narrows: 60 halvings would do too."""
WATER = 5
"""Place of K_w / n among the properties (M, a, b, r, G, K_w / n, least p, A, B)."""

vec9 = vector(9)
three, six = wp.constant(real(3.0)), wp.constant(real(6.0))
of_angle = wp.constant(real(-1.5 * math.sqrt(3.0)))  # tension is positive in s
rounding, tolerance = wp.constant(real(1e-13)), wp.constant(real(1e-10))
small, longest = wp.constant(real(1e-3)), wp.constant(real(PART))
near = wp.constant(real(1e-10))  # to the critical state, in the logarithm of 2 p / p_c


@functools.cache
def make_slope(by_angle: bool) -> Any:
    """The function (deviator, its J2, properties) -> M in its direction."""

    @wp.func
    def slope(s: vec4, J2: real, properties: vec9) -> real:
        M = properties[0]
        if wp.static(by_angle):
            if zero < J2:
                J3 = s[3] * (s[0] * s[1] - s[2] * s[2])
                cosine = wp.clamp(of_angle * J3 / (J2 * wp.sqrt(J2)), -one, one)
                M = one / (properties[7] * wp.cos(wp.acos(-properties[8] * cosine) / three))
        return M

    return slope


@wp.func
def deviator(tensor: vec4) -> vec4:
    """The tensor less its mean."""
    mean = third * (tensor[0] + tensor[1] + tensor[3])
    return vec4(tensor[0] - mean, tensor[1] - mean, tensor[2], tensor[3] - mean)


@wp.func
def growth(x: real) -> real:
    """exp(x), faster where x is small: by its series, to rounding."""
    if wp.abs(x) < small:
        return one + x * (one + half * x * (one + third * x * (one + quarter * x)))
    return wp.exp(x)


@wp.func
def shear_modulus(p: real, properties: vec9) -> real:
    """G at an effective mean stress."""
    return properties[3] * properties[1] * p + properties[4]


@wp.func
def moduli(stress: vec4, properties: vec9, state: vec3) -> vec2:
    """(G, K) of skeleton and water."""
    p = state[0]
    return vec2(shear_modulus(p, properties), properties[1] * p + properties[wp.static(WATER)])


@functools.cache
def make_yield_function(by_angle: bool) -> Any:
    """The function of `Law.yield_function`: distance from the middle of the ellipse, p_c / 2."""
    slope = make_slope(by_angle)

    @wp.func
    def measure_and_size(stress: vec4, properties: vec9, state: vec3) -> vec2:
        J2, middle = j2(stress), half * state[1]
        M, away = slope(deviator(stress), J2, properties), state[0] - middle
        return vec2(wp.sqrt(three * J2 / (M * M) + away * away), middle)

    return measure_and_size


@wp.func
def strength_at_critical_state(stress: vec4, properties: vec9, state: vec3) -> real:
    """M p / sqrt(3) where shear has led to the critical state."""
    share = properties[1] / (properties[1] + properties[2])  # Lam = a / (a + b)
    last = state[0] * wp.pow(half * state[1] / state[0], share)
    return properties[0] * last / wp.sqrt(three)


@wp.func
def is_outside(p: real, pc: real, J2: real, M: real) -> bool:
    """Whether f > 0, beyond rounding."""
    return three * J2 + M * M * p * (p - pc) > rounding * M * M * p * pc


@wp.func
def to_surface(trial: real, size: real, J2: real, G: real, M: real, properties: vec9) -> vec3:
    """(p, p_c, share of the deviator) at f = 0, by (p, p_c, J2 of the trial, G, M, properties)."""
    a, b = properties[1], properties[2]
    MM, square = M * M, three * J2
    last = wp.log(two * trial / size)  # (a + b) x at the critical state
    if wp.abs(last) < near:
        return vec3(trial, two * trial, wp.min(one, M * trial / wp.sqrt(square)))
    last /= a + b
    # f > 0 at x = low, f < 0 at x = high; Newton's method from low, halving where it fails.
    low, high, x = real(0.0), last, real(0.0)
    p, pc, share = one * trial, one * size, real(1.0)
    for _k in range(wp.static(ITERATIONS)):
        p, pc = trial * growth(-a * x), size * growth(b * x)
        rate = two * p - pc
        N = MM * rate
        D = N + six * G * x
        share = N / D
        f = square * share * share + MM * p * (p - pc)
        if wp.abs(f) <= tolerance * MM * p * pc:
            break
        if f > zero:
            low = x
        else:
            high = x
        dN = -MM * (two * a * p + b * pc)
        dshare = (dN - share * (dN + six * G)) / D
        df = two * square * share * dshare - MM * p * (a * rate + b * pc)
        x -= f / df
        if (x - low) * (x - high) >= zero:
            x = half * (low + high)
    # What is left goes to the size of the surface.
    return vec3(p, wp.max(pc, p + square * share * share / (MM * p)), share)


@functools.cache
def make_update(by_angle: bool) -> Any:
    """The function of `Law.update`; M follows the Lode angle where `by_angle` says so."""
    slope = make_slope(by_angle)

    @wp.func
    def consolidate_and_shear(
        stress: vec4, strain: vec4, time_step: real, properties: vec9, state: vec3
    ):
        e, e_v = deviator(strain), -(strain[0] + strain[1] + strain[3])
        a_e_v, water, floor = properties[1] * e_v, properties[wp.static(WATER)] * e_v, properties[6]
        before, p, pc = deviator(stress), one * state[0], one * state[1]
        G = shear_modulus(p, properties)
        s = before + (two * G) * e
        p = wp.max(p * growth(a_e_v), floor)
        J2 = j2(s)
        M = slope(s, J2, properties)
        if is_outside(p, pc, J2, M):
            length = two * G * wp.sqrt(three * j2(e)) / (M * pc)
            parts = wp.min(1 + int(length / longest), wp.static(MOST_PARTS))
            part = one / real(parts)
            if parts > 1:  # once more, from the start
                s, p = one * before, one * state[0]
            for _k in range(parts):
                if parts > 1:
                    G = shear_modulus(p, properties)
                    s += (two * G * part) * e
                    p = wp.max(p * growth(part * a_e_v), floor)
                    J2 = j2(s)
                    M = slope(s, J2, properties)
                if is_outside(p, pc, J2, M):
                    returned = to_surface(p, pc, J2, G, M, properties)
                    p, pc = wp.max(returned[0], floor), returned[1]
                    s *= returned[2]
        mean = third * (stress[0] + stress[1] + stress[3]) - (p - state[0]) - water
        total = s + mean * vec4(one, one, zero, one)
        return total, vec3(p, pc, state[2] + water)

    return consolidate_and_shear
