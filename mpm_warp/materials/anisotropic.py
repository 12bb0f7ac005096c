"""Clay whose strength depends on direction: more in compression than in shear or extension.

The yield surface is an ellipsoid in the space of deviators. Compression is positive. Symbols: s_a
stress along the axis of the ground, which is vertical at first, s_b and s_t stresses normal to it,
in the plane and out of it, su_C, su_E, su_S, su_H the strengths, k the present value of su_C.

    eta = s_a - (s_b + s_t) / 2,   zeta = (s_b - s_t) / 2,   tau = s_ab
    (x, y, w) = (eta / sqrt(3), zeta, tau),   x^2 + y^2 + w^2 = J2
    ((x - c k) / (a_x k))^2 + (y / (a_y k))^2 + (w / (a_w k))^2 = 1

    c = (su_C - su_E) / (sqrt(3) su_C),   a_x = (su_C + su_E) / (sqrt(3) su_C)
    a_y = su_H / su_C,   a_w^2 = (su_S / su_C)^2 - 3/4 c^2

With these, each strength is the greatest shear stress, half the difference of the extreme stresses,
at the end of its test. In simple shear the flow is pure shear where eta = su_C - su_E, and the
shear stress on the horizontal plane is a_w su_C. With su_C = su_E = sqrt(3)/2 k and su_S = su_H = k
the ellipsoid is the cylinder of von Mises.

Flow is associated and the metric is that of elastic shear energy, so the stress returns to the
nearest point of the ellipsoid. With X_i the components of the trial stress from the centre and
b_i = 1 / a_i^2, this point is X_i / (1 + m b_i), where

    N(m) = sqrt(sum b_i (X_i / k)^2 / (1 + m b_i)^2) = 1

1 / N is concave in m, so Newton's method from m = 0 rises to the root and never passes it.

The axis of the ground turns with the soil. The state holds cos(2 th) and sin(2 th) of its angle th
from the vertical; the spin turns them as it turns the stress. The hoop direction does not turn. The
argument `shape` of the device functions is (c, b_x, b_y, b_w, cos(2 th), sin(2 th)).

After Davis & Christian (1971, J. Soil Mech. Found. Div. 97:753-773), extended to (x, y, w).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import warp as wp

from mpm_warp.errors import SceneError
from mpm_warp.fields.checked import complete
from mpm_warp.fields.checks import POSITIVE, check_number
from mpm_warp.fields.declaration import parameter
from mpm_warp.kernel_types import half, one, real, third, two, vec3, vec4, vec7, vector, zero
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic, limit_pressure
from mpm_warp.materials.von_mises import root_of_j2

STRENGTHS = (
    "strength_compression",
    "strength_extension",
    "strength_simple_shear",
    "strength_horizontal",
)
STRAINS: Mapping[str, tuple[float, float, float]] = {
    "triaxial_compression": (1.0, 0.0, 0.0),
    "triaxial_extension": (-1.0, 0.0, 0.0),
    "simple_shear": (0.0, 0.0, 1.0),
    "plane_strain": (math.sqrt(0.75), -0.5, 0.0),
    "pressuremeter": (0.0, 1.0, 0.0),
}
"""Direction of the strain in (x, y, w) by element test."""

vec6 = vector(6)
three = wp.constant(real(3.0))
tenth, eighth = wp.constant(real(0.1)), wp.constant(real(0.125))
root_of_three = wp.constant(real(math.sqrt(3.0)))
minus_half_over_root = wp.constant(real(-0.5 / math.sqrt(3.0)))
NEWTON_STEPS = 40
"""Greatest number; 2 to 5 are needed where the semi-axes differ by a factor of 2."""
converged = wp.constant(real(1e-10))
"""N^2 - 1 at which the iteration ends; a last scaling removes the rest."""


@wp.func
def deviator_along_axes(stress: vec4, shape: vec6) -> vec3:
    """(x, y, w), compression positive; the signs of y and w are arbitrary."""
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
    """The stress with this mean, the inverse of `deviator_along_axes`."""
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
    """Whether the stress is within the ellipsoid."""
    return weighted_square(from_centre(stress, strength, shape), shape) <= strength * strength


@wp.func
def size_of_ellipsoid(stress: vec4, shape: vec6) -> real:
    """The k of the ellipsoid through the stress."""
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
    """The point of the ellipsoid nearest to X, which is outside; both relative to the centre."""
    m, share, nearest = real(0.0), vec3(one, one, one), vec3() + X
    square = strength * strength
    inverse = one / square  # divisions are slow
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
    """sqrt(1 + x) - 1; for small x a lower bound without a root."""
    if x < tenth:
        return x * (half - eighth * x)
    return wp.sqrt(one + x) - one


@wp.func
def normal_at(X: vec3, shape: vec6) -> vec3:
    """b_i X_i."""
    return vec3(shape[1] * X[0], shape[2] * X[1], shape[3] * X[2])


@wp.func
def nearest_of_ellipsoid(trial: vec4, strength: real, shape: vec6) -> vec4:
    """The nearest stress on the ellipsoid, with the same mean."""
    nearest = nearest_from_centre(from_centre(trial, strength, shape), strength, shape)
    mean = third * (trial[0] + trial[1] + trial[3])
    x = vec3(nearest[0] + shape[0] * strength, nearest[1], nearest[2])
    return stress_of_deviator(x, mean, shape)


@wp.func
def softened_ellipsoid(
    trial: vec4, strength: real, left: real, G: real, decay: real, shape: vec6
) -> real:
    """Share of the losable strength `left` that remains after a return."""
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


@wp.func
def turned_axis(state: Any, motion: vec7):
    """The state after a turn by the spin; its last two numbers are the axis."""
    cos, sin = motion[6], motion[5]  # of twice the angle
    c, s = state[len(state) - 2], state[len(state) - 1]
    scale = half * (three - c * c - s * s)  # keeps the length at 1 over any number of steps
    cos, sin = scale * cos, scale * sin
    state[len(state) - 2] = cos * c - sin * s
    state[len(state) - 1] = sin * c + cos * s
    return state


@dataclass(frozen=True, kw_only=True)
class Anisotropic(PerfectlyPlastic):
    """Clay in total stress with a strength by direction.

    The fields are su_C, su_E, su_S, su_H [Pa], > 0. su_S must be more than half the difference of
    su_C and su_E.

    Attributes:
        strength: elsewhere su, here su_C [Pa].

    Raises:
        SceneError: a strength is not allowed, or is not possible with the others.

    Example:
        >>> clay = Anisotropic(
        ...     strength_compression=20e3,
        ...     strength_extension=14e3,
        ...     strength_simple_shear=16e3,
        ...     strength_horizontal=16e3,
        ...     shear_modulus=1e6,
        ...     poissons_ratio=0.49,
        ...     density=1700.0,
        ... )
        >>> round(clay.undrained_strength("triaxial_extension"))  # [Pa]
        14000
    """

    strength: float = field(init=False)
    strength_compression: float = parameter(
        None, "strength in triaxial compression, which results are over", unit="Pa"
    )
    strength_extension: float = parameter(None, "strength in triaxial extension", unit="Pa")
    strength_simple_shear: float = parameter(
        None, "strength in simple shear on the horizontal plane", unit="Pa"
    )
    strength_horizontal: float = parameter(
        None,
        "strength in shear of the horizontal plane, as around a pressuremeter (default: "
        "(compression + extension) / sqrt(3))",
        unit="Pa",
    )
    axis: ClassVar[Mapping[str, float]] = {"axis_cos": 1.0, "axis_sin": 0.0}
    reference_test: ClassVar[str] = "triaxial_compression"

    def __post_init__(self) -> None:
        for name in STRENGTHS:
            if name == "strength_horizontal" and self.strength_horizontal is None:
                across = (self.strength_compression + self.strength_extension) / math.sqrt(3.0)
                complete(self, strength_horizontal=across)
            if getattr(self, name) is None:
                raise SceneError(f"Anisotropic: {name} is missing")
            check_number(f"Anisotropic: {name}", getattr(self, name), POSITIVE, unit="Pa")
        compression, extension = self.strength_compression, self.strength_extension
        room = 2.0 * self.strength_simple_shear
        if not abs(compression - extension) < room:
            raise SceneError(
                f"Anisotropic: strength_extension = {extension:g} Pa must be > "
                f"{max(0.0, compression - room):g} and < {compression + room:g}, as "
                "strength_simple_shear must be more than half the difference of compression and "
                "extension"
            )
        complete(self, strength=compression)
        super().__post_init__()

    @property
    def shape(self) -> tuple[float, ...]:
        """(c, b_x, b_y, b_w)."""
        C, E, S, H = (getattr(self, name) / self.strength_compression for name in STRENGTHS)
        centre = (C - E) / math.sqrt(3.0)
        across = S * S - 0.75 * centre * centre
        return centre, 3.0 / (C + E) ** 2, 1.0 / H**2, 1.0 / across

    @property
    def limit_pressure(self) -> float:
        """Limit pressure of a spherical cavity [Pa], the greatest strength in all directions."""
        centre, *inverse_squares = self.shape
        greatest = abs(centre) + 1.0 / math.sqrt(min(inverse_squares))
        half_in_compression = math.sqrt(0.75) * greatest * self.strength
        return limit_pressure(self.shear_modulus, half_in_compression)

    def undrained_strength(self, test: str) -> float:
        """See `Material`; the ellipsoid's normal at the end of a test is along its strain."""
        centre, *inverse_squares = self.shape
        n, b = np.array(STRAINS[test]), np.array(inverse_squares)
        x, y, w = np.array([centre, 0.0, 0.0]) + n / b / math.sqrt(float(np.sum(n * n / b)))
        third_of_eta = x / math.sqrt(3.0)
        in_plane = [[2.0 * third_of_eta, w], [w, y - third_of_eta]]
        principal = *np.linalg.eigvalsh(in_plane), -y - third_of_eta
        return 0.5 * self.strength * float(np.ptp(principal))

    measure = size_of_ellipsoid
    within = within_ellipsoid
    nearest = nearest_of_ellipsoid
    shear_measure = root_of_j2
    softened = softened_ellipsoid

    def turn(self) -> Any:
        """See `Material`."""
        return turned_axis
