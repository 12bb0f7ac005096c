"""From cases to results: a pool of worker processes, each replaced when it dies."""

from __future__ import annotations

import contextlib
import multiprocessing
import signal
import time
from collections import deque
from collections.abc import Iterator, Sequence
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from pathlib import Path
from typing import Protocol

import xarray as xr

from harness.archive import discard_partial, write_case
from harness.cases import CRASHED, Case, Outcome
from harness.worker import serve

GRACE = 2.0
"""Seconds that workers have to end after they were told to."""

# A fresh interpreter: a forked one would share the state of Warp and of the netCDF library.
_PROCESSES = multiprocessing.get_context("spawn")


class Watcher(Protocol):
    """Is told what goes on while cases run."""

    def advanced(self, case: Case, fraction: float) -> None:
        """A running case has come to `fraction`, 0 to 1."""

    def finished(self, case: Case, outcome: Outcome) -> None:
        """A case has ended, well or not."""


def run_cases(cases: Sequence[Case], folder: Path, worker_count: int, watcher: Watcher) -> None:
    """Run cases in worker processes; each result is in `folder` before `watcher` hears of it.

    Whatever becomes of a case, the others go on. An exception, such as Ctrl-C raises, ends the
    workers; the results so far are kept.

    Raises:
        harness.archive.ArchiveError: the end of a crashed case cannot be noted.
    """
    # Starting this helper of multiprocessing lets signals through that are held; so it comes first.
    resource_tracker.ensure_running()
    waiting = deque(cases)
    workers: list[_Worker] = []
    try:
        while waiting or workers:
            while waiting and len(workers) < worker_count:
                workers.append(_Worker(folder, waiting.popleft()))
            wait([worker.connection for worker in workers])
            for worker in [worker for worker in workers if worker.connection.poll()]:
                news = worker.news()
                if isinstance(news, float):
                    watcher.advanced(worker.case, news)
                    continue
                watcher.finished(worker.case, news)
                if waiting and worker.process.is_alive():
                    worker.begin(waiting.popleft())
                else:
                    workers.remove(worker)
                    _end([worker])
    finally:
        _end(workers)


class _Worker:
    """The parent's end of a worker process, and the case that it is at."""

    def __init__(self, folder: Path, case: Case) -> None:
        self.folder = folder
        self.connection, theirs = _PROCESSES.Pipe()
        self.process = _PROCESSES.Process(target=serve, args=(theirs, folder), daemon=True)
        with _interrupts_held():  # the worker inherits that and never sees a SIGINT
            self.process.start()
        # With this copy closed, the death of the worker reads as an end of file.
        theirs.close()
        self.begin(case)

    def begin(self, case: Case) -> None:
        self.case = case
        self.fraction = 0.0
        with contextlib.suppress(ConnectionError):  # a worker that has died shows in `news`
            self.connection.send(case)

    def news(self) -> float | Outcome:
        """What the worker has to say, or what became of it."""
        try:
            news: float | Outcome = self.connection.recv()
        except (EOFError, OSError):
            return self._crashed()
        if isinstance(news, float):
            self.fraction = news
        return news

    def _crashed(self) -> Outcome:
        self.process.join()
        code = self.process.exitcode or 0
        end = f"killed by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
        outcome = Outcome(CRASHED, f"worker {end} after {self.fraction:.0%} of the case")
        write_case(self.folder, self.case, xr.Dataset(), outcome.status, outcome.message)
        return outcome


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
