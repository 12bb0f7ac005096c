"""A ball, however it is moved."""

from __future__ import annotations

from dataclasses import dataclass

from mpm_warp.parameters import parameter
from mpm_warp.scenes.full_flow.penetrometer import FullFlowPenetrometer
from mpm_warp.scenes.full_flow.round_body import RoundBody


@dataclass(frozen=True, kw_only=True)
class Ball(FullFlowPenetrometer):
    """A ball without a shaft."""

    ball_radius: float = parameter(
        0.0565, unit="m", meaning="radius of the ball", minimum=1e-6, maximum=1e3
    )

    @property
    def body(self) -> RoundBody:
        """The ball."""
        return RoundBody(radius=self.ball_radius)
