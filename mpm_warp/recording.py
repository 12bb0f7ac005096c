"""The steps of a plan, recorded once and replayed: Python takes no part in a step beyond a call."""

from __future__ import annotations

import operator
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import warp as wp

from mpm_warp.kernels.rendezvous import make_rendezvous
from mpm_warp.pace import Pace
from mpm_warp.plan import Launch, StepPlan
from mpm_warp.team import team_of

AUDIT_INTERVAL = 16
"""Steps between two that are audited."""


LONG_RUN = 500
"""Steps after which a run is long enough to be worth the recording of bursts."""


@dataclass(kw_only=True)
class _Recordings:
    """What is replayed by one call: a recording for each thread.

    Attributes:
        plain: a step.
        audited: one that is audited.
        burst: all steps from one audit to the next, for several threads in a long run: between
            calls they would wait for each other in Python.
    """

    plain: list[Any]
    audited: list[Any]
    burst: list[Any] | None = None

    def sequence(self, steps: range) -> list[list[Any]]:
        """What to replay for these steps."""
        first = steps.start % AUDIT_INTERVAL
        single = [self.audited, *[self.plain] * (AUDIT_INTERVAL - 1)]
        lead = min(len(steps), -steps.start % AUDIT_INTERVAL)
        count, rest = divmod(len(steps) - lead, AUDIT_INTERVAL)
        interval = single if self.burst is None else [self.burst]
        return single[first : first + lead] + interval * count + single[:rest]


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
        self._arrivals: list[Any] = []  # recordings do not keep the arrays that they refer to
        wp.force_load(self._device, modules=[launch.kernel.module for launch in plan.launches])
        self._recordings: dict[int, _Recordings] = {}
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
        threads = self._pace.choose(min(threads, self._plan.share_count))
        if threads not in self._recordings:
            self._recordings[threads] = self._record_step(threads)
        recordings = self._recordings[threads]
        if threads > 1 and recordings.burst is None and steps.start >= LONG_RUN:
            plain = self._plan.step * (AUDIT_INTERVAL - 1)
            recordings.burst = self._record([*self._audited, *plain], threads)
        sequence = recordings.sequence(steps)

        def play_part(thread: int) -> None:
            for recording in sequence:
                wp.capture_launch(recording[thread])

        start = time.perf_counter()
        if threads == 1:
            play_part(0)
        else:
            team_of(threads).run(play_part)
        self._pace.note(threads, len(steps), time.perf_counter() - start)

    def _part(self, launch: Launch, thread: int, threads: int) -> list[Any]:
        """What a thread does of a launch; one that is not shared is the first thread's."""
        if not launch.is_shared:
            return [self._command(launch)] if thread == 0 else []
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

    @property
    def _audited(self) -> list[Launch]:
        return self._plan.audited_step or self._plan.step

    def _record_step(self, threads: int) -> _Recordings:
        return _Recordings(
            plain=self._record(self._plan.step, threads),
            audited=self._record(self._audited, threads),
        )

    def _record(self, launches: Sequence[Launch], threads: int) -> list[Any]:
        arrivals: Any = wp.zeros(threads, dtype=int, device=self._device)
        self._arrivals.append(arrivals)
        shared_next = [*(launch.is_shared for launch in launches[1:]), True]
        recordings = []
        for thread in range(threads):
            with wp.ScopedCapture(device=self._device) as capture:
                for launch, others_follow in zip(launches, shared_next, strict=True):
                    for command in self._part(launch, thread, threads):
                        command.launch()
                    if threads > 1 and (launch.is_shared or others_follow):
                        wp.launch(make_rendezvous(), 1, [arrivals, thread], device=self._device)
            recordings.append(capture.graph)
        return recordings
