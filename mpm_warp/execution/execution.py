"""Where a run is computed: by itself, or in a batch of many, which is meant to fill a GPU.

Each run of a batch is an ordinary function, a case, in a thread of its own. One thread at a time is
at work. A case that is to take steps waits until all other cases wait too, or have ended; then the
caller of the batch takes the steps of all: on a GPU each run's on a stream of its own, at the same
time.
"""

import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TypeVar

import warp as wp

from mpm_warp.arguments import FROM_ONE, check_kind, check_known, check_whole
from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.execution.replay import DeviceRun
from mpm_warp.plan.plan import Plan

Result = TypeVar("Result")


def device_names() -> list[str]:
    """Names of the devices of this machine: "cpu", and "cuda:0" and so on for GPUs."""
    return [str(device.alias) for device in wp.get_devices()]


@dataclass
class Execution:
    """Where a run is computed.

    The number of threads of a processor does not change any bit of the result. A GPU adds up sums
    in an order of its own.

    Attributes:
        device: "cpu", or the name that Warp gives to a GPU, for example "cuda:0".
        threads: threads of the processor, one of `mpm_warp.execution.THREAD_COUNTS`. The number may
            change while a run goes on. A GPU ignores it.
        case_count: number of runs that are computed together.

    Raises:
        SceneError: there is no such device here, or the number of threads is another.
    """

    device: str = "cpu"
    threads: int = 1
    case_count: int = field(default=1, init=False)

    def __post_init__(self) -> None:
        check_kind("device", self.device, str)
        check_whole("threads", self.threads, FROM_ONE)
        check_known("device", self.device, device_names())
        check_known("threads", self.threads, THREAD_COUNTS)

    def begin(self, plan: Plan) -> DeviceRun:
        """A run of a plan on the device."""
        return DeviceRun(plan, self.device)

    @property
    def idle_time(self) -> float:
        """Wall-clock time for which the run has waited for other runs [s]."""
        return 0.0


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
    _waiting: "list[_BatchedRun]" = field(default_factory=list, init=False)
    _error: BaseException | None = field(default=None, init=False)
    _is_given_up: bool = field(default=False, init=False)
    _idle: _IdleTime = field(default_factory=_IdleTime, init=False)

    def run(self, works: Sequence[Callable[[], Result]]) -> list[Result]:
        """Run functions, one for each case, that simulate with this; gives what each returned.

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
                    self._is_given_up, self._waiting = True, []  # where a case still waits
                    self._turn.notify_all()
        return [result.result() for result in results]

    def begin(self, plan: Plan) -> DeviceRun:
        """A run of a plan on the device; to be called from a function given to `run`."""
        return _BatchedRun(self, plan)

    @property
    def idle_time(self) -> float:
        """Wall-clock time for which the case that asks has waited for steps of others [s]."""
        return self._idle.seconds

    def wait_for(self, run: "_BatchedRun") -> None:
        """Let the other cases work until the steps of a run have been taken; asked by its case."""
        begin = time.perf_counter()
        self._waiting.append(run)
        self._at_work -= 1
        self._turn.notify_all()
        self._turn.wait_for(lambda: self._is_given_up or not run.left)
        if self._is_given_up:
            raise SystemExit
        self._idle.seconds += time.perf_counter() - begin - run.busy_time

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
            wp.synchronize_device(self.device)  # before runs go on on streams of their own
            for run in self._waiting:
                run.take(self.threads)
            begin = time.perf_counter()
            wp.synchronize_device(self.device)
            for run in self._waiting:
                run.busy_time += (time.perf_counter() - begin) / len(self._waiting)
            self._at_work, self._waiting = len(self._waiting), []
            self._turn.notify_all()


class _BatchedRun(DeviceRun):
    """One run of a batch, which waits while its steps are taken.

    Attributes:
        left: steps that are to be taken before the case goes on.
        busy_time: this run's part of the time of the last steps [s].
    """

    def __init__(self, batch: Batch, plan: Plan) -> None:
        on_gpu = wp.get_device(batch.device).is_cuda
        super().__init__(plan, batch.device, wp.Stream(batch.device) if on_gpu else None)
        self.left = range(0)
        self.busy_time = 0.0
        self._batch = batch

    def replay(self, steps: range, threads: int) -> None:
        """Wait until these steps, at least one, have been taken, by the threads of the batch."""
        self.left = steps
        self._batch.wait_for(self)

    def take(self, threads: int) -> None:
        """Take the steps that are left; on a GPU they may go on when this returns."""
        begin = time.perf_counter()
        super().replay(self.left, threads)
        self.left, self.busy_time = range(0), time.perf_counter() - begin
