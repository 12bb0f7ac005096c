"""Batch: many runs at the same time, step by step; runs of one batch key share their launches.

Each run is an ordinary function, a case, in a thread of its own. One thread at a time is at work. A
case that is to take steps waits until all other cases wait too, or have ended; then all steps are
taken.
"""

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, TypeVar

import warp as wp

from mpm_warp.execution.batched import batch_key, batched_plan
from mpm_warp.execution.execution import Execution
from mpm_warp.execution.replay import Replay
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan

POINTS_IN_CACHE = 12_000
"""Material points that a processor takes through a step together; more would leave its cache."""

Result = TypeVar("Result")


@dataclass
class Batch(Execution):
    """An execution that many runs share.

    On a processor the result of a run does not depend on the other runs of the batch, not by a bit.
    """

    _replays: "dict[tuple[_BatchedSteps, ...], Replay]" = field(default_factory=dict, init=False)
    _at_work: "_CaseThread | None" = field(default=None, init=False)
    _case_count: int = field(default=0, init=False)

    def run(self, works: Sequence[Callable[[], Result]]) -> list[Result]:
        """Run functions that simulate with this execution.

        Args:
            works: the functions, one for each case.

        Returns:
            What each function returned.

        Raises:
            BaseException: the first that a function raised; the other functions are then ended.
        """
        self._case_count = len(works)
        results: dict[int, Result] = {}

        def keep(number: int) -> None:
            results[number] = works[number]()

        cases = [_CaseThread(partial(keep, number)) for number in range(len(works))]
        try:
            while cases:
                for case in cases:
                    if not case.waits_for_steps:
                        self._at_work = case
                        case.take_turn()
                cases = [case for case in cases if not case.is_over]
                self._take_steps([case.steps for case in cases if case.steps is not None])
        finally:
            self._replays.clear()
            for case in cases:
                case.dismiss()
        return [results[number] for number in range(len(works))]

    def steps(self, plan: Plan, arrays: dict[str, Any]) -> "_BatchedSteps":
        """The steps of a plan, for one run; to be called from a function given to `run`.

        Args:
            plan: the plan of the run.
            arrays: the arrays of the plan on the device, by name. Those that a step works on are
                replaced by rows of common arrays.
        """
        assert self._at_work is not None, "no function of this batch is at work"
        return _BatchedSteps(self._at_work, plan, arrays, self.device)

    @property
    def idle_time(self) -> float:
        """Wall-clock time for which the case that asks has waited for steps of others [s]."""
        assert self._at_work is not None, "no function of this batch is at work"
        return self._at_work.idle_time

    @property
    def case_count(self) -> int:
        """Number of functions given to `run`."""
        return self._case_count

    @property
    def _is_on_gpu(self) -> bool:
        return bool(wp.get_device(self.device).is_cuda)

    def _take_steps(self, waiting: "Sequence[_BatchedSteps]") -> None:
        """Take as many steps as all runs of a group have left; keep the replays in use."""
        groups: dict[Hashable, list[_BatchedSteps]] = defaultdict(list)
        for run in waiting:
            groups[run.batch_key, run.left.start].append(run)
        replays = {}
        for group in groups.values():
            steps = min((run.left for run in group), key=len)
            for together in self._portions(group):
                replay = self._replays.get(together) or self._replay_of(together)
                begin = time.perf_counter()
                replay.replay(steps, self.threads)
                wp.synchronize_device(self.device)
                seconds = time.perf_counter() - begin
                for run in together:
                    run.note(len(steps), seconds / len(together))
                replays[together] = replay
        self._replays = replays

    def _portions(self, group: "Sequence[_BatchedSteps]") -> "Iterator[tuple[_BatchedSteps, ...]]":
        size = len(group)
        if not self._is_on_gpu:
            size = max(1, POINTS_IN_CACHE // max(1, group[0].plan.particle_count))
        for first in range(0, len(group), size):
            yield tuple(group[first : first + size])

    def _replay_of(self, together: "tuple[_BatchedSteps, ...]") -> Replay:
        plan, arrays = together[0].plan, together[0].arrays
        if len(together) > 1:
            # A GPU has a thread for each item. On a processor each thread makes views of the arrays
            # of a case, which takes time: one thread does all items.
            plan, arrays = batched_plan(
                [run.plan for run in together],
                [run.arrays for run in together],
                self.device,
                chunk_size=1 if self._is_on_gpu else None,
            )
        return Replay(plan, arrays, self.device)


class _BatchedSteps:
    """The steps of one run of a batch, taken together with those of other runs.

    Attributes:
        plan: the plan of the run.
        arrays: its arrays on the device, by name.
        batch_key: what the plan has in common with those it can be batched with.
        left: steps that are still to be taken before the case goes on.
    """

    def __init__(
        self, case: "_CaseThread", plan: Plan, arrays: dict[str, Any], device: str
    ) -> None:
        self.plan = plan
        self.arrays = arrays
        self.batch_key = batch_key(plan)
        self.left = range(0)
        self._busy_time = 0.0
        self._case = case
        self._alone = Replay(plan, arrays, device)

    def launch(self, launch: Launch) -> None:
        """Launch one kernel of the plan of this run alone, all of it, now."""
        self._alone.launch(launch)

    def replay(self, steps: range, threads: int) -> None:
        """Wait until the steps of these numbers have been taken.

        Args:
            steps: step numbers; they decide which steps are audited.
            threads: without effect; the threads of the batch take the steps.
        """
        self.left = steps
        begin, busy = time.perf_counter(), self._busy_time
        self._case.wait(self)
        waited = time.perf_counter() - begin
        self._case.idle_time += waited - (self._busy_time - busy)

    def note(self, step_count: int, seconds: float) -> None:
        """Note that steps have been taken, and this run's part of their time [s]."""
        self.left = self.left[step_count:]
        self._busy_time += seconds


class _CaseThread:
    """A function in a thread of its own, which works only when it has its turn.

    Attributes:
        steps: those that it waits for, or waited for last.
        is_over: whether the function has ended.
        idle_time: wall-clock time for which it has waited for steps of others [s].
    """

    def __init__(self, work: Callable[[], None]) -> None:
        self.steps: _BatchedSteps | None = None
        self.is_over = False
        self.idle_time = 0.0
        self._work = work
        self._error: BaseException | None = None
        self._is_dismissed = False
        self._turn = threading.Semaphore(0)
        self._turn_is_over = threading.Semaphore(0)
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    @property
    def waits_for_steps(self) -> bool:
        """Whether there are steps to take before its next turn."""
        return self.steps is not None and len(self.steps.left) > 0

    def take_turn(self) -> None:
        """Let the function work until it waits for steps or ends.

        Raises:
            BaseException: what the function raised.
        """
        self._turn.release()
        self._turn_is_over.acquire()
        if self._error is not None:
            raise self._error

    def wait(self, steps: _BatchedSteps) -> None:
        """End the turn until steps have been taken; called by the function itself."""
        self.steps = steps
        self._turn_is_over.release()
        self._turn.acquire()
        if self._is_dismissed:
            raise SystemExit

    def dismiss(self) -> None:
        """End the function where it waits; its `finally` clauses run."""
        if not self.is_over:
            self._is_dismissed = True
            self._turn.release()
            self._thread.join()

    def _serve(self) -> None:
        self._turn.acquire()
        try:
            if not self._is_dismissed:
                self._work()
        except BaseException as error:
            self._error = error
        finally:
            self.is_over = True
            self._turn_is_over.release()
