"""The ground far from a body that goes down through it: elastic, and moved by a travelling source.

The body makes room for itself: it puts the volume pi R^2 into the ground for each unit of its way,
R being the radius of the shaft behind it. From afar that is a point source. With x = (r, z) seen
from the source, z upward, d = |x|, and V the speed of the body, incompressible elastic ground has

    v = V R^2 / 4 x / d^3                                          velocity

which is harmonic, so that the mean stress stays. On the source's way from infinitely far below the
ground has got the stress 2 G grad v integrated over time, for (rr, zz, rz, tt)

    2 G R^2 / 4 (-(q + z / d^3), z / d^3, r / d^3, q)              stress
    q = 1 / (d (d - z)) = (1 + z / d) / r^2
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mpm_warp.arguments import POSITIVE, check_number
from mpm_warp.grid.fitted import Floats


@dataclass(frozen=True, kw_only=True)
class TravellingSource:
    """The motion and the stress that a body going down leaves in elastic ground far from it.

    Positions are those in a grid that travels with the body.

    Attributes:
        radius: of the shaft behind the body [m], > 0.
        height: of the source in the grid [m].
        shear_modulus: of the ground [Pa], > 0.

    Raises:
        SceneError: a value is not allowed.
    """

    radius: float
    height: float
    shear_modulus: float

    def __post_init__(self) -> None:
        check_number("source: radius", self.radius, POSITIVE, unit="m")
        check_number("source: height", self.height, unit="m")
        check_number("source: shear_modulus", self.shear_modulus, POSITIVE, unit="Pa")

    def velocity(self, position: Floats) -> Floats:
        """Velocity of the ground over that of the body, dimensionless, shape [..., 2].

        Args:
            position: (r, z) in the grid [m], not that of the source itself, shape [..., 2].
        """
        x, distance = self._seen_from_source(position)
        flow: Floats = 0.25 * self.radius**2 * x / distance[..., None] ** 3
        return flow

    def stress_since(self, position: Floats, travel: float) -> Floats:
        """Stress (rr, zz, rz, tt) that soil has got while the body went so far [Pa], [..., 4].

        Args:
            position: (r, z) in the grid where the soil is now [m], shape [..., 2]; off the axis
                above the source.
            travel: of the body [m], >= 0.
        """
        at_first = position - np.array([0.0, travel])
        return self._stress(position) - self._stress(at_first)

    def traction_rate(self, position: Floats) -> Floats:
        """Growth of (stress rr, stress rz) of soil per way of the body [Pa/m], shape [..., 2].

        Args:
            position: (r, z) in the grid [m], shape [..., 2].
        """
        x, distance = self._seen_from_source(position)
        r, z = x[..., 0], x[..., 1]
        gradients = [distance**-3 - 3.0 * r**2 / distance**5, -3.0 * r * z / distance**5]
        rate: Floats = self._scale * np.stack(gradients, axis=-1)
        return rate

    @property
    def _scale(self) -> float:
        """2 G R^2 / 4 [N]."""
        return 0.5 * self.shear_modulus * self.radius**2

    def _seen_from_source(self, position: Floats) -> tuple[Floats, Floats]:
        x = position - np.array([0.0, self.height])
        return x, np.linalg.norm(x, axis=-1)

    def _stress(self, position: Floats) -> Floats:
        x, distance = self._seen_from_source(position)
        r, z = x[..., 0], x[..., 1]
        # Each form of q has no cancellation on its side of the source.
        below = z < 0.0
        q = np.empty_like(z)
        q[below] = 1.0 / (distance[below] * (distance[below] - z[below]))
        q[~below] = (1.0 + z[~below] / distance[~below]) / r[~below] ** 2
        lift = z / distance**3
        stress: Floats = self._scale * np.stack([-(q + lift), lift, r / distance**3, q], axis=-1)
        return stress
