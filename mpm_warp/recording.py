"""The steps of a plan, recorded once and replayed: Python takes no part in a step beyond a call."""

from __future__ import annotations

import functools
import operator
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import warp as wp

from mpm_warp.kernels.rendezvous import LEFT, make_rendezvous
from mpm_warp.pace import Pace
from mpm_warp.plan import Launch, StepPlan
from mpm_warp.team import team_of

AUDIT_INTERVAL = 16
"""Steps between two that are audited."""
BLOCK_SIZES = (16, 4, 1)
"""Steps that are taken by one call: several threads wait for each other in Python between two."""
LARGEST_ALONE = 4
"""The same for one thread: to record more would take longer than they save."""
LONG_RUN = 500
"""Steps after which a run is long enough to be worth the recording of more than one at a time."""


class _Block(NamedTuple):
    """Steps that are recorded together.

    Attributes:
        size: how many.
        audited: whether the first of them is audited.
    """

    size: int
    audited: bool


def _blocks(phase: int, count: int, largest: int) -> list[_Block]:
    """Blocks that make up steps, each at a multiple of its size.

    Args:
        phase: steps from the last audited one to the first.
        count: how many steps.
        largest: size of a block at most.
    """
    end_of_lead = min(phase + count, AUDIT_INTERVAL)
    whole, rest = divmod(phase + count - end_of_lead, AUDIT_INTERVAL)
    return [
        *_blocks_between(phase, end_of_lead, largest),
        *_blocks_between(0, AUDIT_INTERVAL, largest) * whole,
        *_blocks_between(0, rest, largest),
    ]


@functools.cache
def _blocks_between(begin: int, end: int, largest: int) -> tuple[_Block, ...]:
    """The same for steps between two audited ones, counted from the first of these."""
    if begin == end:
        return ()
    longest = min(largest, end - begin)
    size = next(it for it in BLOCK_SIZES if it <= longest and begin % it == 0)
    block = _Block(size, audited=begin == 0)
    return block, *_blocks_between(begin + size, end, largest)


@dataclass
class _Recordings:
    """What so many threads replay.

    Attributes:
        arrivals: where they meet; recordings do not keep the arrays that they refer to.
        of: a recording for each thread, by block.
    """

    arrivals: Any
    of: dict[_Block, list[Any]] = field(default_factory=dict)


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
        self._recordings: dict[int, _Recordings] = {}  # by threads
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
        largest = BLOCK_SIZES[0] if threads > 1 else LARGEST_ALONE
        if steps.start < LONG_RUN:
            largest = 1
        blocks = _blocks(steps.start % AUDIT_INTERVAL, len(steps), largest)
        recordings = self._recorded(set(blocks), threads)
        sequence = [recordings.of[block] for block in blocks]

        def play_part(thread: int) -> None:
            for recording in sequence:
                wp.capture_launch(recording[thread])

        def leave(thread: int) -> None:
            recordings.arrivals.numpy()[thread] = LEFT
            sequence.clear()

        start = time.perf_counter()
        if threads == 1:
            play_part(0)
        else:
            try:
                team_of(threads).run(play_part, leave)
            except BaseException:
                del self._recordings[threads]  # in which threads no longer meet
                raise
        self._pace.note(threads, len(steps), time.perf_counter() - start)

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

    def _recorded(self, blocks: set[_Block], threads: int) -> _Recordings:
        """Recordings of these blocks, and of others so far."""
        if threads not in self._recordings:
            arrivals = wp.zeros(threads, dtype=wp.int64, device=self._device)
            self._recordings[threads] = _Recordings(arrivals)
        recordings = self._recordings[threads]
        for block in blocks - recordings.of.keys():
            recordings.of[block] = self._record(block, threads, recordings.arrivals)
        return recordings

    def _record(self, block: _Block, threads: int, arrivals: Any) -> list[Any]:
        first = self._plan.audited_step if block.audited else []
        launches = [*(first or self._plan.step), *self._plan.step * (block.size - 1)]
        shared_next = [*(launch.is_shared for launch in launches[1:]), True]
        recordings = []
        for thread in range(threads):
            parts = {it: self._part(it, thread, threads) for it in dict.fromkeys(launches)}
            with wp.ScopedCapture(device=self._device) as capture:
                for launch, others_follow in zip(launches, shared_next, strict=True):
                    for command in parts[launch]:
                        command.launch()
                    if threads > 1 and (launch.is_shared or others_follow):
                        wp.launch(make_rendezvous(), 1, [arrivals, thread], device=self._device)
            recordings.append(capture.graph)
        return recordings
