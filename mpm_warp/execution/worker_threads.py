"""Threads of a processor that replay the steps of a plan together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import warp as wp

from mpm_warp.execution.chunks import make_claim
from mpm_warp.execution.next_step import AUDIT_INTERVAL, AUDITED, GOES_ON, make_next_step
from mpm_warp.execution.barrier import LEFT, make_rendezvous
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.execution.shares import PIECES, has_open_pieces, share_of
from mpm_warp.execution.team import team_of

LONGEST_CALL = 5_000_000
"""Particle updates, about, of one call, which Ctrl-C has to wait for: a quarter of a second."""


class Ensemble:
    """So many threads, and what each of them replays.

    Args:
        plan: whose steps they take.
        command: gives what launches one of the plan, or a share of it.
        threads: how many, >= 1.
        device: the processor.
    """

    def __init__(
        self, plan: Plan, command: Callable[[Launch], Any], threads: int, device: wp.Device
    ) -> None:
        # The command is not kept: it is of whom keeps this, and neither could be let go then.
        self._threads = threads
        self._device = device
        self._share_count = plan.share_count
        self._longest = max(1, LONGEST_CALL // max(1, plan.particle_count))
        # Recordings do not keep the arrays that they refer to.
        self._arrivals: Any = wp.zeros(threads, dtype=wp.int64, device=device)
        self._claims: dict[Launch, Any] = {
            launch: wp.zeros(PIECES * threads, dtype=wp.int64, device=device)
            for launch in plan.launches
            if threads > 1 and has_open_pieces(launch)
        }
        self._mine = [wp.zeros(1, dtype=int, device=device) for _ in range(threads)]
        self._loops = [self._recorded(plan, thread, command) for thread in range(threads)]

    def play(self, steps: range) -> None:
        """Take steps of these numbers, which tell which of them are audited.

        Raises:
            BaseException: the first of a thread, or one that reached the caller, as by Ctrl-C;
                the threads no longer meet then.
        """
        longest = self._longest
        calls = [steps[first : first + longest] for first in range(0, len(steps), longest)]

        def play_part(thread: int) -> None:
            for call in calls:
                self._loops[thread].play(call)

        def leave(thread: int) -> None:
            self._arrivals.numpy()[thread] = LEFT
            calls.clear()

        if self._threads == 1:
            play_part(0)
        else:
            team_of(self._threads).run(play_part, leave)

    def _recorded(self, plan: Plan, thread: int, command: Callable[[Launch], Any]) -> _Loop:
        def taker(launches: Sequence[Launch]) -> Callable[[], None]:
            shared_next = [*(launch.is_shared for launch in launches[1:]), True]

            def take() -> None:
                for launch, others_follow in zip(launches, shared_next, strict=True):
                    self._launch(launch, thread, command)
                    if self._threads > 1 and (launch.is_shared or others_follow):
                        arguments = [self._arrivals, thread]
                        wp.launch(make_rendezvous(), 1, arguments, device=self._device)

            return take

        audited_step = taker(plan.audited_step) if plan.audited_step else None
        return _Loop(taker(plan.step), audited_step, self._device)

    def _launch(self, launch: Launch, thread: int, command: Callable[[Launch], Any]) -> None:
        """What a thread does of a launch."""
        mine = self._mine[thread]
        share = share_of(launch, thread, self._threads, self._share_count)
        for part in share.own:
            command(part).launch()
        for piece, part in share.open.items():
            arguments = [piece, thread, self._arrivals, self._claims[launch], mine]
            wp.launch(make_claim(), 1, arguments, device=self._device)
            wp.capture_if(mine, on_true=command(part).launch)


class _Loop:
    """A recording of steps, as many as are wanted: what one thread does of them.

    Args:
        step: launches a step.
        audited_step: launches an audited one; None where all are plain.
        device: the processor.
    """

    def __init__(
        self,
        step: Callable[[], None],
        audited_step: Callable[[], None] | None,
        device: wp.Device,
    ) -> None:
        self._device_state = wp.zeros(4, dtype=int, device=device)
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

    def play(self, steps: range) -> None:
        """Take steps, at least one."""
        self._state[...] = steps.start, steps.stop, True, steps.start % AUDIT_INTERVAL == 0
        wp.capture_launch(self._graph)
