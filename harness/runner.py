"""From cases to results: a pool of worker processes, each replaced when it dies."""

from __future__ import annotations

import contextlib
import math
import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Iterator, Sequence
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from pathlib import Path
from typing import Protocol

import xarray as xr

from harness.case_files import is_complete, write_case
from harness.cases import COMPLETED, CRASHED, MISSING, TIMED_OUT, Case, Outcome
from harness.measuring import case_time
from harness.whole_files import ArchiveError, discard_partial
from harness.worker import serve
from mpm_warp.execution import THREAD_COUNTS

GRACE = 2.0
"""Seconds that workers have to end after they were told to."""
LONGEST_WAIT = 3600.0
"""Seconds to wait for news at a time: the system takes no more than some weeks."""

# A fresh interpreter: a forked one would share the state of Warp and of the netCDF library.
_PROCESSES = multiprocessing.get_context("spawn")


class Watcher(Protocol):
    """Is told what goes on while cases run."""

    def advanced(self, case: Case, fraction: float) -> None:
        """A running case has come to `fraction`, 0 to 1."""

    def finished(self, case: Case, outcome: Outcome) -> None:
        """A case has ended, well or not."""


def run_cases(
    cases: Sequence[Case],
    folder: Path,
    worker_count: int,
    watcher: Watcher,
    *,
    device: str = "cpu",
    threads: int | None = None,
    time_limit: float = math.inf,
    repeats: int = 0,
    batch: int = 1,
) -> None:
    """Run cases in worker processes; each result is in `folder` before `watcher` hears of it.

    Whatever becomes of a case, the others go on. An exception, such as Ctrl-C raises, ends the
    workers; the results so far are kept. A case that another run has completed meanwhile is not
    run again.

    Args:
        cases: what to run, in this order.
        folder: where the case files are.
        worker_count: greatest number of processes at work.
        watcher: is told what goes on.
        device: where the cases are computed.
        threads: for each case; None: the cases at work share the cores, whose number may be more
            than theirs where there are few, or few left.
        time_limit: time that a case may take [s]; one that takes more is ended. Cases that a
            process runs together have the sum of theirs.
        repeats: times to run each case again to measure its run time warm.
        batch: greatest number of cases that a process runs together. If it dies, or its time is up,
            those of them that are not done are run again one by one.

    Raises:
        harness.whole_files.ArchiveError: a result cannot be written.
    """
    # Starting this helper of multiprocessing lets signals through that are held; so it comes first.
    resource_tracker.ensure_running()
    waiting = deque(cases)
    alone: deque[Case] = deque()
    workers: list[_Worker] = []
    ready = list[tuple[_Worker, list[Case]]]()

    def next_case(queue: deque[Case]) -> Case | None:
        while queue:
            case = queue.popleft()
            if not is_complete(folder, case, repeats):
                return case
            watcher.finished(case, Outcome(COMPLETED, "by another run"))
        return None

    def next_cases() -> list[Case]:
        if case := next_case(alone):
            return [case]
        count = min(batch, math.ceil(len(waiting) / worker_count))
        return [case for _ in range(count) if (case := next_case(waiting))]

    def hear(worker: _Worker) -> None:
        for case, news in worker.news(time_limit):
            if isinstance(news, float):
                watcher.advanced(case, news)
            elif news.status == MISSING:
                raise ArchiveError(news.message)  # of no use to compute what is not kept
            else:
                watcher.finished(case, news)

    try:
        while waiting or alone or workers:
            while len(workers) < worker_count and (following := next_cases()):
                workers.append(_Worker(folder, device, repeats))
                ready.append((workers[-1], following))
            # A case may take long to its first report, and is told of its threads no sooner.
            for worker in workers:
                worker.allow(threads or share_of_cores(len(workers)))
            for worker, following in ready:
                worker.begin(following)
            ready.clear()
            for worker in _with_news(workers, time_limit):
                hear(worker)
                if worker.is_at_work:
                    continue
                alone.extend(worker.left.values())
                following = next_cases() if worker.process.is_alive() else []
                if following:
                    ready.append((worker, following))
                else:
                    workers.remove(worker)
                    _end([worker])
    finally:
        _end(workers)


