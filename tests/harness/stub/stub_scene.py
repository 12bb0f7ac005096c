"""A scene of another package, offered by an entry point, that takes its time and computes nothing.

Worker processes, interruption, limits and clusters are tested with it.
"""

import os
import signal
import time
from dataclasses import dataclass

import xarray as xr

from mpm_warp import CatalogueScene, RunSize, Simulation, SimulationDiverged, labelled, parameter
from mpm_warp.execution.execution import Execution
from mpm_warp.scenes import Progress


@dataclass(frozen=True, kw_only=True)
class Stub(CatalogueScene):
    """Sleeps, and then gives twice a number, or ends in another way."""

    summary = "sleeps, and gives twice a number"
    version = 2

    number: float = parameter(1.0, "half of the answer", maximum=100)
    seconds: float = parameter(0.0, "time of a run", unit="s", minimum=0)
    interval: float = parameter(0.05, "time between two reports", unit="s", above=0)
    points: int = parameter(1, "material points that it says it has", minimum=1)
    end: str = parameter("well", "how a run ends", choices=("well", "diverged", "killed"))

    def build(self) -> None:
        """Nothing is simulated."""

    def run_size(self) -> RunSize:
        """Of as many points as are given, and steps in proportion to the time."""
        return RunSize(cell_count=0, particle_count=self.points, step_count=1 + self.seconds)

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Never called."""
        raise NotImplementedError

    def compute(self, progress: Progress, execution: Execution | None) -> xr.Dataset:
        """Sleep, and end."""
        start = time.monotonic()
        progress(0.0)
        while (passed := time.monotonic() - start) < self.seconds:
            progress(passed / self.seconds)
            time.sleep(min(self.interval, self.seconds - passed))
        if self.end == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.end == "diverged":
            raise SimulationDiverged("at once")
        run_time = (time.monotonic() - start + 1e-9, "s", "wall-clock time of the run")
        return xr.Dataset(
            labelled(role="headline", answer=(2.0 * self.number, "1", "answer"))
            | labelled(role="measured", run_time=run_time)
        )
