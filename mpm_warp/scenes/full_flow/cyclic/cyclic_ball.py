"""A ball pushed down and pulled up, time after time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mpm_warp.scenes.full_flow.ball import Ball
from mpm_warp.scenes.full_flow.cyclic.cyclic_penetration import CyclicPenetration


@dataclass(frozen=True, kw_only=True)
class CyclicBall(Ball, CyclicPenetration):
    """A ball that goes down and up again in the same soil.

    Its shaft is left out: it would move the ground around the window, which rests between two
    passages. The first passage is that of `ball_penetration` without a shaft.
    """

    summary: ClassVar[str] = "ball without a shaft, pushed down and pulled up in undrained clay"
    version: ClassVar[int] = 1
