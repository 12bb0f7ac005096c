"""What a case costs: its time in all, the memory at its peak, and its run time over again."""

import functools
import resource
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.conventions import Role
from mpm_warp.results import variable

_RESET = Path("/proc/self/clear_refs")
_STATUS = Path("/proc/self/status")


class Measurement:
    """Measures this process from the making of the object on."""

    def __init__(self) -> None:
        self._started = time.perf_counter()
        self._reset = _reset_peak_memory()

    def seconds(self, idle_time: float = 0.0) -> float:
        """Wall-clock time since the start [s], without that for which the case stood still."""
        return time.perf_counter() - self._started - idle_time

    def variables(self, idle_time: float = 0.0) -> dict[str, xr.Variable]:
        """What was measured up to now, as variables of a case's dataset.

        The time for which the case stood still [s] is left out.
        """
        since = "it ran the case" if self._reset else "it was started, maybe for earlier cases"
        return {
            "case_time": case_time(self.seconds(idle_time)),
            "peak_memory": variable(
                _peak_memory(self._reset),
                unit="byte",
                meaning="peak resident memory",
                role=Role.MEASURED,
                description=f"highest resident memory of the process since {since}",
            ),
        }


def case_time(seconds: float) -> xr.Variable:
    """The time of a whole case [s] as a variable of its dataset."""
    meaning = "wall-clock time of the case"
    return variable(seconds, unit="s", meaning=meaning, role=Role.MEASURED)


def without_idle_time(dataset: xr.Dataset, idle_time: float) -> xr.Dataset:
    """The dataset with a run time that leaves out for how long [s] other cases were computed."""
    if idle_time == 0.0 or "run_time" not in dataset:
        return dataset
    run_time = dataset["run_time"]
    return dataset.assign({"run_time": run_time.copy(data=run_time.values - idle_time)})


def with_samples(dataset: xr.Dataset, samples: Sequence[float]) -> xr.Dataset:
    """The dataset with warm run times [s]: all of them, their median as `run_time`, their minimum.

    Set-up and compilation stay those of the run that is in `dataset`, the first of its process.
    """
    loop, least = "wall-clock time of the time loop", "least time of the time loop"
    times = np.array(samples)
    seconds = functools.partial(variable, unit="s", role=Role.MEASURED)
    number = variable(
        np.arange(1, times.size + 1), meaning="timed run", dims=("repeat",), role=Role.MEASURED
    )
    return dataset.assign(
        run_time=seconds(np.median(times), meaning=loop, description="median of the samples"),
        run_time_minimum=seconds(times.min(), meaning=least),
        run_time_sample=seconds(times, meaning=loop, dims=("repeat",), description="kernels warm"),
    ).assign_coords(repeat=number)


def _reset_peak_memory() -> bool:
    """Have the kernel count the peak from now on; False where it cannot, as outside of Linux."""
    try:
        _RESET.write_text("5")
    except OSError:
        return False
    return True


def _peak_memory(reset: bool) -> int:
    """Peak resident memory [byte], since the reset if there was one."""
    if reset:
        lines = _STATUS.read_text().splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM:"))
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
