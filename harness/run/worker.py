"""What a worker process does: it runs cases one after another and writes their files."""

import contextlib
import signal
import sys
import time
import traceback
from dataclasses import dataclass
from math import nan
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import xarray as xr

from harness.archive.atomic_files import ArchiveError
from harness.archive.case_files import Outcome, is_complete, write_case
from harness.archive.conventions import (
    COMPLETED,
    FAILED,
    MISSING,
    TRACEBACK,
    UNFINISHED,
    Role,
    spoken,
    stated,
    with_role,
)
from harness.archive.netcdf_files import netcdf_image
from harness.compare.differences import differing
from harness.errors import in_one_line
from harness.run.resources import (
    DEFAULTS,
    Measurement,
    RunOptions,
    check_memory,
    default_memory_limit,
    with_samples,
)
from harness.study.cases import Case
from mpm_warp.errors import SceneError
from mpm_warp.execution.execution import Execution
from mpm_warp.provenance import provenance
from mpm_warp.results import check_results
from mpm_warp.scenes import Progress, scene_class
from mpm_warp.snapshots import Snapshots

REPORT_INTERVAL = 0.1
"""Seconds between two reports of progress."""


@dataclass(frozen=True)
class Result:
    """The result of a case, completed or not."""

    outcome: Outcome
    dataset: xr.Dataset  # what the scene returned or had computed so far; with time and provenance
    fields: xr.Dataset | None = None  # snapshots


def compute(
    case: Case,
    progress: Progress | None = None,
    execution: Execution | None = None,
    options: RunOptions = DEFAULTS,
) -> Result:
    """Run a case in this process; `progress` is called now and then with the fraction done.

    An exception of the scene becomes the outcome of the case and is not raised. Its attribute
    ``status``, if it has one, is the status of the case.
    """
    execution = execution or Execution()
    measurement = Measurement()
    status, message = COMPLETED, ""
    snapshots = Snapshots(case.snapshots) if case.snapshots else None
    try:
        dataset = _run(case, progress, execution, options, snapshots)
        if message := _missing_headline(dataset):
            status = UNFINISHED
    except Exception as error:
        dataset = _curves_of(error)
        status = getattr(error, "status", "")
        # Errors with a status have clear messages; others need the name of their type.
        message = " ".join(str(error).split()) if status else in_one_line(error)
        if not status:
            status = FAILED
            dataset = dataset.assign_attrs({TRACEBACK: traceback.format_exc()})
    headline = ""
    if status == COMPLETED:
        half_width = next(
            (dataset[name].item() for name in with_role(dataset, Role.UNCERTAINTY)), nan
        )
        reason = next((str(dataset[name].item()) for name in with_role(dataset, Role.REASON)), "")
        headline = ", ".join(
            f"{spoken(name)} {stated(dataset[name].item(), half_width, reason)}"
            for name in _headlines(dataset)
        )
    dataset = dataset.assign(measurement.variables())
    dataset = dataset.assign_attrs(provenance() | {"device": execution.device} | dataset.attrs)
    seconds = measurement.seconds
    compiling, running = (float(dataset.get(name, 0.0)) for name in ("compile_time", "run_time"))
    outcome = Outcome(
        status,
        message,
        headline,
        seconds,
        start_seconds=seconds - compiling - running if running and not options.repeats else 0.0,
        compile_seconds=compiling,
    )
    fields = None if snapshots is None else snapshots.dataset()
    return Result(outcome, dataset, fields or None)


def _curves_of(error: Exception) -> xr.Dataset:
    """What was recorded before an error; nothing if it cannot be kept."""
    curves: xr.Dataset | None = getattr(error, "curves", None)
    with contextlib.suppress(SceneError):
        if curves is not None:
            check_results(curves)
            return curves
    return xr.Dataset()


def load_libraries() -> None:
    """Load the libraries of results now, so that all cases have the same memory left."""
    nothing = xr.Dataset({"nothing": ((), 0.0)})
    netcdf_image(xr.merge([nothing, nothing]))


