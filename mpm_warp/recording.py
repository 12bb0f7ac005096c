"""The steps of a plan, recorded once and replayed: Python takes no part in them."""

from __future__ import annotations

import operator
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.kernels.next_step import AUDIT_INTERVAL, AUDITED, GOES_ON, make_next_step
from mpm_warp.kernels.rendezvous import LEFT, make_rendezvous
from mpm_warp.pace import Pace
from mpm_warp.plan import Launch, StepPlan
from mpm_warp.team import team_of

LONGEST_CALL = 5_000_000
"""Particle updates, about, of one call, which Ctrl-C has to wait for: a quarter of a second."""


class _Loop:
    """A recording of steps on a processor, as many as are wanted: what one thread does of them.

    Args:
        step: launches a step.
        audited_step: launches an audited one; None where all are plain.
        device: the processor.
    """

    def __init__(
        self, step: Callable[[], None], audited_step: Callable[[], None] | None, device: wp.Device
    ) -> None:
        # A recording does not keep the arrays that it refers to.
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


@dataclass(frozen=True)
class _Ensemble:
    """What so many threads replay together.

    Attributes:
        loops: one of each thread.
        arrivals: where they meet.
    """

    loops: list[_Loop]
    arrivals: Any


class Player:
    """Launches of a plan on a device.

    Args:
        plan: whose launches they are.
        arrays: its arrays on the device, by name.
        device: where they are.
    """

    def __init__(self, plan: StepPlan, arrays: Mapping[str, Any], device: str) -> None:
        self._plan = plan
        self._arrays = arrays
        self._device = wp.get_device(device)
        self._pace = Pace()
        wp.force_load(self._device, modules=[launch.kernel.module for launch in plan.launches])
        self._ensembles: dict[int, _Ensemble] = {}  # by threads
        self._graphs: dict[bool, Any] = {}  # of a GPU: a step, audited or not
        self._commands: dict[Launch, tuple[list[Any], list[Any]]] = {}

    def launch(self, launch: Launch) -> None:
        """Launch one of the plan, all of it, now."""
        # Arrays may have been put elsewhere since the last time.
        arrays = [self._arrays[name] for name in launch.arrays]
        known, commands = self._commands.get(launch, ([], []))
        if not commands or any(map(operator.is_not, known, arrays)):
            commands = self._part(launch, 0, 1)
            self._commands[launch] = arrays, commands
        for command in commands:
            command.launch()

    def play(self, steps: range, threads: int) -> None:
        """Take steps, with as many threads as there are and the plan has shares for.

        One alone takes them where more would be slower, as on a busy machine.

        Args:
            steps: their numbers, which tell which of them are audited.
            threads: threads of the processor, >= 1.
        """
        if self._device.is_cuda:
            self._play_one_by_one(steps)
            return
        threads = self._pace.choose(min(threads, self._plan.share_count))
        if threads not in self._ensembles:
            self._ensembles[threads] = self._recorded(threads)
        start = time.perf_counter()
        self._play_together(steps, threads)
        self._pace.note(threads, len(steps), time.perf_counter() - start)

    def _play_one_by_one(self, steps: range) -> None:
        """On a GPU: a launch for each."""
        for step in steps:
            wp.capture_launch(self._graph(step % AUDIT_INTERVAL == 0))

    def _play_together(self, steps: range, threads: int) -> None:
        ensemble = self._ensembles[threads]
        longest = max(1, LONGEST_CALL // max(1, self._plan.particle_count))
        calls = [steps[first : first + longest] for first in range(0, len(steps), longest)]

        def play_part(thread: int) -> None:
            for call in calls:
                ensemble.loops[thread].play(call)

        def leave(thread: int) -> None:
            ensemble.arrivals.numpy()[thread] = LEFT
            calls.clear()

        if threads == 1:
            play_part(0)
            return
        try:
            team_of(threads).run(play_part, leave)
        except BaseException:
            del self._ensembles[threads]  # whose threads no longer meet
            raise

    def _part(self, launch: Launch, thread: int, threads: int) -> list[Any]:
        """What a thread does of a launch; one that is not shared is the first thread's."""
        if not launch.is_shared:
            return [self._command(launch.share(0, 1))] if thread == 0 else []
        count = self._plan.share_count if launch.adds_up else threads
        numbers = range(thread * count // threads, (thread + 1) * count // threads)
        return [self._command(launch.share(number, count)) for number in numbers]

    def _command(self, share: Launch) -> Any:
        dim, arguments = share.call(self._arrays)
        kinds = [argument.type for argument in share.kernel.adj.args]
        arguments = [
            self._empty(kind) if argument is None else argument
            for kind, argument in zip(kinds, arguments, strict=True)
        ]
        return wp.launch(share.kernel, dim, arguments, device=self._device, record_cmd=True)

    def _empty(self, kind: Any) -> Any:
        """An array of nothing: one that is None would take Warp's slower code for a processor."""
        return wp.empty((0,) * kind.ndim, dtype=kind.dtype, device=self._device)

    def _graph(self, audited: bool) -> Any:
        if audited not in self._graphs:
            with wp.ScopedCapture(device=self._device) as capture:
                for launch in (audited and self._plan.audited_step) or self._plan.step:
                    self.launch(launch)
            self._graphs[audited] = capture.graph
        return self._graphs[audited]

    def _recorded(self, threads: int) -> _Ensemble:
        """The loops of so many threads."""
        arrivals: Any = wp.zeros(threads, dtype=wp.int64, device=self._device)

        def taker(launches: Sequence[Launch], thread: int) -> Callable[[], None]:
            shared_next = [*(launch.is_shared for launch in launches[1:]), True]

            def take() -> None:
                for launch, others_follow in zip(launches, shared_next, strict=True):
                    for command in self._part(launch, thread, threads):
                        command.launch()
                    if threads > 1 and (launch.is_shared or others_follow):
                        wp.launch(make_rendezvous(), 1, [arrivals, thread], device=self._device)

            return take

        step, audited_step = self._plan.step, self._plan.audited_step
        loops = [
            _Loop(
                taker(step, thread),
                taker(audited_step, thread) if audited_step else None,
                self._device,
            )
            for thread in range(threads)
        ]
        return _Ensemble(loops, arrivals)
