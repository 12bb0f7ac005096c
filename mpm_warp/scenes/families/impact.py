"""A bar or column that strikes a rigid wall: what all such scenes have in common."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import ReadyScene, Verification

if TYPE_CHECKING:
    from mpm_warp.shock import Shock

LENGTH = 1.0
"""Length before the impact [m]."""


@dataclass(frozen=True, kw_only=True)
class Impact(ReadyScene):
    """It comes to rest behind a shock, see :class:`mpm_warp.shock.Shock` for the exact solution."""

    method: ClassVar[tuple[str, ...]] = ("cell_count",)
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="cell_count", resolutions=(40, 80), bounds={"error": 0.02}, extreme=True
        ),
    )
    modulus: ClassVar[float]
    """Modulus of uniaxial strain [Pa]."""
    density: ClassVar[float]
    """Density before the impact [kg/m3]."""

    speed_ratio: float = parameter(
        0.5, unit="1", meaning="speed of the impact over that of waves", above=0, maximum=0.9
    )
    cell_count: int = parameter(
        80, unit="1", meaning="cells along the length", minimum=20, maximum=1000
    )

    @property
    def cell_size(self) -> float:
        """Side of a cell [m]."""
        return LENGTH / self.cell_count

    @property
    def wave_speed(self) -> float:
        """Speed of pressure waves before the impact [m/s]."""
        return math.sqrt(self.modulus / self.density)

    @property
    def shock(self) -> Shock:
        """The exact solution."""
        from mpm_warp.shock import Shock

        speed = self.speed_ratio * self.wave_speed
        return Shock(modulus=self.modulus, density=self.density, speed=speed)
