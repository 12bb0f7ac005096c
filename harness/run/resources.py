"""Memory and time of cases: predicted before a run, measured after it, and their limits."""

import functools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from harness.archive.conventions import Role
from harness.errors import HarnessError, tell
from harness.machine import memory_of_machine, peak_memory, reset_peak_memory
from harness.study.cases import Case
from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.execution.execution import device_names
from mpm_warp.results import variable
from mpm_warp.scenes import CatalogueScene
from mpm_warp.scenes.run_size import RunSize

LONG = 24 * 3600.0
"""A case that may take longer than this is reported before the run [s]."""
PROCESS_MEMORY, SOLVER_MEMORY = 312e6, 24e6
"""Memory of a process apart from the case [byte]: the interpreter with its libraries, and SciPy's
solvers if a scene needs them. The first includes 30 MB of Dask, which xarray loads if installed.

The first run of a kernel, which compiles it, briefly takes 50 MB more.
"""
SNAPSHOT_BYTES = 150.0
"""Memory of a material point in a snapshot while it is taken, collected and written [byte]."""
SHARE_OF_MACHINE = 0.9
"""Fraction of the machine's memory that all running cases may take by default."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How worker processes run cases."""

    device: str = "cpu"
    threads: int | None = None  # for each case; None: the running cases share the cores
    time_limit: float = math.inf  # of the computation of a case [s]
    repeats: int = 0  # timed runs of each case, after a first run that compiles
    memory_limit: float | None = None  # of a case [byte]; None: most of this machine's memory


DEFAULTS = RunOptions()


class TooLarge(SceneError):
    """A case needs more memory than it may take."""


def default_memory_limit() -> float:
    """Memory for all running cases by default: most of this machine or container [byte]."""
    return SHARE_OF_MACHINE * memory_of_machine()


def check_memory(scene: CatalogueScene, limit: float, snapshot_count: int = 0) -> None:
    """Refuse a scene whose process would need more memory than `limit` [byte].

    Snapshots are kept in memory until the end.
    """
    size = scene.run_size()
    if size is not None and (needed := predicted_memory(scene, size, snapshot_count)) > limit:
        raise TooLarge(
            f"needs about {needed / 1e9:.3g} GB of memory for {size.cell_count:,} cells and "
            f"{size.particle_count:,} material points, but a case may take {limit / 1e9:.3g} GB: "
            "try fewer cells or a smaller domain, fewer --workers, or a higher --memory-limit"
        )


def predicted_memory(scene: CatalogueScene, size: RunSize, snapshot_count: int = 0) -> float:
    """Predicted peak memory of the process of a case [byte]; it is at most 10 % too high."""
    in_libraries = PROCESS_MEMORY + (SOLVER_MEMORY if scene.loads_solvers else 0.0)
    in_snapshots = snapshot_count * size.particle_count * SNAPSHOT_BYTES
    return in_libraries + size.byte_count + in_snapshots


def tell_of_long_cases(cases: Sequence[Case]) -> None:
    """Print one line if some cases may take longer than `LONG`."""
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
    """Print one line if some cases will probably not complete, with the cause of the first one."""
    reasons = {case.label: likely_failure(case) for case in cases}
    likely = {label: reason for label, reason in reasons.items() if reason}
    if likely:
        label, reason = next(iter(likely.items()))
        are = "is" if len(likely) == 1 else "are"
        tell(f"{len(likely)} of {len(cases)} cases {are} likely to fail; {label}: {reason}")


def likely_failure(case: Case) -> str:
    """Why a case will probably not complete; "" if there is no known cause or it is refused."""
    try:
        return case.built().likely_failure
    except (ParameterError, SceneError):
        return ""


UPDATE_RATE = 20e6
"""Particle updates per second on one thread, as `harness bench` measures them."""


def predicted_time(case: Case) -> float:
    """Approximate time of a case on one thread [s]; 0 if unknown or the case is refused."""
    try:
        size = case.built().run_size()
    except (ParameterError, SceneError):
        return 0.0
    return 0.0 if size is None else size.particle_updates / UPDATE_RATE


def spoken_time(seconds: float) -> str:
    """A time with two digits, in seconds, minutes, hours or days."""
    for unit, length in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.0f} s" if seconds >= 10.0 else f"{seconds:.2g} s"


def costliest_first(cases: Sequence[Case]) -> list[Case]:
    """Cases by predicted time, the longest first; equal ones keep their order.

    A long case that begins last would keep one worker busy while the others are idle. With the
    longest first, the total time is at most 4/3 of the shortest possible (Graham 1969, SIAM
    J. Appl. Math. 17(2):416-429).
    """
    return sorted(cases, key=predicted_time, reverse=True)


def check_device(device: str) -> None:
    """Refuse a device that this machine does not have."""
    if device != "cpu" and device not in device_names():
        known = ", ".join(device_names())
        raise HarnessError(f"--device {device}: there is none here; known: {known}")


class Measurement:
    """Measures time and memory of this process from the creation of the object."""

    def __init__(self) -> None:
        self._started = time.perf_counter()
        self._reset = reset_peak_memory()

    @property
    def seconds(self) -> float:
        """Wall-clock time since the start [s]."""
        return time.perf_counter() - self._started

    def variables(self) -> dict[str, xr.Variable]:
        """The measurements so far, as variables of a case's dataset."""
        since = "it ran the case" if self._reset else "it was started, maybe for earlier cases"
        return {
            "case_time": case_time(self.seconds),
            "peak_memory": variable(
                peak_memory(),
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
    """The dataset with run times after compilation [s]: samples, minimum, median as `run_time`.

    Times of set-up and compilation stay those of `dataset`, the first run of its process.
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
