"""Where a run is computed, and on how many threads."""

from __future__ import annotations

from dataclasses import dataclass

THREAD_COUNTS = (1, 2, 4)
"""Threads that a run may have on processors: divisors of its shares."""


@dataclass
class Execution:
    """Where a run is computed. It may be given other threads while the run goes on.

    The number of threads does not change the result, not by a bit.

    Attributes:
        device: "cpu", or a GPU by Warp's name for it, "cuda:0" say.
        threads: threads of the processor that take part, one of `THREAD_COUNTS`; a GPU has its own.
    """

    device: str = "cpu"
    threads: int = 1
