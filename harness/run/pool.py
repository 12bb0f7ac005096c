"""A pool of worker processes that run cases; a worker that dies is replaced."""

import contextlib
import math
import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Protocol

import xarray as xr

from harness.archive.atomic_files import ArchiveError, discard_partial
from harness.archive.case_files import Outcome, is_complete, write_case
from harness.archive.conventions import COMPLETED, CRASHED, MISSING, TIMED_OUT
from harness.machine import usable_cores
from harness.run.resources import DEFAULTS, RunOptions, case_time
from harness.study.cases import Case
from mpm_warp.execution import THREAD_COUNTS

LONGEST_WAIT = 1.0
"""Longest time to wait for a message [s]."""
MOST_WAITED_FOR = 60
"""Workers whose messages end the wait at once; Windows waits for at most 63 objects."""
ABANDONED = 1
"""Exit code of a worker whose parent process has ended."""
GRACE = 2.0
"""Time that a worker has to end after SIGTERM [s]; then it is killed."""
MASKS_SIGNALS = hasattr(signal, "pthread_sigmask")
HANG_UP = (signal.SIGHUP,) if hasattr(signal, "SIGHUP") else ()
"""What a system has: POSIX both, Windows neither."""
SINGLE_THREADED = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that limit the numerical libraries of a worker to one thread."""

# A fresh interpreter: a forked one would share the state of Warp and of the netCDF library.
_PROCESSES = multiprocessing.get_context("spawn")


class Watcher(Protocol):
    """Receives reports while cases run."""

    def advanced(self, case: Case, fraction: float) -> None:
        """The fraction of a running case that is done, 0 to 1."""

    def finished(self, case: Case, outcome: Outcome) -> None:
        """A case has ended, well or not."""


def run_cases(
    cases: Sequence[Case],
    folder: Path,
    worker_count: int,
    watcher: Watcher,
    options: RunOptions = DEFAULTS,
) -> None:
    """Run cases in worker processes; each result is written to `folder`, then `watcher` is told.

    Cases begin in this order, at most `worker_count` at a time. A case that fails does not stop the
    others. An exception, such as KeyboardInterrupt, ends the workers; finished results are kept. A
    case that another run has completed meanwhile is not run again.
    """
    if MASKS_SIGNALS:
        # Starting the resource tracker unblocks signals that are held, so it must come first.
        resource_tracker.ensure_running()
    waiting = deque(cases)
    workers: list[WorkerProcess] = []
    ready = list[tuple[WorkerProcess, Case]]()

    def next_case() -> Case | None:
        while waiting:
            case = waiting.popleft()
            if not is_complete(folder, case, options.repeats):
                return case
            watcher.finished(case, Outcome(COMPLETED, "by another run"))
        return None

    def receive(worker: "WorkerProcess") -> None:
        message = worker.receive()
        if isinstance(message, float):
            watcher.advanced(worker.case, message)
        elif message.status == MISSING:  # results cannot be written, so no more are computed
            raise ArchiveError(message.message)
        else:
            watcher.finished(worker.case, message)

    try:
        while waiting or workers:
            while len(workers) < worker_count and (following := next_case()):
                workers.append(WorkerProcess(folder, options))
                ready.append((workers[-1], following))
            # A running worker reads its number of threads at its next report, so this comes first.
            for worker in workers:
                worker.allow(options.threads or share_of_cores(len(workers)))
            for worker, following in ready:
                worker.begin(following)
            ready.clear()
            for worker in _wait_for_messages(workers):
                receive(worker)
                if worker.is_at_work:
                    continue
                following = next_case() if worker.process.is_alive() else None
                if following:
                    ready.append((worker, following))
                else:
                    workers.remove(worker)
                    end_all([worker])
    finally:
        end_all(workers)


def share_of_cores(cases_at_work: int) -> int:
    """Threads of each case if so many cases share the usable cores."""
    cores = usable_cores() // cases_at_work
    return max((count for count in THREAD_COUNTS if count <= cores), default=1)


def cases_at_once(threads: int | None) -> int:
    """Number of cases with so many threads each that fit the usable cores; None means one."""
    return max(1, usable_cores() // (threads or 1))


def _wait_for_messages(workers: Sequence["WorkerProcess"]) -> list["WorkerProcess"]:
    """Wait a while; return the workers that have sent a message or exceeded their time limit.

    While this process is stopped, by Ctrl-Z for example, so are its workers. That time of theirs
    does not count.
    """
    begin = time.monotonic()
    left = min((worker.deadline - begin for worker in workers), default=0.0)
    connections = [worker.connection for worker in workers[:MOST_WAITED_FOR]]
    wait(connections, min(max(0.0, left), LONGEST_WAIT))
    waited = time.monotonic() - begin
    for worker in workers if waited > 2.0 * LONGEST_WAIT else ():
        worker.began += waited
    return [worker for worker in workers if worker.has_message]


class WorkerProcess:
    """A worker process, seen from the parent, and the case that it was given last."""

    def __init__(self, folder: Path, options: RunOptions = DEFAULTS) -> None:
        self.folder = folder
        self.options = options
        self.threads = 1
        self.is_at_work = False
        self.connection, theirs = _PROCESSES.Pipe()
        self.process = _PROCESSES.Process(
            target=serve_while_parent_lives, args=(theirs, folder, options), daemon=True
        )
        # The worker inherits these; the libraries of this process have loaded already.
        os.environ.update(dict.fromkeys(SINGLE_THREADED, "1"))
        with _interrupts_held():  # the worker inherits the mask: no SIGINT, no SIGHUP
            self.process.start()
        # With this copy closed, the end of the worker reads as an end of file.
        theirs.close()

    def begin(self, case: Case) -> None:
        """Give the worker a case to run."""
        self.case = case
        self.is_at_work = True
        self.fraction = 0.0
        self.began = math.inf  # until imports, set-up and compilation are done
        self._send(case)

    def allow(self, threads: int) -> None:
        """Tell the worker how many threads to use from now on."""
        if threads != self.threads:
            self.threads = threads
            self._send(threads)

    def _send(self, message: Case | int) -> None:
        with contextlib.suppress(ConnectionError):  # `receive` notices that a worker has died
            self.connection.send(message)

    @property
    def deadline(self) -> float:
        """Time on the monotonic clock at which its case has taken too long [s]."""
        return self.began + self.options.time_limit

    @property
    def has_message(self) -> bool:
        """Whether it has sent a message, or its case has taken too long."""
        return self._can_read or time.monotonic() >= self.deadline

    @property
    def _can_read(self) -> bool:
        """Whether there is a message or its end; on Windows `poll` would raise at the end."""
        return bool(wait([self.connection], 0.0))

    def receive(self) -> float | Outcome:
        """The message of the worker on its case: the fraction done, or how it ended."""
        if not self._can_read:
            assert self.has_message
            end_all([self])
            return self._lost(TIMED_OUT, f"ended after {self.options.time_limit:g} s")
        try:
            message: float | Outcome | None = self.connection.recv()
        except (EOFError, OSError):
            self.process.join()
            code = self.process.exitcode or 0
            end = signal.Signals(-code).name if code < 0 else f"code {code}"
            return self._lost(CRASHED, f"worker {'killed by' if code < 0 else 'ended with'} {end}")
        if message is None:  # it has accepted the case
            return 0.0
        if isinstance(message, float):
            self.fraction = message
            self.began = min(self.began, time.monotonic())
        else:
            self.is_at_work = False
        return message

    def _lost(self, status: str, end: str) -> Outcome:
        """The outcome of the case of a dead worker, which is written to its file."""
        self.is_at_work = False
        if is_complete(self.folder, self.case, self.options.repeats):
            return Outcome(COMPLETED)  # it died after it had written the result
        seconds = max(0.0, time.monotonic() - self.began)
        message = f"{end}, at {self.fraction:.0%} of the case"
        dataset = xr.Dataset({"case_time": case_time(seconds)})
        write_case(self.folder, self.case, dataset, status, message)
        return Outcome(status, message, seconds=seconds)


def end_all(workers: Sequence["WorkerProcess"]) -> None:
    """End worker processes at once, and remove their half-written files."""
    with _interrupts_held():
        for worker in workers:
            # An idle worker has no half-written file, and takes 0.4 s to end by itself.
            if worker.is_at_work:
                worker.process.terminate()
            else:
                worker.process.kill()
        deadline = time.monotonic() + GRACE
        for worker in workers:
            worker.process.join(max(0.0, deadline - time.monotonic()))
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join()
            worker.connection.close()
            assert worker.process.pid is not None  # it was started
            discard_partial(worker.folder, worker.process.pid)


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Delay Ctrl-C, SIGTERM and SIGHUP until the end of the block.

    Python's handlers are replaced, because any thread of the process may receive a signal, also one
    of a numerical library. SIGINT and SIGHUP are blocked too, and a worker inherits that: a
    terminal sends them to all processes, but only the parent decides what to do.
    """
    received: list[int] = []
    handlers = {
        number: signal.signal(number, lambda number, frame: received.append(number))
        for number in (signal.SIGINT, signal.SIGTERM, *HANG_UP)
        # A signal that is ignored, such as SIGHUP under `nohup`, stays so in a worker.
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    if MASKS_SIGNALS:
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, *HANG_UP})
    try:
        yield
    finally:
        if MASKS_SIGNALS:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for late in received:
            signal.raise_signal(late)


def serve_while_parent_lives(connection: Connection, folder: Path, options: RunOptions) -> None:
    """Run cases by `harness.run.worker.serve` until the parent process ends; then exit at once.

    This is the first function of a worker. A file that is half-written when it exits has a
    temporary name, and the next run removes it.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # on Windows, where it inherits no mask
    threading.Thread(target=_end_with_parent, daemon=True).start()
    # This import loads Warp and all scenes, which takes seconds.
    from harness.run.worker import serve

    serve(connection, folder, options)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker has a parent"
    wait([parent.sentinel])
    # An exception would only take effect after the present step.
    os._exit(ABANDONED)
