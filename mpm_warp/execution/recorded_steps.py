"""Steps recorded for threads of a processor: each thread replays a loop over its part of a step.

A recorded loop runs without Python. Python is called again only between two calls of a replay.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any

import warp as wp

from mpm_warp.execution.shares import CHUNKS_PER_THREAD, has_dynamic_chunks, share_of
from mpm_warp.execution.synchronisation import LEFT, make_barrier, make_claim_chunk
from mpm_warp.execution.worker_threads import worker_threads
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import AUDIT_INTERVAL, Plan

UPDATES_PER_CALL = 5_000_000
"""Particle updates of one call, about: a quarter of a second, for which Ctrl-C has to wait."""
STEP, END, GOES_ON, AUDITED = range(4)
"""State of a loop: the step to take, the step at which to stop, and two conditions."""


@functools.cache
def make_next_step() -> Any:
    """The kernel that ends a step of a loop; `loop` is the state of the loop, shape [4]."""

    @wp.kernel(module="mpm_warp.next_step", enable_backward=False)
    def next_step(loop: wp.array[wp.int32]):
        step = loop[wp.static(STEP)] + 1
        loop[wp.static(STEP)] = step
        loop[wp.static(GOES_ON)] = int(step < loop[wp.static(END)])
        loop[wp.static(AUDITED)] = int(step % wp.static(AUDIT_INTERVAL) == 0)

    return next_step


class RecordedLoop:
    """A recorded loop over any number of steps: what one thread does of them.

    Args:
        step: launches what the thread does of a step.
        audited_step: the same of an audited step; None where no step is audited.
        device: the processor.
    """

    def __init__(
        self,
        step: Callable[[], None],
        audited_step: Callable[[], None] | None,
        device: wp.Device,
    ) -> None:
        self._device_state: Any = wp.zeros(4, dtype=wp.int32, device=device)
        self._state = self._device_state.numpy()
        goes_on, audited = (self._device_state[it : it + 1] for it in (GOES_ON, AUDITED))

        def take_step() -> None:
            if audited_step is None:
                step()
            else:
                wp.capture_if(audited, on_true=audited_step, on_false=step)
            wp.launch(make_next_step(), 1, [self._device_state], device=device)

        with wp.ScopedCapture(device=device) as capture:
            wp.capture_while(goes_on, take_step)
        self._graph = capture.graph

    def replay(self, steps: range) -> None:
        """Take the steps of these numbers, at least one."""
        self._state[...] = steps.start, steps.stop, True, steps.start % AUDIT_INTERVAL == 0
        wp.capture_launch(self._graph)


class RecordedSteps:
    """The steps of a plan, recorded for a number of threads.

    Args:
        plan: the plan.
        command: gives Warp's recorded command of a launch of the plan, or of a share of one.
        threads: number of threads, >= 1.
        device: the processor.
    """

    def __init__(
        self, plan: Plan, command: Callable[[Launch], Any], threads: int, device: wp.Device
    ) -> None:
        # `command` is not kept: it belongs to the owner of this object, and a cycle of references
        # would keep the arrays of the run in memory after its end.
        self._threads = threads
        self._device = device
        self._share_count = plan.share_count
        self._steps_per_call = max(1, UPDATES_PER_CALL // max(1, plan.particle_count))
        # These arrays are kept here because recordings do not keep the arrays that they use.
        self._arrivals: Any = wp.zeros(threads, dtype=wp.int64, device=device)
        self._claims: dict[Launch, Any] = {
            launch: wp.zeros(CHUNKS_PER_THREAD * threads, dtype=wp.int64, device=device)
            for launch in plan.launches
            if threads > 1 and has_dynamic_chunks(launch)
        }
        self._claimed: list[Any] = [
            wp.zeros(1, dtype=wp.int32, device=device) for _ in range(threads)
        ]
        self._loops = [self._record(plan, thread, command) for thread in range(threads)]

    def replay(self, steps: range) -> None:
        """Take the steps of these numbers, which decide which steps are audited.

        Raises:
            BaseException: the first that a thread raised, or one that reached the caller, as by
                Ctrl-C. The steps can then not be replayed again.
        """
        length = self._steps_per_call
        calls = [steps[first : first + length] for first in range(0, len(steps), length)]

        def replay_part(thread: int) -> None:
            for call in calls:
                self._loops[thread].replay(call)

        def leave(thread: int) -> None:
            self._arrivals.numpy()[thread] = LEFT
            calls.clear()

        if self._threads == 1:
            replay_part(0)
        else:
            worker_threads(self._threads).run(replay_part, leave)

    def _record(self, plan: Plan, thread: int, command: Callable[[Launch], Any]) -> RecordedLoop:
        """Record what a thread does of a step, with barriers before and after shared launches."""

        def part_of(launches: Sequence[Launch]) -> Callable[[], None]:
            shared_next = [*(launch.is_shared for launch in launches[1:]), True]

            def launch_all() -> None:
                for launch, is_shared_next in zip(launches, shared_next, strict=True):
                    self._launch_share(launch, thread, command)
                    if self._threads > 1 and (launch.is_shared or is_shared_next):
                        arguments = [self._arrivals, thread]
                        wp.launch(make_barrier(), 1, arguments, device=self._device)

            return launch_all

        audited_step = part_of(plan.audited_step) if plan.audited_step else None
        return RecordedLoop(part_of(plan.step), audited_step, self._device)

    def _launch_share(self, launch: Launch, thread: int, command: Callable[[Launch], Any]) -> None:
        claimed = self._claimed[thread]
        share = share_of(launch, thread, self._threads, self._share_count)
        for part in share.static:
            command(part).launch()
        for chunk, part in share.dynamic.items():
            arguments = [chunk, thread, self._arrivals, self._claims[launch], claimed]
            wp.launch(make_claim_chunk(), 1, arguments, device=self._device)
            wp.capture_if(claimed, on_true=command(part).launch)
