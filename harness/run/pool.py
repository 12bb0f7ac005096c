"""From cases to results: a pool of worker processes, each replaced when it dies.

A worker's beginning stands here too: it sees to its own end where its parent is gone.
"""

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
from harness.run.resources import DEFAULTS, RunOptions, case_time, usable_cores
from harness.study.cases import Case
from mpm_warp.execution import THREAD_COUNTS

LONGEST_WAIT = 1.0
"""Seconds to wait for news at a time."""
ABANDONED = 1
"""Exit code of a worker whose parent is gone; nobody is left who would read it."""
GRACE = 2.0
"""Seconds that workers have to end after they were asked to."""
SINGLE_THREADED = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment that keeps numerical libraries of a worker to one thread."""

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
    """Run cases in worker processes; each result is in `folder` before `watcher` hears of it.

    Cases are begun in this order, at most `worker_count` at a time. One that fails does not stop
    the others. An exception, such as that of Ctrl-C, ends the workers; the results so far are kept.
    A case that another run has completed meanwhile is not run again.
    """
    # Starting this process of multiprocessing unblocks signals that are held: it must come first.
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

    def hear(worker: "WorkerProcess") -> None:
        news = worker.news()
        if isinstance(news, float):
            watcher.advanced(worker.case, news)
        elif news.status == MISSING:
            raise ArchiveError(news.message)  # results that cannot be kept need not be computed
        else:
            watcher.finished(worker.case, news)

    try:
        while waiting or workers:
            while len(workers) < worker_count and (following := next_case()):
                workers.append(WorkerProcess(folder, options))
                ready.append((workers[-1], following))
            # A worker takes the number of threads with its first report, which may come late.
            for worker in workers:
                worker.allow(options.threads or share_of_cores(len(workers)))
            for worker, following in ready:
                worker.begin(following)
            ready.clear()
            for worker in _with_news(workers):
                hear(worker)
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
    """Threads of each of the cases that share the cores that this process may use."""
    cores = usable_cores() // cases_at_work
    return max((count for count in THREAD_COUNTS if count <= cores), default=1)


def cases_at_once(threads: int | None) -> int:
    """Number of cases that fit these cores with so many threads each; None means one."""
    return max(1, usable_cores() // (threads or 1))


def _with_news(workers: Sequence["WorkerProcess"]) -> list["WorkerProcess"]:
    """Wait for workers that have something to say or have taken too long.

    While this process is stopped, as by Ctrl-Z, so are its workers: that is no time of theirs.
    """
    begin = time.monotonic()
    left = min((worker.deadline - begin for worker in workers), default=0.0)
    wait([worker.connection for worker in workers], min(max(0.0, left), LONGEST_WAIT))
    waited = time.monotonic() - begin
    for worker in workers if waited > 2.0 * LONGEST_WAIT else ():
        worker.began += waited
    return [worker for worker in workers if worker.has_news]


class WorkerProcess:
    """A worker process as the parent sees it, with the case that it was given last."""

    def __init__(self, folder: Path, options: RunOptions = DEFAULTS) -> None:
        self.folder = folder
        self.options = options
        self.threads = 1
        self.is_at_work = False
        self.connection, theirs = _PROCESSES.Pipe()
        self.process = _PROCESSES.Process(
            target=serve_while_parent_lives, args=(theirs, folder, options), daemon=True
        )
        # The worker inherits this before its libraries load; those of this process have.
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
        self.began = math.inf  # until all is imported, set up and compiled
        self._send(case)

    def allow(self, threads: int) -> None:
        """Tell the worker how many threads to use from now on."""
        if threads != self.threads:
            self.threads = threads
            self._send(threads)

    def _send(self, message: Case | int) -> None:
        with contextlib.suppress(ConnectionError):  # a worker that has died shows in `news`
            self.connection.send(message)

    @property
    def deadline(self) -> float:
        """Time on the monotonic clock at which its case has taken too long [s]."""
        return self.began + self.options.time_limit

    @property
    def has_news(self) -> bool:
        """Whether it has sent a message, or its case has taken too long."""
        return self.connection.poll() or time.monotonic() >= self.deadline

    def news(self) -> float | Outcome:
        """The message of the worker on its case: the fraction done, or how it ended."""
        if not self.connection.poll():
            assert self.has_news
            end_all([self])
            return self._lost(TIMED_OUT, f"ended after {self.options.time_limit:g} s")
        try:
            news: float | Outcome | None = self.connection.recv()
        except (EOFError, OSError):
            self.process.join()
            code = self.process.exitcode or 0
            end = signal.Signals(-code).name if code < 0 else f"code {code}"
            return self._lost(CRASHED, f"worker {'killed by' if code < 0 else 'ended with'} {end}")
        if news is None:  # the case is taken on
            return 0.0
        if isinstance(news, float):
            self.fraction = news
            self.began = min(self.began, time.monotonic())
        else:
            self.is_at_work = False
        return news

    def _lost(self, status: str, end: str) -> Outcome:
        """How the case of a dead worker ended."""
        self.is_at_work = False
        if is_complete(self.folder, self.case, self.options.repeats):
            return Outcome(COMPLETED)  # it wrote the result, and died before it could say so
        seconds = max(0.0, time.monotonic() - self.began)
        message = f"{end}, at {self.fraction:.0%} of the case"
        dataset = xr.Dataset({"case_time": case_time(seconds)})
        write_case(self.folder, self.case, dataset, status, message)
        return Outcome(status, message, seconds=seconds)


def end_all(workers: Sequence["WorkerProcess"]) -> None:
    """End worker processes at once, and remove what they were writing."""
    with _interrupts_held():
        for worker in workers:
            # An idle one has nothing half-written, and would take 0.4 s to unload its libraries.
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
    """Let Ctrl-C, SIGTERM and SIGHUP wait until the block is over.

    Python's handlers are replaced, because any thread may receive a signal of the process, also a
    thread of a numerical library. SIGINT and SIGHUP are blocked as well, and a worker inherits
    that: a terminal sends them to the whole group, but it is the parent that decides.
    """
    came: list[int] = []
    handlers = {
        number: signal.signal(number, lambda number, frame: came.append(number))
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        # A worker inherits what is ignored, as SIGHUP under `nohup`, and nothing else.
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for late in came:
            signal.raise_signal(late)


def serve_while_parent_lives(connection: Connection, folder: Path, options: RunOptions) -> None:
    """Run cases as `harness.run.worker.serve` does, until the parent process is gone.

    To be called first in a fresh process. The process then ends at once, whatever it computes. A
    file that it was writing is half-written under another name, and the next run removes it.
    """
    threading.Thread(target=_end_with_parent, daemon=True).start()
    # Loads Warp and all scenes, which takes seconds.
    from harness.run.worker import serve

    serve(connection, folder, options)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "a worker has a parent"
    wait([parent.sentinel])
    # Not an exception, which would have to wait until the step is done.
    os._exit(ABANDONED)
