"""A T-bar in plane strain, however it is moved."""

from __future__ import annotations

from dataclasses import dataclass

from mpm_warp.parameters import parameter
from mpm_warp.scenes.full_flow.penetrometer import FullFlowPenetrometer
from mpm_warp.scenes.full_flow.round_body import RoundBody


@dataclass(frozen=True, kw_only=True)
class TBar(FullFlowPenetrometer):
    """A bar that moves across its axis, in plane strain."""

    bar_radius: float = parameter(
        0.02, unit="m", meaning="radius of the T-bar", minimum=1e-6, maximum=1e3
    )

    @property
    def body(self) -> RoundBody:
        """The T-bar."""
        return RoundBody(radius=self.bar_radius, planar=True)
