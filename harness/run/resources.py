"""What cases cost: predicted before they run, measured after, and what they may take here."""

import functools
import math
import os
import resource
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.conventions import Role
from harness.archive.netcdf_files import memory_of_machine
from harness.errors import HarnessError, tell
from harness.study.cases import Case
from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.execution.execution import device_names
from mpm_warp.results import variable
from mpm_warp.scenes import CatalogueScene
from mpm_warp.scenes.run_size import RunSize

LONG = 24 * 3600.0
"""Time of a case beyond which a run reports it before it begins [s]."""
PROCESS_MEMORY, SOLVER_MEMORY = 312e6, 24e6
"""What a process takes beside the run of a case: the interpreter and its libraries, Dask with 30 MB
among them, which xarray loads where it is installed; and the solvers of SciPy, where a scene needs
them [byte].

The first run of a kernel, which compiles it, takes 50 MB more for a moment.
"""
SNAPSHOT_BYTES = 150.0
"""What a material point takes in a snapshot: as it is taken, gathered and written [byte]."""
SHARE_OF_MACHINE = 0.9
"""Of the machine's memory, that cases may take where nothing is said."""
CONTAINER_LIMITS = (
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)
"""Where Linux says how much memory a container has."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How worker processes run cases."""

    device: str = "cpu"
    threads: int | None = None  # for each case; None: the cases at work share the cores
    time_limit: float = math.inf  # of a case [s], from the beginning of its computation
    repeats: int = 0  # times to run each case again to measure its run time warm
    memory_limit: float | None = None  # of a case [byte]; None: most of this machine's


DEFAULTS = RunOptions()


def usable_cores() -> int:
    """Cores that this process may use: all of the machine's, where its system sets no fewer."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class TooLarge(SceneError):
    """A case needs more memory than it may take."""


def default_memory_limit() -> float:
    """Memory that all cases at work may take where nothing is said: most of the machine's [byte].

    Of a process in a container it is the container's.
    """
    told = [file.read_text().strip() for file in CONTAINER_LIMITS if file.is_file()]
    limits = [memory_of_machine(), *(int(text) for text in told if text.isdecimal())]
    return SHARE_OF_MACHINE * min(limits)


def check_memory(scene: CatalogueScene, limit: float, snapshot_count: int = 0) -> None:
    """Refuse a scene that needs more memory than it may take, before anything is built.

    The limit is that of its process [byte]; snapshots of the soil are kept until its end.
    """
    size = scene.run_size()
    if size is not None and (needed := predicted_memory(scene, size, snapshot_count)) > limit:
        raise TooLarge(
            f"needs about {needed / 1e9:.3g} GB of memory for {size.cell_count:,} cells and "
            f"{size.particle_count:,} material points, where a case may take {limit / 1e9:.3g} GB: "
            "try fewer cells or a smaller domain, fewer --workers, or a higher --memory-limit"
        )


def predicted_memory(scene: CatalogueScene, size: RunSize, snapshot_count: int = 0) -> float:
    """Peak memory of the process of a case, at most 10 % too much [byte]."""
    in_libraries = PROCESS_MEMORY + (SOLVER_MEMORY if scene.loads_solvers else 0.0)
    in_snapshots = snapshot_count * size.particle_count * SNAPSHOT_BYTES
    return in_libraries + size.byte_count + in_snapshots


def tell_of_long_cases(cases: Sequence[Case]) -> None:
    """Say in one line which cases may take longer than `LONG`."""
    seconds = {case.label: predicted_time(case) for case in cases}
    long = {label: taken for label, taken in seconds.items() if taken > LONG}
    if long:
        longest = max(long, key=lambda label: long[label])
        tell(
            f"{len(long)} of {len(cases)} cases may take longer than {LONG / 3600:.0f} hours; "
            f"{longest}: about {long[longest] / 86400:.3g} days on one thread; --case-timeout ends "
            "such cases"
        )


def tell_of_likely_failures(cases: Sequence[Case]) -> None:
    """Say in one line which cases are likely not to complete, by the cause in the first of them."""
    reasons = {case.label: likely_failure(case) for case in cases}
    likely = {label: reason for label, reason in reasons.items() if reason}
    if likely:
        label, reason = next(iter(likely.items()))
        are = "is" if len(likely) == 1 else "are"
        tell(f"{len(likely)} of {len(cases)} cases {are} likely to fail; {label}: {reason}")


def likely_failure(case: Case) -> str:
    """Why a case is likely not to complete; "" where no cause is known, or it is refused."""
    try:
        return case.built().likely_failure
    except (ParameterError, SceneError):
        return ""


UPDATE_RATE = 20e6
"""Particle updates a second on one thread, as `harness bench` measures them."""


def predicted_time(case: Case) -> float:
    """Time of a case on one thread, about [s]; 0 where it is not known, or the case is refused."""
    try:
        size = case.built().run_size()
    except (ParameterError, SceneError):
        return 0.0
    return 0.0 if size is None else size.particle_updates / UPDATE_RATE


def spoken_time(seconds: float) -> str:
    """A time with two digits, in a unit that suits it."""
    for unit, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.0f} s" if seconds >= 10.0 else f"{seconds:.2g} s"


def costliest_first(cases: Sequence[Case]) -> list[Case]:
    """Cases in the order in which several workers are done soonest; equal ones as they were.

    A costly case that begins last keeps one worker busy when the others have nothing left. With
    the longest first, the time in all is at most 4/3 of the shortest possible (Graham 1969, SIAM
    J. Appl. Math. 17(2):416-429).
    """
    return sorted(cases, key=predicted_time, reverse=True)


def check_device(device: str) -> None:
    """Check that a device is there."""
    if device != "cpu" and device not in device_names():
        known = ", ".join(device_names())
        raise HarnessError(f"--device {device}: there is none here; known: {known}")


_RESET = Path("/proc/self/clear_refs")
_STATUS = Path("/proc/self/status")


class Measurement:
    """Measures this process from the making of the object on."""

    def __init__(self) -> None:
        self._started = time.perf_counter()
        self._reset = _reset_peak_memory()

    @property
    def seconds(self) -> float:
        """Wall-clock time since the start [s]."""
        return time.perf_counter() - self._started

    def variables(self) -> dict[str, xr.Variable]:
        """What was measured up to now, as variables of a case's dataset."""
        since = "it ran the case" if self._reset else "it was started, maybe for earlier cases"
        return {
            "case_time": case_time(self.seconds),
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
    """Let the peak count from now on; False where that cannot be, as outside of Linux."""
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
