"""What a case costs: its time in all, the memory at its peak, and its run time over again.

These numbers differ between two runs of a case; all others are the same to the last bit.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.provenance import OF_CASE

MEASURED = frozenset(
    {
        "run_time",
        "run_time_minimum",
        "run_time_sample",
        "setup_time",
        "compile_time",
        "case_time",
        "peak_memory",
        "update_rate",
        "update_rate_lowest",
        "update_rate_highest",
        "thread_gain",
        "core_gain",
        "bare_step_gain",
        "overhead_share",
        "stage_time",
        "stage_bytes",
        "stage_operations",
        "stage_divisions",
        "streaming_rate",
        "arithmetic_rate",
        "division_rate",
    }
)
"""Variables of a result that are measurements of the run itself."""

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
        """What was measured up to now, as variables of a case's dataset; see :meth:`seconds`."""
        since = "it ran the case" if self._reset else "it was started, maybe for earlier cases"
        return {
            "case_time": case_time(self.seconds(idle_time)),
            "peak_memory": xr.Variable(
                (),
                _peak_memory(self._reset),
                {
                    "units": "byte",
                    "long_name": "peak resident memory",
                    "description": f"highest resident memory of the process since {since}",
                },
            ),
        }


def case_time(seconds: float) -> xr.Variable:
    """The time of a whole case [s] as a variable of its dataset."""
    return xr.Variable((), seconds, {"units": "s", "long_name": "wall-clock time of the case"})


def without_idle_time(dataset: xr.Dataset, idle_time: float) -> xr.Dataset:
    """The dataset with a run time that leaves out for how long [s] other cases were computed."""
    if idle_time == 0.0 or "run_time" not in dataset:
        return dataset
    run_time = dataset["run_time"]
    return dataset.assign(run_time=run_time.copy(data=run_time.values - idle_time))


def with_samples(dataset: xr.Dataset, samples: Sequence[float]) -> xr.Dataset:
    """The dataset with warm run times [s]: all of them, their median as `run_time`, their minimum.

    Set-up and compilation stay those of the run that is in `dataset`, the first of its process.
    """
    labels = {"units": "s", "long_name": "wall-clock time of the time loop"}
    repeat = np.arange(1, len(samples) + 1)
    return dataset.assign(
        run_time=((), np.median(samples), labels | {"description": "median of `run_time_sample`"}),
        run_time_minimum=((), min(samples), labels | {"long_name": "least time of the time loop"}),
        run_time_sample=("repeat", np.array(samples), labels | {"description": "kernels warm"}),
    ).assign_coords(repeat=("repeat", repeat, {"units": "1", "long_name": "timed run"}))


def differing(one: xr.Dataset, other: xr.Dataset) -> list[str]:
    """Names of variables that are not the same to the last bit.

    Left aside are measurements, and what tells where and when a case was computed.
    """
    names = sorted(
        {str(name) for name in (*one.variables, *other.variables)} - MEASURED - {*OF_CASE}
    )
    return [
        name
        for name in names
        if name != "repeat"
        and not (name in one.variables and name in other.variables and _same(one, other, name))
    ]


def _same(one: xr.Dataset, other: xr.Dataset, name: str) -> bool:
    # `identical` would take 0 for -0.
    first, second = one[name].variable, other[name].variable
    same_kind = (first.dims, first.shape, first.dtype) == (second.dims, second.shape, second.dtype)
    return same_kind and (
        first.values.tobytes() == second.values.tobytes()
        if first.dtype.kind != "O"
        else first.values.tolist() == second.values.tolist()
    )


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
