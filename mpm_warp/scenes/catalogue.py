"""Stand-in until the merge: a scene that is built, and recorded by samplers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import xarray as xr

from mpm_warp.execution.execution import Execution
from mpm_warp.parameters import Value
from mpm_warp.plan.plan import StepPlan
from mpm_warp.planning import make_plan
from mpm_warp.scene import Scene
from mpm_warp.scenes.base import Progress as Progress
from mpm_warp.scenes.base import ReadyScene
from mpm_warp.scenes.base import Verification as Verification
from mpm_warp.simulation import Simulation


@dataclass(frozen=True, kw_only=True)
class CatalogueScene(ReadyScene):
    """Stand-in until the merge."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in self.derived().items():
            if getattr(self, name) is None:
                object.__setattr__(self, name, value)

    def derived(self) -> Mapping[str, Value]:
        """Values of parameters that are left None."""
        return {}

    @abstractmethod
    def build(self) -> Any:
        """What is simulated."""

    @abstractmethod
    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Run the simulation."""

    def simulated_scene(self) -> Any:
        """What is simulated, where it is soil."""
        scene = self.build()
        return scene if isinstance(scene, Scene) else None

    def plan(self) -> StepPlan:
        """What a run consists of."""
        return make_plan(self.build())

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xr.Dataset:
        """Simulate the scene."""
        return self.record(Simulation(self.build(), execution), progress or (lambda _: None))
