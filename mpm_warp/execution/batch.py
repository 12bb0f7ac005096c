"""Many runs at the same time, in lockstep: those alike take their steps in common launches.

Each run is an ordinary function in a thread of its own, of which one at a time is at work. It waits
where it is to take steps until all others wait too, or have ended; then the steps are taken.
"""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

import warp as wp

from mpm_warp.execution.execution import Execution
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.execution.replay import Player
from mpm_warp.execution.batched_plan import likeness, stack

POINTS_IN_CACHE = 12_000
"""Material points that a processor takes through a step together: more would leave its cache."""

Result = TypeVar("Result")


@dataclass
class Batch(Execution):
    """An execution that many runs share.

    On a processor the result of a run does not depend on which others are in the batch, not by a
    bit.
    """

    _players: dict[tuple[_Run, ...], Player] = field(default_factory=dict, init=False)
    _seat: _Seat | None = field(default=None, init=False)
    _case_count: int = field(default=0, init=False)

    def run(self, works: Sequence[Callable[[], Result]]) -> list[Result]:
        """Run functions that simulate with this execution.

        Returns:
            What each has returned.

        Raises:
            BaseException: the first that a function raised; the others are then given up.
        """
        self._case_count = len(works)
        results: dict[int, Result] = {}

        def keep(number: int) -> None:
            results[number] = works[number]()

        seats = [_Seat(partial(keep, number)) for number in range(len(works))]
        try:
            while seats:
                for seat in seats:
                    if not seat.waits_for_steps:
                        self._seat = seat
                        seat.take_turn()
                seats = [seat for seat in seats if not seat.is_over]
                self._take_steps([seat.run for seat in seats if seat.run is not None])
        finally:
            self._players.clear()
            for seat in seats:
                seat.dismiss()
        return [results[number] for number in range(len(works))]

    def steps(self, plan: Plan, arrays: dict[str, Any]) -> _Run:
        """See `Execution`; to be called from within a function of :meth:`run`."""
        assert self._seat is not None, "no function of this batch is at work"
        return _Run(self._seat, plan, arrays, self.device)

    @property
    def idle_time(self) -> float:
        """See `Execution`; of the function that asks."""
        assert self._seat is not None, "no function of this batch is at work"
        return self._seat.idle_time

    @property
    def case_count(self) -> int:
        """See `Execution`."""
        return self._case_count

    @property
    def _is_on_gpu(self) -> bool:
        return bool(wp.get_device(self.device).is_cuda)

    def _take_steps(self, runs: Sequence[_Run]) -> None:
        """As many as all alike have left; the players of runs that still go on are kept."""
        groups: dict[Hashable, list[_Run]] = defaultdict(list)
        for run in runs:
            groups[run.likeness, run.left.start].append(run)
        players = {}
        for alike in groups.values():
            steps = min((run.left for run in alike), key=len)
            for together in self._portions(alike):
                player = self._players.get(together) or self._player(together)
                begin = time.perf_counter()
                player.play(steps, self.threads)
                wp.synchronize_device(self.device)
                seconds = time.perf_counter() - begin
                for run in together:
                    run.note(len(steps), seconds / len(together))
                players[together] = player
        self._players = players

    def _portions(self, alike: Sequence[_Run]) -> Iterator[tuple[_Run, ...]]:
        size = len(alike)
        if not self._is_on_gpu:
            size = max(1, POINTS_IN_CACHE // max(1, alike[0].plan.particle_count))
        for first in range(0, len(alike), size):
            yield tuple(alike[first : first + size])

    def _player(self, together: tuple[_Run, ...]) -> Player:
        plan, arrays = together[0].plan, together[0].arrays
        if len(together) > 1:
            plans = [run.plan for run in together]
            # A GPU has a thread for each item; the views of a case's arrays take a thread time.
            chunk_size = 1 if self._is_on_gpu else None
            plan, arrays = stack(plans, [run.arrays for run in together], self.device, chunk_size)
        return Player(plan, arrays, self.device)


class _Run:
    """A run that takes its steps together with those alike; see `mpm_warp.execution.execution.Steps`."""

    def __init__(self, seat: _Seat, plan: Plan, arrays: dict[str, Any], device: str) -> None:
        self.plan = plan
        self.arrays = arrays
        self.likeness = likeness(plan)
        self.left = range(0)
        self._busy_time = 0.0
        self._seat = seat
        self._own = Player(plan, arrays, device)

    def launch(self, launch: Launch) -> None:
        """Launch one of this run alone."""
        self._own.launch(launch)

    def play(self, steps: range, threads: int) -> None:
        """Wait until these steps have been taken."""
        self.left = steps
        begin, busy = time.perf_counter(), self._busy_time
        self._seat.wait(self)
        waited = time.perf_counter() - begin
        self._seat.idle_time += waited - (self._busy_time - busy)

    def note(self, step_count: int, seconds: float) -> None:
        """Take down that steps have been taken, in so much time for this run alone."""
        self.left = self.left[step_count:]
        self._busy_time += seconds


class _Seat:
    """A function in a thread of its own, which is at work only when it has its turn.

    Attributes:
        run: for whose steps it waits, or waited last.
        is_over: whether it has ended.
        idle_time: time that it has waited while steps of others were taken [s].
    """

    def __init__(self, work: Callable[[], None]) -> None:
        self.run: _Run | None = None
        self.is_over = False
        self.idle_time = 0.0
        self._work = work
        self._error: BaseException | None = None
        self._is_dismissed = False
        self._turn = threading.Semaphore(0)
        self._turn_is_over = threading.Semaphore(0)
        self._thread = threading.Thread(target=self._sit, daemon=True)
        self._thread.start()

    @property
    def waits_for_steps(self) -> bool:
        """Whether there are steps to take before its next turn."""
        return self.run is not None and len(self.run.left) > 0

    def take_turn(self) -> None:
        """Let it work until it waits or ends.

        Raises:
            BaseException: what the function has raised.
        """
        self._turn.release()
        self._turn_is_over.acquire()
        if self._error is not None:
            raise self._error

    def wait(self, run: _Run) -> None:
        """End the turn, from within the function, until steps of a run have been taken."""
        self.run = run
        self._turn_is_over.release()
        self._turn.acquire()
        if self._is_dismissed:
            raise SystemExit

    def dismiss(self) -> None:
        """End the function where it waits; it cleans up after itself."""
        if not self.is_over:
            self._is_dismissed = True
            self._turn.release()
            self._thread.join()

    def _sit(self) -> None:
        self._turn.acquire()
        try:
            if not self._is_dismissed:
                self._work()
        except BaseException as error:
            self._error = error
        finally:
            self.is_over = True
            self._turn_is_over.release()