def run_case(
    case: Case,
    folder: Path,
    progress: Progress | None = None,
    execution: Execution | None = None,
    options: RunOptions = DEFAULTS,
) -> Outcome:
    """Run a case by :func:`compute` and write its file to the folder, completed or not.

    A result that another run has completed meanwhile is kept, because it may have snapshots.
    """
    result = compute(case, progress, execution, options)
    outcome = result.outcome
    if is_complete(folder, case, options.repeats):
        return Outcome(COMPLETED, "by another run")
    write_case(folder, case, result.dataset, outcome.status, outcome.message, result.fields)
    return outcome


def serve(connection: Connection, folder: Path, options: RunOptions) -> None:
    """Run the cases that come over `connection` until the parent closes it.

    The parent sends cases, and numbers of threads, which also apply to a running case. The worker
    sends None when it accepts a case, then the fraction done (0 when the computation begins), and
    at the end the :class:`Outcome`. The signal handlers of the process are changed.
    """
    # The terminal sends Ctrl-C to all processes, but only the parent decides what to do.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # On an exception, unlike the signal's default action, a half-written file is removed.
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    load_libraries()

    threads = 1
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            message = connection.recv()
            if isinstance(message, int):
                threads = message
                continue
            connection.send(None)
            execution = Execution(options.device, threads)
            reporter = _reporter(connection, execution)
            try:
                outcome = run_case(message, folder, reporter, execution, options)
            except ArchiveError as error:
                outcome = Outcome(MISSING, str(error))
            connection.send(outcome)
            threads = execution.threads


def _headlines(dataset: xr.Dataset) -> list[str]:
    return [name for name in with_role(dataset, Role.HEADLINE) if dataset[name].ndim == 0]


def _missing_headline(dataset: xr.Dataset) -> str:
    """Why a dataset has no complete headline: it is missing or not finite; "" if it has one."""
    names = _headlines(dataset)
    if not names:
        return "the scene gives no headline, its main result"
    for name in names:
        if not np.isfinite(dataset[name].item()):
            return (
                f"{spoken(name)} is not a finite number: the run was too short for it, or the "
                "scene has none for these parameters; try a longer run"
            )
    return ""


def _run(
    case: Case,
    progress: Progress | None,
    execution: Execution,
    options: RunOptions,
    snapshots: Snapshots | None,
) -> xr.Dataset:
    """The dataset of a run of the scene, with the times of further runs if they are asked for.

    Snapshots are taken in the first run only, which is not timed.
    """
    scene = scene_class(case.scene)
    if scene.version != case.scene_version:  # as on a cluster with another installation
        raise RuntimeError(
            f"version {case.scene_version} of {case.scene} is asked for; here is {scene.version}"
        )
    limit = options.memory_limit or default_memory_limit()
    check_memory(case.built(), limit, len(case.snapshots))
    run_count = options.repeats + 1

    def run(number: int, snapshots: Snapshots | None = None) -> xr.Dataset:
        def report(fraction: float) -> None:
            if progress is not None:
                progress((number + fraction) / run_count)

        return case.built().run(report, execution, snapshots)

    dataset = run(0, snapshots)
    samples = []
    for number in range(1, run_count):
        again = run(number)
        if names := differing(dataset, again, measures_machine=scene.runs_alone):
            raise ArithmeticError(f"run {number + 1} gave another {', '.join(names)}")
        samples.append(float(again["run_time"]))
    return with_samples(dataset, samples) if samples else dataset


def _reporter(connection: Connection, execution: Execution) -> Progress:
    """A function that sends the fraction done every `REPORT_INTERVAL`, and receives threads.

    It ends the process if the parent has ended.
    """
    next_report = 0.0

    def report(fraction: float) -> None:
        nonlocal next_report
        now = time.monotonic()
        if now < next_report:
            return
        next_report = now + REPORT_INTERVAL
        try:
            connection.send(fraction)
            while connection.poll():
                execution.threads = connection.recv()
        except (EOFError, ConnectionError):
            sys.exit()  # SystemExit is not an Exception, so it does not become an outcome

    return report
