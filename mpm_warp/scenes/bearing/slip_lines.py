"""Exact limit load of a cone or disc at the surface of clay whose strength grows with depth.

The method of slip lines is used in plane strain, and in axisymmetry with the hypothesis of Haar and
von Karman: the hoop stress equals the least principal stress. Lengths are over the radius R of the
body, stresses over the strength su0 at the surface. Compression is positive; z is the depth.

Symbols: strength c = 1 + kappa z, kappa = k R / su0, s mean of the greatest and the least principal
stress, psi angle of the greatest from the vertical. Along the two families of slip lines, e = 1 and
e = -1 (Sokolovskii 1965, Statics of Granular Media; with the last term if c grows with depth),

    dr/dz = tan(psi + e pi/4)
    ds + 2 e c dpsi + (c / r) (dr - e dz) + e kappa dr = 0        without c / r in plane strain

The field begins at the free surface beside the rim, where s = 1 and psi = pi/2, turns in a fan at
the rim, and ends on the face, where the adhesion gives psi. Its outermost line ends on the axis.
"""

import itertools
import math
from dataclasses import dataclass
from typing import NamedTuple

FREE_SURFACE = 0.5 * math.pi
"""Angle psi at the free surface, where the greatest stress is horizontal."""
INNER_RADIUS = 0.01
"""Inner radius of the field; at the axis 1 / r is infinite. The rest of the face, a ten-thousandth
of its area, has the traction found there."""
ITERATION_CHANGE = 1e-11
"""Change of a point of the net that ends its iteration."""
MOST_ITERATIONS = 60
BISECTIONS = 20
"""Bisections between two lines to find the one that ends beside the axis."""


class Point(NamedTuple):
    """A point of the net of slip lines."""

    r: float
    z: float
    s: float
    psi: float


