"""An elastic block on a base: sticking, or sliding under friction and adhesion, and exact."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.scenes.base import Progress, Verification
from mpm_warp.scenes.families.block_on_base import BlockOnBase

# The simulator is imported where it is used: whoever only asks for parameters need not wait for it.
if TYPE_CHECKING:
    import xarray

    from mpm_warp.bodies.interface import InterfaceFrame
    from mpm_warp.bodies.planning import BodyPlan
    from mpm_warp.bodies.scene import BodyScene
    from mpm_warp.execution.execution import Execution

SAMPLE_COUNT = 100
"""Samples of the curves, from the moment when the driving force begins."""


@dataclass(frozen=True, kw_only=True)
class SlidingBlock(BlockOnBase):
    """A block is pressed on a base, driven along it, and its motion held against the exact one."""

    summary: ClassVar[str] = "elastic block on a base, driven until it slides; exact solution"
    version: ClassVar[int] = 4
    method: ClassVar[tuple[str, ...]] = (
        "cells_per_length",
        "particles_per_cell",
        "time_step_fraction",
        "damping_ratio",
    )
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(resolution="cells_per_length", resolutions=(10, 20), bounds={"error": 0.01}),
        Verification(
            resolution="cells_per_length",
            resolutions=(10, 20),
            bounds={"error": 0.03},
            settings={"grid_angle": 20.0, "grid_offset": 0.3, "stiffness_ratio": 1.0},
        ),
        Verification(
            resolution="cells_per_length",
            resolutions=(10, 20),
            bounds={"error": 1e-4},
            settings={"friction": 0.8},
        ),
        *(
            Verification(
                resolution="cells_per_length",
                resolutions=(6,),
                bounds={"error": 0.01},
                settings={
                    "stiffness_ratio": ratio,
                    "height_ratio": 0.5,
                    "drive": 2e4,
                    "travel": 0.01,
                },
                extreme=True,
            )
            for ratio in (1e-6, 1e6)
        ),
        *(
            Verification(
                resolution="cells_per_length",
                resolutions=(6,),
                bounds={"error": 1e-4},
                settings={
                    "friction": 0.8,
                    "height_ratio": 0.5,
                    "grid_angle": angle,
                    "rest_time": 860.0,
                },
                extreme=True,
            )
            for angle in (0.0, 20.0)
        ),
    )

    def build(self) -> BodyScene:
        """The scene: the block is body 0, the base body 1."""
        from mpm_warp.bodies.sliding_scene import sliding_scene

        return sliding_scene(self, self._frame)

    def plan(self) -> BodyPlan:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.bodies.planning import make_body_plan

        return make_body_plan(self.build())

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.bodies.history import BodyHistory
        from mpm_warp.bodies.sliding_dataset import sliding_curves, sliding_dataset
        from mpm_warp.results import cost, curves_kept
        from mpm_warp.simulation import TimeLoop

        loop = TimeLoop(self.plan(), execution)
        begin = time.perf_counter()
        loop.advance_to(self.start)
        history = BodyHistory(loop)
        along = self._frame.along
        with curves_kept(
            lambda: sliding_curves(
                history, along=along, start=self.start, sample_count=SAMPLE_COUNT
            )
        ):
            for sample in range(1, SAMPLE_COUNT + 1):
                loop.advance_to(self.start + self.duration * sample / SAMPLE_COUNT)
                history.sample()
                if progress is not None:
                    progress(sample / SAMPLE_COUNT)
            loop.check()
        run_time = time.perf_counter() - begin
        result = sliding_dataset(
            history,
            self.motion,
            along=along,
            length=self.length,
            start=self.start,
            settled_time=self.settled_time,
        )
        return result.assign(cost(loop, run_time=run_time))

    @property
    def _frame(self) -> InterfaceFrame:
        from mpm_warp.bodies.interface import InterfaceFrame

        return InterfaceFrame(
            angle=math.radians(self.grid_angle), interface_radius=self.interface_radius
        )
