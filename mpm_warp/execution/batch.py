"""Batch: many runs at the same time, step by step; on a GPU runs of one batch key share launches.

Each run is an ordinary function, a case, in a thread of its own. One thread at a time is at work. A
case that is to take steps waits until all other cases wait too, or have ended; then the caller of
the batch takes the steps of all. On a processor each run takes its steps by launches of its own:
common ones are no faster there.
"""

import threading
import time
from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, TypeVar

import warp as wp

from mpm_warp.execution.batched import batch_key, batched_plan
from mpm_warp.execution.execution import Execution
from mpm_warp.execution.replay import Replay
from mpm_warp.plan.plan import Plan

Result = TypeVar("Result")


class _IdleTime(threading.local):
    """What each thread has of its own: for how long it has waited for steps of others [s]."""

    seconds = 0.0


@dataclass
class Batch(Execution):
    """An execution that many runs share.

    On a processor the result of a run does not depend on the other runs of the batch, not by a bit.
    """

    _turn: threading.Condition = field(default_factory=threading.Condition, init=False)
    _at_work: int = field(default=0, init=False)  # cases that neither wait nor have ended
    _waiting: "list[_BatchedSteps]" = field(default_factory=list, init=False)
    _error: BaseException | None = field(default=None, init=False)
    _is_given_up: bool = field(default=False, init=False)
    _idle: _IdleTime = field(default_factory=_IdleTime, init=False)
    _replays: "dict[tuple[_BatchedSteps, ...], Replay]" = field(default_factory=dict, init=False)

    def run(self, works: Sequence[Callable[[], Result]]) -> list[Result]:
        """Run functions that simulate with this execution.

        Args:
            works: the functions, one for each case.

        Returns:
            What each function returned.

        Raises:
            BaseException: the first that a function raised; the other functions are then ended.
        """
        self.case_count = self._at_work = len(works)
        self._error, self._is_given_up = None, False
        with ThreadPoolExecutor(max(1, len(works))) as pool:
            results = [pool.submit(self._work, work) for work in works]
            with self._turn:
                try:
                    self._take_steps_of_all()
                finally:
                    self._is_given_up = True  # where a case still waits
                    self._waiting, self._replays = [], {}
                    self._turn.notify_all()
        return [result.result() for result in results]

    def steps(self, plan: Plan, arrays: dict[str, Any]) -> "_BatchedSteps":
        """The steps of a plan, for one run; to be called from a function given to `run`.

        Args:
            plan: the plan of the run.
            arrays: the arrays of the plan on the device, by name. On a GPU those that a step works
                on are replaced by rows of common arrays.
        """
        return _BatchedSteps(self, plan, arrays)

    @property
    def idle_time(self) -> float:
        """Wall-clock time for which the case that asks has waited for steps of others [s]."""
        return self._idle.seconds

    def wait_for(self, run: "_BatchedSteps") -> None:
        """Let the other cases work until the steps of a run have been taken; asked by its case."""
        begin, busy = time.perf_counter(), run.busy_time
        self._waiting.append(run)
        self._at_work -= 1
        self._turn.notify_all()
        self._turn.wait_for(lambda: self._is_given_up or not run.left)
        if self._is_given_up:
            raise SystemExit
        self._idle.seconds += time.perf_counter() - begin - (run.busy_time - busy)

    def _work(self, work: Callable[[], Result]) -> Result:
        with self._turn:
            self._idle.seconds = 0.0
            if self._is_given_up:
                raise SystemExit
            try:
                return work()
            except BaseException as error:
                self._error = self._error or error
                raise
            finally:
                self._at_work -= 1
                self._turn.notify_all()

    def _take_steps_of_all(self) -> None:
        """Take steps whenever all cases wait for some, until all have ended or one has raised."""
        while True:
            self._turn.wait_for(lambda: self._error is not None or self._at_work == 0)
            if self._error is not None:
                raise self._error
            if not self._waiting:
                return
            self._take_steps()
            waiting = [run for run in self._waiting if run.left]
            self._at_work, self._waiting = len(self._waiting) - len(waiting), waiting
            self._turn.notify_all()

    def _take_steps(self) -> None:
        """Take as many steps as all runs of a group have left; keep the replays in use."""
        replays = {}
        for group in self._groups():
            steps = min((run.left for run in group), key=len)
            replay = replays[group] = self._replays.get(group) or self._replay_of(group)
            begin = time.perf_counter()
            replay.replay(steps, self.threads)
            wp.synchronize_device(self.device)
            seconds = time.perf_counter() - begin
            for run in group:
                run.left = run.left[len(steps) :]
                run.busy_time += seconds / len(group)
        self._replays = replays

    def _groups(self) -> "list[tuple[_BatchedSteps, ...]]":
        """Runs that take their next steps by common launches."""
        if not self._is_on_gpu:
            return [(run,) for run in self._waiting]
        groups: dict[Hashable, list[_BatchedSteps]] = defaultdict(list)
        for run in self._waiting:
            groups[run.batch_key, run.left.start].append(run)
        return [tuple(group) for group in groups.values()]

    def _replay_of(self, group: "tuple[_BatchedSteps, ...]") -> Replay:
        plan, arrays = group[0].plan, group[0].arrays
        if len(group) > 1:
            plans, of_runs = [run.plan for run in group], [run.arrays for run in group]
            plan, arrays = batched_plan(plans, of_runs, self.device)
        return Replay(plan, arrays, self.device)

    @property
    def _is_on_gpu(self) -> bool:
        return bool(wp.get_device(self.device).is_cuda)


class _BatchedSteps(Replay):
    """The steps of one run of a batch, which waits while they are taken.

    Attributes:
        plan: the plan of the run.
        arrays: its arrays on the device, by name.
        batch_key: what the plan has in common with those it can be batched with.
        left: steps that are still to be taken before the case goes on.
        busy_time: this run's part of the time of the steps taken [s].
    """

    def __init__(self, batch: Batch, plan: Plan, arrays: dict[str, Any]) -> None:
        super().__init__(plan, arrays, batch.device)
        self.plan = plan
        self.arrays = arrays
        self.batch_key = batch_key(plan)
        self.left = range(0)
        self.busy_time = 0.0
        self._batch = batch

    def replay(self, steps: range, threads: int) -> None:
        """Wait until the steps of these numbers, at least one, have been taken.

        Args:
            steps: step numbers; they decide which steps are audited.
            threads: without effect; the threads of the batch take the steps.
        """
        self.left = steps
        self._batch.wait_for(self)
