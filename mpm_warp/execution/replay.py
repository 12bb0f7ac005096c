"""Replay of the steps of a plan: each step is recorded once and then repeated without Python.

On a processor the steps are replayed by as many threads as are faster than one. On a GPU each step
is one launch of a captured graph.
"""

from __future__ import annotations

import operator
import time
from collections.abc import Mapping
from typing import Any

import warp as wp

from mpm_warp.execution.recorded_steps import RecordedSteps, make_next_step
from mpm_warp.execution.shares import share_of
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import AUDIT_INTERVAL, Plan

LEAST_STEPS = 16
"""Steps of a replay from which on its time counts for the choice of the number of threads."""
PAUSE = 300
"""Steps on one thread before several threads are tried again."""
WEIGHT = 0.25
"""Weight of the last replay in the mean time of a step: a single replay may be late by chance."""


class Replay:
    """The launches of a plan on a device, recorded.

    Args:
        plan: the plan; its kernels are compiled here.
        arrays: the arrays of the plan on the device, by name.
        device: name of the device.
    """

    def __init__(self, plan: Plan, arrays: Mapping[str, Any], device: str) -> None:
        self._plan = plan
        self._arrays = arrays
        self._device = wp.get_device(device)
        self._choice = ThreadChoice()
        kernels = [*(launch.kernel for launch in plan.launches), make_next_step()]
        wp.force_load(self._device, modules=[kernel.module for kernel in kernels])
        self._recorded: dict[int, RecordedSteps] = {}  # by number of threads
        self._graphs: dict[bool, Any] = {}  # on a GPU: of a step, audited or not
        self._commands: dict[Launch, tuple[list[Any], list[Any]]] = {}

    def launch(self, launch: Launch) -> None:
        """Launch one kernel of the plan, all of it, now."""
        # A batch may have replaced arrays since the last time.
        arrays = [self._arrays[name] for name in launch.arrays]
        recorded_with, commands = self._commands.get(launch, ([], []))
        if not commands or any(map(operator.is_not, recorded_with, arrays)):
            shares = share_of(launch, 0, 1, self._plan.share_count).static
            commands = [self._command(share) for share in shares]
            self._commands[launch] = arrays, commands
        for command in commands:
            command.launch()

    def replay(self, steps: range, threads: int) -> None:
        """Take steps.

        Args:
            steps: step numbers; they decide which steps are audited.
            threads: threads of the processor, >= 1. Fewer are used where the plan has fewer shares,
                and only one where several were slower, as on a busy machine.
        """
        if self._device.is_cuda:
            self._replay_one_by_one(steps)
            return
        threads = self._choice.choose(min(threads, self._plan.share_count))
        if threads not in self._recorded:
            self._recorded[threads] = RecordedSteps(
                self._plan, self._command, threads, self._device
            )
        start = time.perf_counter()
        try:
            self._recorded[threads].replay(steps)
        except BaseException:
            del self._recorded[threads]  # its threads do not meet at barriers any more
            raise
        self._choice.note(threads, len(steps), time.perf_counter() - start)

    def _replay_one_by_one(self, steps: range) -> None:
        """Launch the graph of a step for each step, as on a GPU."""
        for step in steps:
            wp.capture_launch(self._graph(step % AUDIT_INTERVAL == 0))

    def _graph(self, audited: bool) -> Any:
        if audited not in self._graphs:
            with wp.ScopedCapture(device=self._device) as capture:
                for launch in (audited and self._plan.audited_step) or self._plan.step:
                    self.launch(launch)
            self._graphs[audited] = capture.graph
        return self._graphs[audited]

    def _command(self, launch: Launch) -> Any:
        """Warp's recorded command of a launch, or of a share of one."""
        dim, arguments = launch.call(self._arrays)
        kinds = [argument.type for argument in launch.kernel.adj.args]
        arguments = [
            # Warp's code for a processor is slower where an array is None: an empty one stands in.
            wp.empty((0,) * kind.ndim, dtype=kind.dtype, device=self._device)
            if argument is None
            else argument
            for kind, argument in zip(kinds, arguments, strict=True)
        ]
        return wp.launch(launch.kernel, dim, arguments, device=self._device, record_cmd=True)


class ThreadChoice:
    """Chooses between one thread and as many as are wanted, by the measured time of a step.

    Threads wait for each other several times in a step, so one that loses its core to another
    process delays all. The number of threads does not change a result: the clock may choose it.
    """

    def __init__(self) -> None:
        self._step_time: dict[int, float] = {}  # mean time of a step [s], by number of threads
        self._pause = 0

    def choose(self, wanted: int) -> int:
        """Number of threads of the next replay: `wanted`, or 1."""
        return 1 if 1 not in self._step_time or self._pause > 0 else wanted

    def note(self, threads: int, step_count: int, seconds: float) -> None:
        """Note the time of a replay.

        Args:
            threads: number of threads that took the steps.
            step_count: number of steps.
            seconds: wall-clock time of all of them [s].
        """
        if threads == 1:
            self._pause = max(0, self._pause - step_count)
        if step_count < LEAST_STEPS:
            return
        last = seconds / step_count
        mean = self._step_time.get(threads, last)
        self._step_time[threads] = mean + WEIGHT * (last - mean)
        if threads > 1 and self._step_time[threads] > self._step_time[1]:
            self._pause = PAUSE
            del self._step_time[threads]  # measured afresh after the pause
