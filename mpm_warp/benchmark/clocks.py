"""Clocks on one thread of the processor: the time between steps, and the time of every stage."""

import functools
import time
from dataclasses import dataclass, replace
from typing import Any

import warp as wp

from mpm_warp.execution.execution import Execution, Steps
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.simulation import Simulation


@functools.cache
def make_clock_stamp() -> Any:
    """The kernel that adds the ticks of the clock since its last launch to those of an interval.

    Kernel arguments:
        interval: number of the interval that ends now.
        latest: time of the last launch [ticks], shape [1].
        ticks: duration of each interval, summed up [ticks], shape [intervals].
    """

    @wp.func_native("""
    #if defined(__aarch64__)
        wp::int64 now;
        asm volatile("mrs %0, cntvct_el0" : "=r"(now));
    #else
        const wp::int64 now = __builtin_readcyclecounter();
    #endif
        ticks.data[interval] += now - latest.data[0];
        latest.data[0] = now;
    """)
    def add_ticks(interval: int, latest: wp.array[wp.int64], ticks: wp.array[wp.int64]): ...

    @wp.kernel(module="mpm_warp.clock_stamp", enable_backward=False)
    def clock_stamp(interval: int, latest: wp.array[wp.int64], ticks: wp.array[wp.int64]):
        add_ticks(interval, latest, ticks)

    return clock_stamp


@dataclass
class ClockedExecution(Execution):
    """An execution of one run on one thread of the processor that measures time within steps.

    A clock is read at the begin and at the end of every step.
    """

    def steps(self, plan: Plan, arrays: dict[str, Any]) -> Steps:
        """The steps of a plan, with the clock.

        Args:
            plan: the plan of the run.
            arrays: the arrays of the plan on the device, by name.
        """
        self._latest: Any = wp.zeros(1, dtype=wp.int64, device=self.device)
        self._ticks: Any = wp.zeros(2, dtype=wp.int64, device=self.device)
        clock = {"clock.latest": self._latest, "clock.ticks": self._ticks}
        outside, within = (
            Launch(kernel=make_clock_stamp(), dim=(1,), arguments=(interval, *clock))
            for interval in range(2)
        )
        clocked = replace(
            plan,
            step=[outside, *plan.step, within],
            audited_step=plan.audited_step and [outside, *plan.audited_step, within],
        )
        return super().steps(clocked, arrays | clock)

    def start(self) -> None:
        """Start the clock anew."""
        wp.launch(make_clock_stamp(), 1, [0, self._latest, self._ticks], device=self.device)
        self._ticks.zero_()

    @property
    def share_of_steps(self) -> float:
        """Fraction of the time since the start that was within steps."""
        outside, within = self._ticks.numpy().tolist()
        return float(within / (outside + within))


@dataclass(frozen=True)
class StepTimes:
    """Where the processor's time for a step goes, a mean over several steps.

    Attributes:
        stages: time of each launch, by the name of its kernel [s].
        launching: time to launch them all, which is a part of the above [s].
    """

    stages: dict[str, float]
    launching: float


class StageClock:
    """A clock between the launches of a step; time of other processes does not count.

    Args:
        simulation: a run on one thread of the processor.
    """

    def __init__(self, simulation: Simulation) -> None:
        step = simulation.plan.step
        self._names = [launch.name for launch in step]
        share_count = simulation.plan.share_count
        self._launch_count = sum(share_count if launch.adds_up else 1 for launch in step)
        self._latest: Any = wp.zeros(1, dtype=wp.int64, device="cpu")
        self._ticks: Any = wp.zeros(len(step) + 2, dtype=wp.int64, device="cpu")
        with wp.ScopedCapture(device="cpu") as capture:
            self._stamp(len(step))  # what lies between two steps
            for interval, launch in enumerate(step):
                simulation.launch(launch)
                self._stamp(interval)
            self._stamp(len(step) + 1)  # a launch of nothing but the clock
        self._graph = capture.graph

    def time_steps(self, step_count: int) -> StepTimes:
        """Take steps, which the run does not count, and measure where their time goes.

        Args:
            step_count: number of steps, >= 1.
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
        arguments = [interval, self._latest, self._ticks]
        wp.launch(make_clock_stamp(), 1, arguments, device="cpu")
