"""From cases to results: a pool of worker processes, each replaced when it dies."""

import math
import os
import time
from collections import deque
from collections.abc import Sequence
from multiprocessing import resource_tracker
from multiprocessing.connection import wait
from pathlib import Path
from typing import Protocol

from harness.archive.atomic_files import ArchiveError
from harness.archive.case_files import Outcome, is_complete
from harness.archive.conventions import COMPLETED, MISSING
from harness.run.resources import DEFAULTS, RunOptions
from harness.run.worker_process import WorkerProcess, end_all
from harness.study.cases import Case
from mpm_warp.execution import THREAD_COUNTS

LONGEST_WAIT = 1.0
"""Seconds to wait for news at a time."""


class Watcher(Protocol):
    """Receives reports of what goes on while cases run."""

    def advanced(self, case: Case, fraction: float) -> None:
        """A running case has come to `fraction`, 0 to 1."""

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
    alone: deque[Case] = deque()
    workers: list[WorkerProcess] = []
    ready = list[tuple[WorkerProcess, list[Case]]]()

    def next_case(queue: deque[Case]) -> Case | None:
        while queue:
            case = queue.popleft()
            if not is_complete(folder, case, options.repeats):
                return case
            watcher.finished(case, Outcome(COMPLETED, "by another run"))
        return None

    def next_cases() -> list[Case]:
        if case := next_case(alone):
            return [case]
        count = min(options.batch, math.ceil(len(waiting) / worker_count))
        return [case for _ in range(count) if (case := next_case(waiting))]

    def hear(worker: WorkerProcess) -> None:
        for case, news in worker.news():
            if isinstance(news, float):
                watcher.advanced(case, news)
            elif news.status == MISSING:
                raise ArchiveError(news.message)  # results that cannot be kept need not be computed
            else:
                watcher.finished(case, news)

    try:
        while waiting or alone or workers:
            while len(workers) < worker_count and (following := next_cases()):
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
                alone.extend(worker.left.values())
                following = next_cases() if worker.process.is_alive() else []
                if following:
                    ready.append((worker, following))
                else:
                    workers.remove(worker)
                    end_all([worker])
    finally:
        end_all(workers)


def share_of_cores(cases_at_work: int) -> int:
    """Threads of each of the cases that share the cores of this machine."""
    cores = (os.cpu_count() or 1) // cases_at_work
    return max((count for count in THREAD_COUNTS if count <= cores), default=1)


def cases_at_once(threads: int | None) -> int:
    """Cases that have the cores of this machine, of so many threads each; None: of one."""
    return max(1, (os.cpu_count() or 1) // (threads or 1))


def _with_news(workers: Sequence[WorkerProcess]) -> list[WorkerProcess]:
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
