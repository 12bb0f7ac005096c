"""The ellipsoid that soil with strength by direction yields at: size, nearest point, softening.

Symbols: (x, y, w) the deviator along the axis of the ground, whose length is sqrt(J2); k strength,
c k its centre on x, X_i components from there, b_i = 1 / a_i^2 of the semi-axes a_i k. A shape is
(c, b_x, b_y, b_w) and cos(2 th), sin(2 th) of the angle of the axis from the vertical; how they
follow from strengths stands in `anisotropic.py`.

    sum b_i X_i^2 = k^2

The metric is that of elastic shear energy, so the return of associated flow is to the nearest
point. It is X_i / (1 + m b_i) where

    N(m) = sqrt(sum b_i (X_i / k)^2 / (1 + m b_i)^2) = 1

1 / N is concave in m, so Newton's method rises from m = 0 to the root and never beyond it.
"""

import math

import warp as wp

from mpm_warp.kernel_types import half, one, real, third, two, vec3, vec4, vector, zero

vec6 = vector(6)
three = wp.constant(real(3.0))
tenth, eighth = wp.constant(real(0.1)), wp.constant(real(0.125))
root_of_three = wp.constant(real(math.sqrt(3.0)))
minus_half_over_root = wp.constant(real(-0.5 / math.sqrt(3.0)))
NEWTON_STEPS = 40
"""More than it takes: 2 to 5 where the semi-axes differ by 2."""
converged = wp.constant(real(1e-10))
"""N^2 - 1 at which the return ends; what is left is taken off along the radius."""


@wp.func
def deviator_along_axes(stress: vec4, shape: vec6) -> vec3:
    """(x, y, w), compression positive but for the signs of y and w, which do not count."""
    along, around = half * (stress[0] + stress[1]), stress[3]
    difference, shear = half * (stress[1] - stress[0]), stress[2]
    d = difference * shape[4] + shear * shape[5]  # (s_a - s_b) / 2, tension positive
    u = along - around
    return vec3(
        (u + three * d) * minus_half_over_root,
        half * (u - d),
        shear * shape[4] - difference * shape[5],
    )


@wp.func
def stress_of_deviator(x: vec3, mean: real, shape: vec6) -> vec4:
    """The stress of that mean, the inverse of `deviator_along_axes`."""
    eta = root_of_three * x[0]
    d = -half * (eta + x[1])
    u = two * x[1] + d
    along = mean + third * u
    difference = d * shape[4] - x[2] * shape[5]
    shear = d * shape[5] + x[2] * shape[4]
    return vec4(along - difference, along + difference, shear, mean - two * third * u)


@wp.func
def from_centre(stress: vec4, strength: real, shape: vec6) -> vec3:
    """(x - c k, y, w)."""
    x = deviator_along_axes(stress, shape)
    return vec3(x[0] - shape[0] * strength, x[1], x[2])


@wp.func
def weighted_square(X: vec3, shape: vec6) -> real:
    """Sum of b_i X_i^2."""
    return shape[1] * X[0] * X[0] + shape[2] * X[1] * X[1] + shape[3] * X[2] * X[2]


@wp.func
def within_ellipsoid(stress: vec4, strength: real, shape: vec6) -> bool:
    """Whether the stress is within the yield surface."""
    return weighted_square(from_centre(stress, strength, shape), shape) <= strength * strength


@wp.func
def size_of_ellipsoid(stress: vec4, shape: vec6) -> real:
    """The k of the ellipsoid that the stress is on."""
    # sum b_i x_i^2 - 2 b_x c x k - (1 - b_x c^2) k^2 = 0
    x = deviator_along_axes(stress, shape)
    square = weighted_square(x, shape)
    if square == zero:
        return zero
    p = shape[1] * shape[0] * x[0]
    q = one - shape[1] * shape[0] * shape[0]
    root = wp.sqrt(p * p + q * square)
    if p > zero:
        return square / (p + root)
    return (root - p) / q


@wp.func
def nearest_from_centre(X: vec3, strength: real, shape: vec6) -> vec3:
    """The point of the ellipsoid nearest to X outside of it, both from the centre."""
    m, share, nearest = real(0.0), vec3(one, one, one), vec3() + X
    square = strength * strength
    inverse = one / square  # a division takes longer than all else here
    excess = weighted_square(nearest, shape) * inverse - one  # N^2 - 1
    for _step in range(wp.static(NEWTON_STEPS)):
        if excess <= converged:
            break
        normal = normal_at(nearest, shape)
        steepness = wp.dot(wp.cw_mul(share, normal), normal)
        m += root_less_one(excess) * (one + excess) * square / steepness
        p, q, r = one + m * shape[1], one + m * shape[2], one + m * shape[3]
        share = (one / (p * q * r)) * vec3(q * r, p * r, p * q)
        nearest = wp.cw_mul(share, X)
        excess = weighted_square(nearest, shape) * inverse - one
    return (one - half * excess) * nearest


@wp.func
def root_less_one(x: real) -> real:
    """sqrt(1 + x) - 1, and where x is small not more than that."""
    if x < tenth:
        return x * (half - eighth * x)
    return wp.sqrt(one + x) - one


@wp.func
def normal_at(X: vec3, shape: vec6) -> vec3:
    """b_i X_i."""
    return vec3(shape[1] * X[0], shape[2] * X[1], shape[3] * X[2])


@wp.func
def nearest_of_ellipsoid(trial: vec4, strength: real, shape: vec6) -> vec4:
    """The nearest stress of the yield surface, of the same mean."""
    nearest = nearest_from_centre(from_centre(trial, strength, shape), strength, shape)
    mean = third * (trial[0] + trial[1] + trial[3])
    x = vec3(nearest[0] + shape[0] * strength, nearest[1], nearest[2])
    return stress_of_deviator(x, mean, shape)


@wp.func
def softened_ellipsoid(
    trial: vec4, strength: real, left: real, G: real, decay: real, shape: vec6
) -> real:
    """What a return leaves of the strength that can be lost."""
    # Newton's method for |trial - nearest| = G dxi. The distance falls by n x / k as k rises.
    plastic, kept = real(0.0), real(1.0)
    for _step in range(2):
        k = strength - left * (one - kept)
        X = from_centre(trial, k, shape)
        nearest = nearest_from_centre(X, k, shape)
        normal = wp.normalize(normal_at(nearest, shape))
        support = wp.dot(normal, nearest) / k + normal[0] * shape[0]
        missing = wp.length(X - nearest) - G * plastic
        plastic += missing / (G - support * decay * left * kept)
        kept = wp.exp(-decay * plastic)
    return kept
