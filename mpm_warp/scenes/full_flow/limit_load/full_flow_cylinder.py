"""A cylinder (T-bar) that soil flows around on all sides, in plane strain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from mpm_warp.scenes.catalogue import Verification
from mpm_warp.scenes.full_flow.limit_load.common import FullFlow

LIMIT_LOAD_SOURCE = (
    "lower bound of Randolph & Houlsby 1984, Geotechnique 34(4):613-623, exact for a rough "
    "cylinder; upper bounds for others are at most 0.65 % higher (Martin & Randolph 2006, "
    "Geotechnique 56(2):141-145)"
)


def limit_load(adhesion_factor: float) -> float:
    """Exact limit load of a cylinder in full flow over diameter and su; see `LIMIT_LOAD_SOURCE`."""
    delta = math.asin(adhesion_factor)
    fans = math.cos(0.5 * delta) + math.sin(0.5 * delta)
    return math.pi + 2.0 * delta + 2.0 * math.cos(delta) + 4.0 * fans


@dataclass(frozen=True, kw_only=True)
class FullFlowCylinder(FullFlow):
    """Half a cylinder on rays, in plane strain.

    Force over (diameter times su), with D = asin(adhesion factor):
    pi + 2 D + 2 cos D + 4 (cos(D/2) + sin(D/2)); the attribute `exact_source` says where from.
    """

    summary: ClassVar[str] = "force on a cylinder that soil flows around (T-bar), plane strain"
    version: ClassVar[int] = 3
    planar: ClassVar[bool] = True
    verifications: ClassVar[tuple[Verification, ...]] = tuple(
        Verification(
            resolution="cells_per_radius",
            resolutions=(4, 8),
            bounds={"error": 0.01},
            settings={"adhesion_factor": adhesion_factor},
        )
        for adhesion_factor in (0.0, 0.25, 0.5, 0.75, 1.0)
    )

    @property
    def exact_load(self) -> float:
        """Exact limit load over diameter and su."""
        return limit_load(self.adhesion_factor)

    @property
    def exact_source(self) -> str:
        """Where the exact load comes from, and how exact it is."""
        return LIMIT_LOAD_SOURCE
