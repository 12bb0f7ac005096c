"""What a worker process does: it runs one case after the other, and keeps each result itself."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from multiprocessing.connection import Connection
from pathlib import Path

from harness.cases import COMPLETED, MISSING, Case, Outcome
from mpm_warp.parameters import from_mapping
from mpm_warp.scenes import Progress, scene_class

REPORT_INTERVAL = 0.1
"""Seconds between two reports of progress."""
SINGLE_THREADED = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def run_case(case: Case, folder: Path, progress: Progress | None = None) -> Outcome:
    """Run a case in this process and write its file, whatever becomes of it.

    An exception that the scene raises is the outcome of the case, by its attribute ``status``
    where it has one; it is not raised again.

    Raises:
        harness.archive.ArchiveError: the result cannot be written.
    """
    import xarray as xr

    from harness import archive

    start = time.perf_counter()
    status, message = COMPLETED, ""
    try:
        dataset = from_mapping(scene_class(case.scene), case.parameters).run(progress)
    except Exception as error:
        dataset = xr.Dataset()
        status = getattr(error, "status", "failed")
        message = " ".join(f"{type(error).__name__}: {error}".split())
    archive.write_case(folder, case, dataset, status, message)
    scalars = ((name, array) for name, array in dataset.data_vars.items() if array.ndim == 0)
    headline = next(
        (f"{str(name).replace('_', ' ')} {array.item():.4g}" for name, array in scalars), ""
    )
    return Outcome(status, message, headline, time.perf_counter() - start)


def serve(connection: Connection, folder: Path) -> None:
    """Run the cases that come over `connection`, until the other end is gone.

    Sent back are fractions done, then an :class:`Outcome`. To be called first thing in a fresh
    process, which it makes its own: signals, threads of numerical libraries.
    """
    # Ctrl-C goes to the whole process group, but it is the parent that decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # An exception, unlike the signal's default action, removes a half-written file.
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    os.environ.update(dict.fromkeys(SINGLE_THREADED, "1"))
    start_warp_in_silence()
    from harness.archive import ArchiveError

    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            case = connection.recv()
            try:
                outcome = run_case(case, folder, _Reporter(connection))
            except ArchiveError as error:
                outcome = Outcome(MISSING, str(error))
            connection.send(outcome)


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


class _Reporter:
    """Sends fractions done, now and then; ends the process where nobody listens any more."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.next_report = 0.0

    def __call__(self, fraction: float) -> None:
        now = time.monotonic()
        if now < self.next_report:
            return
        self.next_report = now + REPORT_INTERVAL
        try:
            self.connection.send(fraction)
        except ConnectionError:
            sys.exit()  # not an Exception, so it is no outcome of the case
