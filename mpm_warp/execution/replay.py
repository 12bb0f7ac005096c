"""A plan on a device. Each step is recorded once and then repeated without Python.

On a processor several threads replay the steps where that is faster than one. Each thread replays a
loop over its part of the steps; Python runs only between two calls of a replay. On a GPU each step
is one launch of a captured graph.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.execution.kernel_cache import load_kernels
from mpm_warp.execution.threads import LEFT, barrier, in_turn, run_together, share_of
from mpm_warp.kernel_types import functions_understood, kernels_kept
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import AUDIT_INTERVAL, Plan

UPDATES_PER_CALL = 5_000_000
"""Approximate particle updates in one call: a quarter of a second, which delays Ctrl-C."""
STEP, END, GOES_ON, AUDITED = range(4)
"""State of a loop: the step to take, the step at which to stop, and two conditions."""


@wp.kernel(module="mpm_warp.next_step", enable_backward=False)
def next_step(loop: wp.array[wp.int32]):
    """End a step of a loop; `loop` is the state of the loop, shape [4]."""
    step = loop[wp.static(STEP)] + 1
    loop[wp.static(STEP)] = step
    loop[wp.static(GOES_ON)] = int(step < loop[wp.static(END)])
    loop[wp.static(AUDITED)] = int(step % wp.static(AUDIT_INTERVAL) == 0)


class RecordedSteps:
    """The steps of a plan, recorded for a number of threads of a processor.

    `command` makes Warp's recorded command of a launch of the plan, or of a share of one.
    """

    def __init__(
        self, plan: Plan, command: Callable[[Launch], Any], threads: int, device: wp.Device
    ) -> None:
        # `command` is not kept: it belongs to the owner of this object, and a cycle of references
        # would keep the arrays of the run in memory after its end.
        self._threads = threads
        self._device = device
        if threads > 1:
            with kernels_kept():
                load_kernels(device, [barrier.module])
        self._share_count = plan.share_count
        self._steps_per_call = max(1, UPDATES_PER_CALL // max(1, plan.particle_count))
        # These arrays are kept here because recordings do not keep the arrays that they use.
        self._arrivals: Any = wp.zeros(threads, dtype=wp.int64, device=device)
        self._states: list[Any] = [
            wp.zeros(4, dtype=wp.int32, device=device) for _ in range(threads)
        ]
        self._written = [state.numpy() for state in self._states]
        self._graphs = [self._recorded_loop(plan, thread, command) for thread in range(threads)]

    def replay(self, steps: range) -> None:
        """Take the steps with these numbers; every 16th is audited.

        After an exception, in a thread or as by Ctrl-C, no further steps can be replayed.
        """
        length = self._steps_per_call
        calls = [steps[first : first + length] for first in range(0, len(steps), length)]

        def replay_part(thread: int) -> None:
            for call in calls:
                # The number within an interval, so that the state never overflows.
                first = call.start % AUDIT_INTERVAL
                self._written[thread][...] = first, first + len(call), True, first == 0
                wp.capture_launch(self._graphs[thread])

        def leave(thread: int) -> None:
            self._arrivals.numpy()[thread] = LEFT
            calls.clear()

        if self._threads == 1:
            replay_part(0)
        else:
            run_together(self._threads, replay_part, leave)

    def _recorded_loop(self, plan: Plan, thread: int, command: Callable[[Launch], Any]) -> Any:
        """Record a thread's part of a loop over steps."""
        state = self._states[thread]
        goes_on, audited = (state[place : place + 1] for place in (GOES_ON, AUDITED))

        def take(launches: Sequence[Launch]) -> None:
            # Barriers stand before and after launches that threads share.
            shared_next = [*(launch.is_shared for launch in launches[1:]), True]
            for launch, is_shared_next in zip(launches, shared_next, strict=True):
                for part in share_of(launch, thread, self._threads, self._share_count):
                    command(part).launch()
                if self._threads > 1 and (launch.is_shared or is_shared_next):
                    wp.launch(barrier, 1, [self._arrivals, thread], device=self._device)

        def take_step() -> None:
            plain, with_audit = partial(take, plan.step), partial(take, plan.audited_step)
            if plan.audited_step:
                wp.capture_if(audited, on_true=with_audit, on_false=plain)
            else:
                plain()
            wp.launch(next_step, 1, [state], device=self._device)

        with wp.ScopedCapture(device=self._device) as capture:
            wp.capture_while(goes_on, take_step)
        return capture.graph


FEWEST, MOST_TOGETHER = 16, 64
"""Least number of steps of a replay whose time is used to choose the number of threads; greatest
number of steps by several threads before the next choice."""
COST_OF_TRIALS = 0.05
"""Largest share of the run time that slower trials of several threads may take."""
WEIGHT = 0.25
"""Weight of the last replay in the mean time of a step; a single replay may be slow by chance."""