@dataclass(frozen=True, kw_only=True)
class SlipLines:
    """The net of slip lines below a smooth footing, or a cone with its shoulder at the surface."""

    half_angle: float  # between axis and face [rad], pi/2 for a disc or a strip
    adhesion_factor: float = 0.0  # adhesion over the adjacent strength, 0 to 1; 0 for a footing
    strength_gradient_ratio: float = 0.0  # kappa = k R / su0, >= 0
    planar: bool = False  # True: a wedge or a strip of width 2 R in plane strain
    spacing: float = 0.03  # of lines at the surface, over R; the error falls with its square

    @property
    def limit_load(self) -> float:
        """Limit load over area and su0; the vertical part of the adhesion is included."""
        face = self._face_points
        load = 0.0
        for outer, next_in in itertools.pairwise(face):
            width = outer.r - next_in.r
            t_outer, t_in = self._upward_traction(outer), self._upward_traction(next_in)
            if self.planar:
                load += 0.5 * (t_in + t_outer) * width
            else:  # the integral of t 2 r dr, t linear in r
                load += width * (t_in * (2.0 * next_in.r + outer.r)) / 3.0
                load += width * (t_outer * (next_in.r + 2.0 * outer.r)) / 3.0
        last = face[-1]
        return load + self._upward_traction(last) * (last.r if self.planar else last.r**2)

    @property
    def _face_points(self) -> list[Point]:
        """Ends of the lines e = 1 on the face, from the rim to the axis."""
        turn = FREE_SURFACE - self.face_psi
        count = max(1, math.ceil(turn / self.spacing))
        fan = [FREE_SURFACE - turn * number / count for number in range(count + 1)]
        # In the fan at the rim c = 1; only s and psi change.
        line = [Point(1.0, 0.0, 1.0 + 2.0 * (FREE_SURFACE - psi), psi) for psi in fan]
        face = [line[-1]]
        start = 1.0
        while True:
            following = self._next_line(line, start + self.spacing)
            if not self._ends_inside(following, face[-1]):
                break
            start, line = start + self.spacing, following
            face.append(line[-1])
        # The outermost line is the one that ends beside the axis.
        inside, outside = start, start + self.spacing
        for _ in range(BISECTIONS):
            middle = 0.5 * (inside + outside)
            ends_inside = self._ends_inside(self._next_line(line, middle), face[-1])
            inside, outside = (middle, outside) if ends_inside else (inside, middle)
        return [*face, self._next_line(line, inside)[-1]]

    def _ends_inside(self, line: list[Point], outer: Point) -> bool:
        """Whether a line ends on the face between the inner radius and a point."""
        return INNER_RADIUS < line[-1].r < outer.r

    def _next_line(self, line: list[Point], start: float) -> list[Point]:
        """The line e = 1 from radius `start` at the surface to the face; `line` is inside it."""
        first = Point(start, 0.0, 1.0, FREE_SURFACE)
        points = list(itertools.accumulate(line, self._crossing, initial=first))
        return [*points, self._end_on_face(points[-1])]

    def _crossing(self, a: Point, b: Point) -> Point:
        """Intersection of the line e = 1 through a with the line e = -1 through b."""
        found = Point(b.r, b.z, b.s, 0.5 * (a.psi + b.psi))
        for _ in range(MOST_ITERATIONS):
            # A chord has the direction and the coefficients of its midpoint.
            one = 0.5 * (a.psi + found.psi) + 0.25 * math.pi
            other = 0.5 * (b.psi + found.psi) - 0.25 * math.pi
            along = (b.r - a.r) * math.cos(other) - (b.z - a.z) * math.sin(other)
            along /= math.sin(one - other)
            r, z = a.r + along * math.sin(one), a.z + along * math.cos(one)
            (c_a, of_a), (c_b, of_b) = self._terms(a, r, z, 1.0), self._terms(b, r, z, -1.0)
            psi = (a.s - b.s + 2.0 * (c_a * a.psi + c_b * b.psi) - of_a + of_b) / (c_a + c_b) / 2.0
            change = abs(psi - found.psi) + abs(r - found.r)
            found = Point(r, z, a.s - 2.0 * c_a * (psi - a.psi) - of_a, psi)
            if change < ITERATION_CHANGE:
                break
        return found

    def _end_on_face(self, a: Point) -> Point:
        """End of the line e = 1 through a point on the face, z = (1 - r) cot(half angle)."""
        slope, psi = self._slope, self.face_psi
        direction = 0.5 * (a.psi + psi) + 0.25 * math.pi
        along = (1.0 - a.r) * slope - a.z
        along /= math.cos(direction) + slope * math.sin(direction)
        r, z = a.r + along * math.sin(direction), a.z + along * math.cos(direction)
        c, change = self._terms(a, r, z, 1.0)
        return Point(r, z, a.s - 2.0 * c * (psi - a.psi) - change, psi)

    @property
    def _slope(self) -> float:
        """Depth of the face over the radial distance from the rim."""
        return 1.0 / math.tan(self.half_angle)

    @property
    def face_psi(self) -> float:
        """Angle psi at which the shear stress on the face equals the adhesion."""
        return 0.5 * math.pi - self.half_angle - 0.5 * math.asin(self.adhesion_factor)

    def _terms(self, a: Point, r: float, z: float, e: float) -> tuple[float, float]:
        """(c, (c / r) (dr - e dz) + e kappa dr) from a point to (r, z) along a line."""
        kappa, dr, dz = self.strength_gradient_ratio, r - a.r, z - a.z
        c = 1.0 + kappa * 0.5 * (a.z + z)
        hoop = 0.0 if self.planar else c / max(0.5 * (a.r + r), 0.5 * INNER_RADIUS)
        return c, hoop * (dr - e * dz) + e * kappa * dr

    def _upward_traction(self, point: Point) -> float:
        """Upward force on the face over its horizontal projection."""
        c = 1.0 + self.strength_gradient_ratio * point.z
        normal = point.s + c * math.cos(math.asin(self.adhesion_factor))
        return normal + self.adhesion_factor * c * self._slope
