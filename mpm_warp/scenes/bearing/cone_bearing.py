"""Bearing capacity of a cone whose shoulder is level with the surface of the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.grid.spacing import graded
from mpm_warp.parameters import redefined
from mpm_warp.scene import Scene
from mpm_warp.scenes.bearing.common import NO_PARTING, RADIUS, STRENGTH
from mpm_warp.scenes.bearing.on_ground import OnGround
from mpm_warp.scenes.bearing.slip_lines import SlipLines
from mpm_warp.scenes.catalogue import Verification
from mpm_warp.scenes.cone.parameters import ConeTest
from mpm_warp.scenes.cone.penetrometer import Penetrometer, PenetrometerContact

EXACT = {0.0: 4.443, 0.25: 5.089, 0.5: 5.679, 0.75: 6.218, 1.0: 6.690}
"""Load over (base area times su) by adhesion factor, for an apex angle of 60 degrees."""


@dataclass(frozen=True, kw_only=True)
class ConeBearing(OnGround):
    """A cone that is pressed on from where its shoulder is at the surface.

    In uniform soil the exact load is known for 60 degrees and the adhesion factors of `EXACT`.
    """

    summary: ClassVar[str] = "limit load of a cone with its shoulder at the surface"
    version: ClassVar[int] = 3
    uniform_exact_source: ClassVar[str] = (
        "slip lines with the hypothesis of Haar and von Karman, integrated for this project; the "
        "same integration gives 5.689 and 6.049 for the smooth and the rough disc"
    )
    verifications: ClassVar[tuple[Verification, ...]] = tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=(4, 8, 16),
            bounds={"error": 0.02},
            least_order=1.0,
            settings={"adhesion_factor": adhesion_factor},
        )
        for adhesion_factor in EXACT
    )

    adhesion_factor: float = redefined(
        ConeTest, "adhesion_factor", meaning="adhesion factor of the cone"
    )
    apex_angle: float = redefined(ConeTest, "apex_angle")

    @property
    def uniform_exact_load(self) -> float:
        """Exact limit load over area and su; not a number where none is known."""
        return EXACT.get(self.adhesion_factor, math.nan) if self.apex_angle == 60.0 else math.nan

    @property
    def slip_lines(self) -> SlipLines | None:
        """Those of the cone, unless it is so blunt and rough that soil is stuck below it."""
        lines = SlipLines(
            half_angle=math.radians(0.5 * self.apex_angle),
            adhesion_factor=self.adhesion_factor,
            strength_gradient_ratio=self.strength_gradient_ratio,
        )
        return lines if lines.face_psi >= 0.0 else None

    @property
    def surface_height(self) -> float:
        """Height of the shoulder above the tip, which is at z = 0 [m]."""
        return self._penetrometer.cone_height

    def grid(self) -> Grid:
        """A grid fitted to the cone, that ends at its shoulder."""
        size = RADIUS / self.cells_per_radius
        return self._penetrometer.fitted_grid(
            rows_on_face=self._penetrometer.rows_on_face(size),
            columns=graded(size, 4.0 * RADIUS, 1.0 + 0.3 * size / RADIUS),
            depth_below=2.0 * RADIUS,
            height_above=0.0,
        )

    def contact(self, grid: Grid) -> PenetrometerContact:
        """Contact on the face of the cone."""
        return PenetrometerContact.of(
            self._penetrometer,
            grid,
            face_adhesion=self.adhesion_factor * STRENGTH,
            in_situ_stress=NO_PARTING,
            speed=self.speed,
        )

    def load(self, scene: Scene, nodal: Floats) -> float:
        """The upward force on the face, over base area and su0."""
        forces = scene[PenetrometerContact].forces(nodal)
        return (forces.face_normal + forces.face_shear) / (0.5 * RADIUS**2 * STRENGTH)

    @property
    def _penetrometer(self) -> Penetrometer:
        return Penetrometer(radius=RADIUS, apex_angle=math.radians(self.apex_angle))
