"""Threads of this process that do their parts of one work at the same time."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from queue import SimpleQueue


class Team:
    """The caller, and threads that idle between two works and end with the process.

    Args:
        size: number of threads, the caller's among them, >= 1.
    """

    def __init__(self, size: int) -> None:
        self._turn = threading.Lock()
        self._posts = [SimpleQueue[Callable[[], None]]() for _ in range(size - 1)]
        for post in self._posts:
            threading.Thread(target=_serve, args=(post,), daemon=True).start()

    def run(self, part: Callable[[int], None], leave: Callable[[int], None]) -> None:
        """Have every thread do its part: ``part(number)``, 0 the caller's; return when all have.

        Args:
            part: parts may wait for each other.
            leave: called where a part ends early, ``leave(number)``: no other is to wait for it.

        Raises:
            BaseException: the first that a part raised, or that reached the caller, as by Ctrl-C.
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

        # Parts may wait for each other, so those of two works must not mix.
        with self._turn:
            begun = 0
            try:
                for number, post in enumerate(self._posts, start=1):
                    post.put(functools.partial(attempt, number))
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
def team_of(size: int) -> Team:
    """The process's own team of that size."""
    return Team(size)


def _serve(post: SimpleQueue[Callable[[], None]]) -> None:
    while True:
        post.get()()
