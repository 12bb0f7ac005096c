"""Where a run is computed, and on how many threads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan

THREAD_COUNTS = (1, 2, 4)
"""Threads that a run may have on processors: divisors of its shares."""


class Steps(Protocol):
    """The launches of a plan on a device."""

    def launch(self, launch: Launch) -> None:
        """Launch one of them."""

    def play(self, steps: range, threads: int) -> None:
        """Take steps of these numbers, with as many threads of the processor."""


@dataclass
class Execution:
    """Where a run is computed. It may be given other threads while the run goes on.

    The number of threads of a processor does not change the result, not by a bit; a GPU adds up in
    an order of its own.

    Attributes:
        device: "cpu", or a GPU by Warp's name for it, "cuda:0" say.
        threads: threads of the processor that take part, one of `THREAD_COUNTS`; a GPU has its own.
    """

    device: str = "cpu"
    threads: int = 1

    def steps(self, plan: Plan, arrays: dict[str, Any]) -> Steps:
        """The launches of a plan, for a run whose arrays may be put elsewhere on the device."""
        from mpm_warp.execution.replay import Player

        return Player(plan, arrays, self.device)

    @property
    def idle_time(self) -> float:
        """Time for which a run has stood still while others went on [s]."""
        return 0.0

    @property
    def case_count(self) -> int:
        """Runs that are computed together."""
        return 1
