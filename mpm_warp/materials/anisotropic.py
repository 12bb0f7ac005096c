"""Clay whose strength depends on direction: more in compression than in shear or extension.

The yield surface is an ellipsoid in the space of deviators. Compression positive: eta, zeta, tau
from the stresses s_a along the axis of the ground (vertical at first), s_b and s_t across it in the
plane and around; su_C, su_E, su_S, su_H the strengths; k strength su_C at the moment.

    eta = s_a - (s_b + s_t) / 2,   zeta = (s_b - s_t) / 2,   tau = s_ab
    (x, y, w) = (eta / sqrt(3), zeta, tau),   x^2 + y^2 + w^2 = J2
    ((x - c k) / (a_x k))^2 + (y / (a_y k))^2 + (w / (a_w k))^2 = 1

    c = (su_C - su_E) / (sqrt(3) su_C),   a_x = (su_C + su_E) / (sqrt(3) su_C)
    a_y = su_H / su_C,   a_w^2 = (su_S / su_C)^2 - 3/4 c^2

so that each strength is the greatest shear stress, half the difference of the extreme stresses, at
the end of its test: in simple shear the flow is pure shear where eta = su_C - su_E, and the shear
stress on the horizontal plane is a_w su_C. With su_C = su_E = sqrt(3)/2 k, su_S = su_H = k it is
the cylinder of von Mises.

Flow is associated; the return is to the nearest point of the ellipsoid (`ellipsoid.py`).

The axis of the ground turns with the soil. Its angle from the vertical, th, is remembered as
cos(2 th) and sin(2 th), which the spin turns as it turns the stress. The hoop direction stays.

After Davis & Christian (1971, J. Soil Mech. Found. Div. 97:753-773), here in all of (x, y, w).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import warp as wp

from mpm_warp.arguments import POSITIVE, check_number
from mpm_warp.errors import SceneError
from mpm_warp.kernel_types import half, real, vec7
from mpm_warp.materials.ellipsoid import (
    nearest_of_ellipsoid,
    size_of_ellipsoid,
    softened_ellipsoid,
    within_ellipsoid,
)
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic, limit_pressure
from mpm_warp.materials.von_mises import root_of_j2
from mpm_warp.parameters import parameter

STRENGTHS = (
    "strength_compression",
    "strength_extension",
    "strength_simple_shear",
    "strength_horizontal",
)
"""The parameters that are strengths."""
STRAINS: Mapping[str, tuple[float, float, float]] = {
    "triaxial_compression": (1.0, 0.0, 0.0),
    "triaxial_extension": (-1.0, 0.0, 0.0),
    "simple_shear": (0.0, 0.0, 1.0),
    "plane_strain": (math.sqrt(0.75), -0.5, 0.0),
    "pressuremeter": (0.0, 1.0, 0.0),
}
"""Directions of the strain in (x, y, w) of element tests."""


@wp.func
def turned_axis(state: Any, motion: vec7):
    """The state, whose last two numbers are the axis, after a turn by the spin."""
    cos, sin = motion[6], motion[5]  # of twice the turn
    c, s = state[len(state) - 2], state[len(state) - 1]
    scale = half * (real(3.0) - c * c - s * s)  # keeps it of length 1, whatever the number of steps
    cos, sin = scale * cos, scale * sin
    state[len(state) - 2] = cos * c - sin * s
    state[len(state) - 1] = sin * c + cos * s
    return state


@dataclass(frozen=True, kw_only=True)
class Anisotropic(PerfectlyPlastic):
    """Total stress; what is called strength and su elsewhere is that in triaxial compression.

    Attributes:
        strength_compression: su_C in triaxial compression along the axis [Pa], > 0.
        strength_extension: su_E in triaxial extension [Pa], > 0.
        strength_simple_shear: su_S in simple shear on the plane across the axis [Pa], more than
            half the difference of the two.
        strength_horizontal: su_H in shear within that plane, as around a pressuremeter [Pa], > 0;
            None: (su_C + su_E) / sqrt(3).

    Raises:
        SceneError: a strength is not allowed, or is not possible with the others.
    """

    strength: float = field(init=False)  # that in compression
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
    shape_count: ClassVar[int] = 4
    reference_test: ClassVar[str] = "triaxial_compression"

    def __post_init__(self) -> None:
        for name in STRENGTHS[:3]:
            check_number(f"Anisotropic: {name}", getattr(self, name), POSITIVE, unit="Pa")
        compression, extension = self.strength_compression, self.strength_extension
        if self.strength_horizontal is None:
            horizontal = (compression + extension) / math.sqrt(3.0)
            object.__setattr__(self, "strength_horizontal", horizontal)
        check_number(
            "Anisotropic: strength_horizontal", self.strength_horizontal, POSITIVE, unit="Pa"
        )
        room = 2.0 * self.strength_simple_shear
        if not abs(compression - extension) < room:
            raise SceneError(
                f"Anisotropic: strength_extension = {extension:g} Pa must be > "
                f"{max(0.0, compression - room):g} and < {compression + room:g}, as "
                "strength_simple_shear must be more than half the difference of compression and "
                "extension"
            )
        object.__setattr__(self, "strength", compression)
        super().__post_init__()

    @property
    def shape(self) -> tuple[float, ...]:
        """(c, b_x, b_y, b_w): centre, and 1 / a^2 of the semi-axes."""
        C, E, S, H = (getattr(self, name) / self.strength_compression for name in STRENGTHS)
        centre = (C - E) / math.sqrt(3.0)
        across = S * S - 0.75 * centre * centre
        return centre, 3.0 / (C + E) ** 2, 1.0 / H**2, 1.0 / across

    @property
    def limit_pressure(self) -> float:
        """Of a spherical cavity in clay of von Mises that is as strong in all directions [Pa]."""
        centre, *inverse_squares = self.shape
        greatest = abs(centre) + 1.0 / math.sqrt(min(inverse_squares))
        half_in_compression = math.sqrt(0.75) * greatest * self.strength
        return limit_pressure(self.shear_modulus, half_in_compression)

    def undrained_strength(self, test: str) -> float:
        """Where the normal of the ellipsoid is along the strain of the test."""
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
        """By the spin."""
        return turned_axis
