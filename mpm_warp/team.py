"""Threads of this process that do their parts of one work at the same time."""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from queue import SimpleQueue


class Team:
    """A fixed number of threads; they idle between two works, and end with the process.

    Args:
        size: number of threads, >= 1.
    """

    def __init__(self, size: int) -> None:
        self._turn = threading.Lock()
        self._posts: list[SimpleQueue[Callable[[], None]]] = [SimpleQueue() for _ in range(size)]
        for post in self._posts:
            threading.Thread(target=_serve, args=(post,), daemon=True).start()

    def run(self, part: Callable[[int], None]) -> None:
        """Have every thread do its part: ``part(number)``; return when all have.

        The caller waits in Python, so that Ctrl-C gets through; the parts then come to their end.

        Raises:
            Exception: the first that a part raised.
        """
        ended: SimpleQueue[Exception | None] = SimpleQueue()

        def attempt(number: int) -> None:
            try:
                part(number)
            except Exception as error:
                ended.put(error)
            else:
                ended.put(None)

        # Parts may wait for each other, so those of two works must not mix.
        with self._turn:
            for number, post in enumerate(self._posts):
                post.put(functools.partial(attempt, number))
            errors = [ended.get() for _ in self._posts]
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