class DeviceRun:
    """The arrays of a plan on a device, and its launches, compiled and recorded.

    No other run may use the plan. `compile_time` is the wall-clock time to compile or load kernels
    [s].
    """

    @in_turn
    def __init__(self, plan: Plan, device: str) -> None:
        self.plan = plan
        self.arrays = {name: array.allocate(device) for name, array in plan.arrays.items()}
        self._device = wp.get_device(device)
        self._choice = ThreadChoice()
        self._seen: dict[str, NDArray[Any]] = {}
        start = time.perf_counter()
        self._load()
        self.compile_time = time.perf_counter() - start

    @in_turn
    def _load(self) -> None:
        """Compile or load the kernels and forget all recordings."""
        kernels = [*(launch.kernel for launch in self.plan.launches), next_step]
        with kernels_kept(), functions_understood():
            load_kernels(self._device, [kernel.module for kernel in kernels])
        self._recorded: dict[int, RecordedSteps] = {}  # by number of threads
        self._graphs: dict[bool, Any] = {}  # on a GPU: of a step, audited or not
        self._commands: dict[Launch, list[Any]] = {}

    def array(self, name: str) -> NDArray[Any]:
        """The present values of an array; on a processor, changes of them change the run.

        From a GPU they are copied once until the run goes on, because the watch reads them often.
        """
        if name not in self._seen:
            self._seen[name] = self.arrays[name].numpy()
        return self._seen[name]

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Set the values of an array, or one value everywhere."""
        if not self._device.is_cuda:
            self.array(name)[...] = values
            return
        own = np.empty_like(self.array(name))
        own[...] = values
        self._seen.pop(name)
        self.arrays[name].assign(own)

    def change_time_step(self, changed: Plan) -> None:
        """Go on with the launches of a plan that differs only in its time step."""
        self.plan.time_step = changed.time_step
        self.plan.step, self.plan.audited_step = changed.step, changed.audited_step
        self._load()

    @in_turn
    def launch(self, launch: Launch) -> None:
        """Launch one kernel of the plan now, with all its shares."""
        if self._device.is_cuda:
            for name in launch.arrays:
                self._seen.pop(name, None)
        if launch not in self._commands:
            shares = share_of(launch, 0, 1, self.plan.share_count)
            self._commands[launch] = [self._command(share) for share in shares]
        for command in self._commands[launch]:
            command.launch()

    @in_turn
    def replay(self, steps: range, threads: int) -> None:
        """Take the steps with these numbers on up to `threads` threads; every 16th is audited.

        A plan with fewer shares uses fewer threads. One thread alone works if several were slower,
        as on a busy machine.
        """
        if self._device.is_cuda:
            self._seen.clear()
            self._replay_one_by_one(steps)
            return
        wanted = min(threads, self.plan.share_count)
        while steps:
            threads, count = self._choice.choose(wanted, len(steps))
            self._replay_together(steps[:count], threads)
            steps = steps[count:]

    def _replay_together(self, steps: range, threads: int) -> None:
        """Take steps on this number of threads and note the time."""
        if threads not in self._recorded:
            self._recorded[threads] = RecordedSteps(self.plan, self._command, threads, self._device)
        start = time.perf_counter()
        try:
            self._recorded[threads].replay(steps)
        except BaseException:
            del self._recorded[threads]  # the barrier counts of its threads differ now
            raise
        self._choice.note(threads, len(steps), time.perf_counter() - start)

    def _replay_one_by_one(self, steps: range) -> None:
        """Launch the graph of a step for each step, on a GPU."""
        for step in steps:
            audited = step % AUDIT_INTERVAL == 0
            if audited not in self._graphs:
                with wp.ScopedCapture(device=self._device) as capture:
                    for launch in (audited and self.plan.audited_step) or self.plan.step:
                        self.launch(launch)
                self._graphs[audited] = capture.graph
            wp.capture_launch(self._graphs[audited])

    def _command(self, launch: Launch) -> Any:
        """Warp's recorded command of a launch, or of a share of one."""
        dim, arguments = launch.call(self.arrays)
        kinds = [argument.type for argument in launch.kernel.adj.args]
        arguments = [
            # Warp's code for a processor is slower with None than with an empty array.
            wp.empty((0,) * kind.ndim, dtype=kind.dtype, device=self._device)
            if argument is None
            else argument
            for kind, argument in zip(kinds, arguments, strict=True)
        ]
        return wp.launch(launch.kernel, dim, arguments, device=self._device, record_cmd=True)


class ThreadChoice:
    """Chooses between one thread and the number wanted, by the measured time of a step.

    Threads wait for each other several times in a step. A thread that loses its core to another
    process delays all, by up to a hundred times. So several threads are tried for a few steps.
    After a slower trial one thread works alone, until all trials are a small part of the time. The
    number of threads does not change a result, so the clock may choose it.
    """

    def __init__(self) -> None:
        self._step_time: dict[int, float] = {}  # mean time of a step [s], by number of threads
        self._pause = 0.0  # time for which one thread is to work alone [s]

    def choose(self, wanted: int, step_count: int) -> tuple[int, int]:
        """Threads of the next replay, `wanted` or 1, and its steps, at most `step_count`."""
        if wanted == 1:
            return 1, step_count
        if 1 not in self._step_time or self._pause > 0.0:
            return 1, min(step_count, MOST_TOGETHER)
        return wanted, min(step_count, MOST_TOGETHER if wanted in self._step_time else FEWEST)

    def note(self, threads: int, step_count: int, seconds: float) -> None:
        """Note the wall-clock time of a replay [s]."""
        if threads == 1:
            self._pause = max(0.0, self._pause - seconds)
        if step_count < FEWEST:
            return
        last = seconds / step_count
        mean = self._step_time.get(threads, last)
        self._step_time[threads] = mean + WEIGHT * (last - mean)
        if threads > 1 and self._step_time[threads] > self._step_time[1]:
            self._pause = (seconds - step_count * self._step_time[1]) / COST_OF_TRIALS
            del self._step_time[threads]  # measured afresh after the pause
