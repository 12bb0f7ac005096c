"""A ball penetrometer pushed down until soil flows round it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mpm_warp.grid.fitted import Grid
from mpm_warp.parameters import parameter
from mpm_warp.parts.surrounding_ground import SurroundingGround, TravellingSource
from mpm_warp.scenes.full_flow.ball import Ball
from mpm_warp.scenes.full_flow.penetration import FullFlowPenetration
from mpm_warp.scenes.full_flow.round_body import RoundBody


@dataclass(frozen=True, kw_only=True)
class BallPenetration(Ball, FullFlowPenetration):
    """A ball below a smooth shaft, pushed through uniform clay to steady flow."""

    summary: ClassVar[str] = "ball penetrometer pushed through undrained clay to steady flow"
    version: ClassVar[int] = 3

    shaft_radius_ratio: float = parameter(
        0.316,
        unit="1",
        meaning="radius of the shaft over that of the ball: 10 cm2 below 100 cm2; 0: no shaft",
        minimum=0,
        maximum=0.8,
    )

    @property
    def body(self) -> RoundBody:
        """The ball and its shaft."""
        return RoundBody(
            radius=self.ball_radius, shaft_radius=self.shaft_radius_ratio * self.ball_radius
        )

    def surroundings(self, grid: Grid) -> SurroundingGround | None:
        """The ground that makes room for the shaft, seen from afar as a travelling source."""
        if self.shaft_radius_ratio == 0.0:
            return super().surroundings(grid)
        clay = self.clay
        source = TravellingSource(
            radius=self.body.shaft_radius, height=0.0, shear_modulus=clay.shear_modulus
        )
        return SurroundingGround.around(grid, clay, source)
