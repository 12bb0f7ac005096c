"""How fast a run is, stage by stage, beside what the machine gives to any kernel."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.execution.execution import Execution, Steps
from mpm_warp.benchmark.clock_kernels import (
    CHAINS,
    DIVISION_CHAINS,
    make_arithmetic,
    make_division,
    make_stamp,
    make_streaming,
)
from mpm_warp.plan.plan import Launch, StepPlan
from mpm_warp.simulation import TimeLoop

REPEATS = 5


@dataclass(frozen=True)
class Yardsticks:
    """What a bare loop reaches on one thread, the best of a few times.

    Attributes:
        streaming: bytes read and written per second [byte/s].
        arithmetic: multiplications and additions in double precision per second [1/s].
        division: divisions in double precision per second [1/s].
    """

    streaming: float
    arithmetic: float
    division: float


@dataclass(frozen=True)
class StepTimes:
    """Where the processor's time for a step went, on average over a few [s].

    Attributes:
        stages: each launch, by the name of its kernel.
        launching: to launch them all, which is part of the above.
    """

    stages: dict[str, float]
    launching: float


@dataclass
class ClockedExecution(Execution):
    """An execution of one run, on one thread of the processor, that tells how busy its kernels are.

    A clock stands at the begin and at the end of every step.
    """

    def steps(self, plan: StepPlan, arrays: dict[str, Any]) -> Steps:
        """See `Execution`."""
        self._latest, self._ticks = (
            wp.zeros(count, dtype=wp.int64, device=self.device) for count in (1, 2)
        )
        clock = {"clock.latest": self._latest, "clock.ticks": self._ticks}
        outside, within = (
            Launch(kernel=make_stamp(), dim=(1,), arguments=(interval, *clock))
            for interval in range(2)
        )
        clocked = replace(
            plan,
            step=[outside, *plan.step, within],
            audited_step=plan.audited_step and [outside, *plan.audited_step, within],
        )
        return super().steps(clocked, arrays | clock)

    def start(self) -> None:
        """Start the clock."""
        wp.launch(make_stamp(), 1, [0, self._latest, self._ticks], device=self.device)
        self._ticks.zero_()

    @property
    def share_of_steps(self) -> float:
        """Share of the time since the start that the launches of steps took."""
        outside, within = self._ticks.numpy().tolist()
        return float(within / (outside + within))


class StageClock:
    """A clock between the launches of a step, on one thread; other processes do not count.

    Args:
        loop: a run on the processor.
    """

    def __init__(self, loop: TimeLoop) -> None:
        step = loop.plan.step
        self._names = [launch.name for launch in step]
        adds_up = [launch.adds_up for launch in step]
        self._launch_count = sum(loop.plan.share_count if it else 1 for it in adds_up)
        self._latest = wp.zeros(1, dtype=wp.int64, device="cpu")
        self._ticks = wp.zeros(len(step) + 2, dtype=wp.int64, device="cpu")
        with wp.ScopedCapture(device="cpu") as capture:
            self._stamp(len(step))  # what lies between two steps
            for interval, launch in enumerate(step):
                loop.launch(launch)
                self._stamp(interval)
            self._stamp(len(step) + 1)  # a launch of nothing but the clock
        self._graph = capture.graph

    def time_steps(self, step_count: int) -> StepTimes:
        """Take steps, which the run does not know of, and tell where their time goes.

        Args:
            step_count: steps to take, >= 1.
        """
        wp.capture_launch(self._graph)  # warm
        self._ticks.zero_()
        start = time.thread_time()
        for _ in range(step_count):
            wp.capture_launch(self._graph)
        seconds = time.thread_time() - start
        ticks = self._ticks.numpy()
        *intervals, _, clock = seconds / step_count * ticks / ticks.sum()
        return StepTimes(
            stages={
                name: float(interval - clock)
                for name, interval in zip(self._names, intervals, strict=True)
            },
            launching=float(self._launch_count * clock),
        )

    def _stamp(self, interval: int) -> None:
        wp.launch(make_stamp(), 1, [interval, self._latest, self._ticks], device="cpu")


def yardsticks() -> Yardsticks:
    """Measure the bare loops on the processor."""
    count = 4_000_000  # far beyond any cache
    x, y = (wp.zeros(count, dtype=wp.float64, device="cpu") for _ in range(2))
    streaming = _least_time(lambda: wp.launch(make_streaming(), count, [x, y], device="cpu"))
    threads, length = 250, 1000
    sums = wp.zeros(threads, dtype=CHAINS, device="cpu")
    quotients = wp.ones(threads, dtype=DIVISION_CHAINS, device="cpu")
    arithmetic = _least_time(
        lambda: wp.launch(make_arithmetic(), threads, [length, 0.5, 1.0, sums], device="cpu")
    )
    division = _least_time(
        lambda: wp.launch(make_division(), threads, [length, 1.5, quotients], device="cpu")
    )
    return Yardsticks(
        streaming=3 * 8 * count / streaming,
        arithmetic=2 * CHAINS._length_ * threads * length / arithmetic,
        division=DIVISION_CHAINS._length_ * threads * length / division,
    )


def _least_time(work: Callable[[], object]) -> float:
    work()  # warm
    samples = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        work()
        samples.append(time.perf_counter() - start)
    return float(np.min(samples))
