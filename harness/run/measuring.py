"""What a case costs: its time in all, the memory at its peak, and its run time over again."""

import resource
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.conventions import Role

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
            "peak_memory": xr.Variable(
                (),
                _peak_memory(self._reset),
                {
                    "units": "byte",
                    "long_name": "peak resident memory",
                    "role": Role.MEASURED,
                    "description": f"highest resident memory of the process since {since}",
                },
            ),
        }


def case_time(seconds: float) -> xr.Variable:
    """The time of a whole case [s] as a variable of its dataset."""
    labels = {"units": "s", "long_name": "wall-clock time of the case", "role": Role.MEASURED}
    return xr.Variable((), seconds, labels)


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
    labels = {"units": "s", "long_name": "wall-clock time of the time loop", "role": Role.MEASURED}
    repeat = {"units": "1", "long_name": "timed run", "role": Role.MEASURED}
    times = np.array(samples)
    return dataset.assign(
        {
            "run_time": ((), np.median(times), labels | {"description": "median of the samples"}),
            "run_time_minimum": (
                (),
                times.min(),
                labels | {"long_name": "least time of the time loop"},
            ),
            "run_time_sample": ("repeat", times, labels | {"description": "kernels warm"}),
        }
    ).assign_coords({"repeat": ("repeat", np.arange(1, times.size + 1), repeat)})


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