class _Worker:
    """The parent's end of a worker process.

    Attributes:
        given: cases that it was given to run together.
        left: those that are not done, by their number among them.
        is_at_work: whether it is at them.
    """

    def __init__(self, folder: Path, device: str, repeats: int) -> None:
        self.folder = folder
        self.repeats = repeats
        self.threads = 1
        self.connection, theirs = _PROCESSES.Pipe()
        self.process = _PROCESSES.Process(
            target=serve, args=(theirs, folder, device, repeats), daemon=True
        )
        with _interrupts_held():  # the worker inherits that and never sees a SIGINT
            self.process.start()
        # With this copy closed, the death of the worker reads as an end of file.
        theirs.close()

    def begin(self, cases: Sequence[Case]) -> None:
        self.given = tuple(cases)
        self.left = dict(enumerate(cases))
        self.is_at_work = True
        self.fraction = 0.0
        self.began = math.inf  # a new worker needs its time to start
        self._send(self.given)

    def allow(self, threads: int) -> None:
        """Tell the worker how many threads to use from now on."""
        if threads != self.threads:
            self.threads = threads
            self._send(threads)

    def _send(self, message: tuple[Case, ...] | int) -> None:
        with contextlib.suppress(ConnectionError):  # a worker that has died shows in `news`
            self.connection.send(message)

    def deadline(self, time_limit: float) -> float:
        return self.began + time_limit * len(self.given)

    def is_late(self, time_limit: float) -> bool:
        return time.monotonic() >= self.deadline(time_limit)

    def news(self, time_limit: float) -> list[tuple[Case, float | Outcome]]:
        """What the worker has to say, or what became of its cases."""
        if not self.connection.poll():
            assert self.is_late(time_limit)
            _end([self])
            return self._lost(TIMED_OUT, f"ended after {time_limit:g} s")
        try:
            number, news = self.connection.recv()
        except (EOFError, OSError):
            self.process.join()
            code = self.process.exitcode or 0
            end = signal.Signals(-code).name if code < 0 else f"code {code}"
            return self._lost(CRASHED, f"worker {'killed by' if code < 0 else 'ended with'} {end}")
        case = self.given[number]
        if isinstance(news, float):
            self.fraction = news
            self.began = min(self.began, time.monotonic())
        else:
            del self.left[number]
            self.is_at_work = bool(self.left)
        return [(case, news)]

    def _lost(self, status: str, end: str) -> list[tuple[Case, float | Outcome]]:
        """Note what became of the cases of a worker that is no more, but not of all of many."""
        self.is_at_work = False
        news: list[tuple[Case, float | Outcome]] = []
        for number, case in list(self.left.items()):
            if is_complete(self.folder, case, self.repeats):
                outcome = Outcome(COMPLETED)  # it came to write the result, not to tell of it
            elif len(self.given) == 1:
                seconds = max(0.0, time.monotonic() - self.began)
                message = f"{end}, at {self.fraction:.0%} of the case"
                outcome = Outcome(status, message, seconds=seconds)
                dataset = xr.Dataset({"case_time": case_time(seconds)})
                write_case(self.folder, case, dataset, status, message)
            else:
                continue
            del self.left[number]
            news.append((case, outcome))
        return news


def share_of_cores(cases_at_work: int) -> int:
    """Threads of each of the cases that share the cores of this machine."""
    cores = (os.cpu_count() or 1) // cases_at_work
    return max((count for count in THREAD_COUNTS if count <= cores), default=1)


def cases_at_once(threads: int | None) -> int:
    """Cases that have the cores of this machine, of so many threads each; None: of one."""
    return max(1, (os.cpu_count() or 1) // (threads or 1))


def _with_news(workers: Sequence[_Worker], time_limit: float) -> list[_Worker]:
    """Wait for workers that have something to say or have taken too long."""
    deadline = min((worker.deadline(time_limit) for worker in workers), default=0.0)
    left = min(max(0.0, deadline - time.monotonic()), LONGEST_WAIT)
    wait([worker.connection for worker in workers], left)
    return [it for it in workers if it.connection.poll() or it.is_late(time_limit)]


def _end(workers: Sequence[_Worker]) -> None:
    """End worker processes at once, and remove what they were writing."""
    with _interrupts_held():
        for worker in workers:
            worker.process.terminate()
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
    """Let Ctrl-C and SIGTERM wait until the block is over.

    Python's own handlers are put off, because any thread may be handed a signal of the process,
    one of a numerical library too. SIGINT is blocked besides, which a worker inherits.
    """
    came: list[int] = []
    handlers = {
        number: signal.signal(number, lambda number, frame: came.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for late in came:
            signal.raise_signal(late)
