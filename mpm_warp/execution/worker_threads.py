"""Worker threads: threads of this process that do the parts of one work at the same time."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from queue import SimpleQueue


class WorkerThreads:
    """The caller's thread and others, which are idle between two works and end with the process.

    Args:
        count: number of threads, the caller's included, >= 1.
    """

    def __init__(self, count: int) -> None:
        self._lock = threading.Lock()
        self._queues = [SimpleQueue[Callable[[], None]]() for _ in range(count - 1)]
        for queue in self._queues:
            threading.Thread(target=_serve, args=(queue,), daemon=True).start()

    def run(self, part: Callable[[int], None], leave: Callable[[int], None]) -> None:
        """Do a work: every thread calls ``part(number)``, the caller's with 0; wait for all.

        Args:
            part: one thread's part of the work; parts may wait for each other.
            leave: called as ``leave(number)`` where a part raised: no other part is to wait for it.

        Raises:
            BaseException: the first that a part raised, or one that reached the caller, as by
                Ctrl-C.
        """
        ended: SimpleQueue[Exception | None] = SimpleQueue()

        def attempt(number: int) -> None:
            try:
                part(number)
            except Exception as error:
                leave(number)
                ended.put(error)
            else:
                ended.put(None)

        # Parts may wait for each other, so the parts of two works must not mix.
        with self._lock:
            begun = 0
            try:
                for number, queue in enumerate(self._queues, start=1):
                    queue.put(functools.partial(attempt, number))
                    begun += 1
                part(0)
            except BaseException:
                leave(0)
                raise
            finally:
                errors = [ended.get() for _ in range(begun)]
        for error in errors:
            if error is not None:
                raise error


@functools.cache
def worker_threads(count: int) -> WorkerThreads:
    """The process's worker threads of this number, started once."""
    return WorkerThreads(count)


def _serve(queue: SimpleQueue[Callable[[], None]]) -> None:
    while True:
        queue.get()()
