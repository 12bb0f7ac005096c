"""Whether threads gain by sharing the steps, which they do not where others take their cores."""

from __future__ import annotations

SHORTEST = 16
"""Steps that tell a pace, at least."""
PAUSE = 300
"""Steps on one thread before more are tried again."""
WEIGHT = 0.25
"""Of the last play among those before: a single one may be late by chance."""


class Pace:
    """Chooses how many threads take part, by what the last plays took.

    Threads wait for each other in every step: one that is off its core for a while holds up all.
    The number of threads does not change a result, so it may be chosen by the clock.
    """

    def __init__(self) -> None:
        self._seconds: dict[int, float] = {}  # a step, by threads
        self._pause = 0

    def choose(self, wanted: int) -> int:
        """The threads of the next play: as many as wanted, or one."""
        return 1 if 1 not in self._seconds or self._pause > 0 else wanted

    def note(self, threads: int, step_count: int, seconds: float) -> None:
        """Take down what a play of so many steps took."""
        if threads == 1:
            self._pause = max(0, self._pause - step_count)
        if step_count < SHORTEST:
            return
        last = seconds / step_count
        known = self._seconds.get(threads, last)
        self._seconds[threads] = known + WEIGHT * (last - known)
        if threads > 1 and self._seconds[threads] > self._seconds[1]:
            self._pause = PAUSE
            del self._seconds[threads]  # to be tried afresh
