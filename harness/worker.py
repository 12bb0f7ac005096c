"""What a worker process does: it runs one case after the other, and keeps each result itself."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from dataclasses import dataclass
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from harness import in_one_line
from harness.cases import COMPLETED, MISSING, Case, Outcome
from mpm_warp.parameters import from_mapping
from mpm_warp.scenes import Progress, scene_class

if TYPE_CHECKING:
    import xarray as xr

    from mpm_warp.execution.execution import Execution

REPORT_INTERVAL = 0.1
"""Seconds between two reports of progress."""
SINGLE_THREADED = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@dataclass(frozen=True)
class Result:
    """What became of a case.

    Attributes:
        outcome: how it ended.
        dataset: what the scene returned, if it completed; what it cost and where it was computed.
    """

    outcome: Outcome
    dataset: xr.Dataset


def compute(
    case: Case,
    progress: Progress | None = None,
    execution: Execution | None = None,
    repeats: int = 0,
) -> Result:
    """Run a case in this process.

    An exception that the scene raises is the outcome of the case, by its attribute ``status``
    where it has one; it is not raised again.

    Args:
        case: the case.
        progress: is told the fraction done now and then.
        execution: where it is computed, and on how many threads; default: one of the processor.
        repeats: times to run it again to measure its run time warm.
    """
    import xarray as xr

    from harness.measuring import Measurement, without_idle_time
    from harness.provenance import provenance
    from mpm_warp.execution.execution import Execution

    execution = execution or Execution()
    measurement = Measurement()
    status, message = COMPLETED, ""
    try:
        dataset = _run(case, progress, execution, repeats)
    except Exception as error:
        history = getattr(error, "history", None)
        dataset = xr.Dataset() if history is None else history
        status = getattr(error, "status", "failed")
        message = in_one_line(error)
    scalars = ((name, array) for name, array in dataset.data_vars.items() if array.ndim == 0)
    headline = next(
        (f"{str(name).replace('_', ' ')} {array.item():.4g}" for name, array in scalars), ""
    )
    idle_time = execution.idle_time
    dataset = without_idle_time(dataset, idle_time)
    dataset = dataset.assign(measurement.variables(idle_time)).assign_attrs(
        provenance(), device=execution.device, cases_together=execution.case_count
    )
    return Result(Outcome(status, message, headline, measurement.seconds(idle_time)), dataset)


def run_case(
    case: Case,
    folder: Path,
    progress: Progress | None = None,
    execution: Execution | None = None,
    repeats: int = 0,
) -> Outcome:
    """Run a case in this process and write its file, whatever becomes of it; see :func:`compute`.

    Raises:
        harness.whole_files.ArchiveError: the result cannot be written.
    """
    from harness.case_files import write_case

    result = compute(case, progress, execution, repeats)
    write_case(folder, case, result.dataset, result.outcome.status, result.outcome.message)
    return result.outcome


def serve(connection: Connection, folder: Path, device: str, repeats: int) -> None:
    """Run the cases that come over `connection`, until the other end is gone.

    A tuple of cases is run together. A number that comes instead, before cases or during them, is
    that of the threads to use from then on. Sent back are pairs of the number of a case in its
    tuple and a fraction done, 0 as the cases begin, or in the end an :class:`Outcome`. To be called
    first thing in a fresh process, which it makes its own: signals, threads of libraries.
    """
    # Ctrl-C goes to the whole process group, but it is the parent that decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # An exception, unlike the signal's default action, removes a half-written file.
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    os.environ.update(dict.fromkeys(SINGLE_THREADED, "1"))
    start_warp_in_silence()
    from harness.whole_files import ArchiveError
    from mpm_warp.execution.batch import Batch
    from mpm_warp.execution.execution import Execution

    def run(number: int, case: Case, execution: Execution) -> None:
        reporter = _Reporter(connection, number, execution)
        try:
            outcome = run_case(case, folder, reporter, execution, repeats)
        except ArchiveError as error:
            outcome = Outcome(MISSING, str(error))
        connection.send((number, outcome))

    threads = 1
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            message = connection.recv()
            if isinstance(message, int):
                threads = message
                continue
            connection.send((0, 0.0))
            if len(message) == 1:
                execution = Execution(device, threads)
                run(0, message[0], execution)
            else:
                execution = batch = Batch(device, threads)
                batch.run([partial(run, *it, batch) for it in enumerate(message)])
            threads = execution.threads


def start_warp_in_silence() -> None:
    """Keep Warp's greeting, and its remark where there is no GPU, out of the progress display."""
    import warp

    warp.config.log_level = warp.LOG_WARNING
    kept = os.dup(2)
    with Path(os.devnull).open("w") as nowhere:
        os.dup2(nowhere.fileno(), 2)  # the remark does not come from Python
        warp.init()
        os.dup2(kept, 2)
    os.close(kept)


def _run(case: Case, progress: Progress | None, execution: Execution, repeats: int) -> xr.Dataset:
    """The dataset of the scene, with the run times of `repeats` more runs."""
    from harness.measuring import differing, with_samples

    scene = scene_class(case.scene)
    if scene.version != case.scene_version:  # as on a cluster with another installation
        raise RuntimeError(
            f"version {case.scene_version} of {case.scene} is asked for; here is {scene.version}"
        )
    run_count = repeats + 1

    def run(number: int) -> xr.Dataset:
        def report(fraction: float) -> None:
            if progress is not None:
                progress((number + fraction) / run_count)

        return from_mapping(scene, case.parameters).run(report, execution)

    dataset = run(0)
    samples = []
    for number in range(1, run_count):
        again = run(number)
        if names := differing(dataset, again):
            raise ArithmeticError(f"run {number + 1} gave another {', '.join(names)}")
        samples.append(float(again.run_time))
    return with_samples(dataset, samples) if samples else dataset


class _Reporter:
    """Sends fractions done, now and then, and takes the number of threads that comes back.

    It ends the process where nobody listens any more.
    """

    def __init__(self, connection: Connection, number: int, execution: Execution) -> None:
        self.connection = connection
        self.number = number
        self.execution = execution
        self.next_report = 0.0

    def __call__(self, fraction: float) -> None:
        now = time.monotonic()
        if now < self.next_report:
            return
        self.next_report = now + REPORT_INTERVAL
        try:
            self.connection.send((self.number, fraction))
            while self.connection.poll():
                self.execution.threads = self.connection.recv()
        except (EOFError, ConnectionError):
            sys.exit()  # not an Exception, so it is no outcome of the case
