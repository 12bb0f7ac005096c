"""The steps of a plan, recorded once and replayed: Python takes no part in them."""

from __future__ import annotations

import operator
import time
from collections.abc import Mapping
from typing import Any

import warp as wp

from mpm_warp.execution.worker_threads import Ensemble
from mpm_warp.execution.next_step import AUDIT_INTERVAL, make_next_step
from mpm_warp.execution.thread_count import Pace
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.execution.shares import share_of


class Player:
    """Launches of a plan on a device.

    Args:
        plan: whose launches they are.
        arrays: its arrays on the device, by name.
        device: where they are.
    """

    def __init__(self, plan: Plan, arrays: Mapping[str, Any], device: str) -> None:
        self._plan = plan
        self._arrays = arrays
        self._device = wp.get_device(device)
        self._pace = Pace()
        kernels = [*(launch.kernel for launch in plan.launches), make_next_step()]
        wp.force_load(self._device, modules=[kernel.module for kernel in kernels])
        self._ensembles: dict[int, Ensemble] = {}  # by threads
        self._graphs: dict[bool, Any] = {}  # of a GPU: a step, audited or not
        self._commands: dict[Launch, tuple[list[Any], list[Any]]] = {}

    def launch(self, launch: Launch) -> None:
        """Launch one of the plan, all of it, now."""
        # Arrays may have been put elsewhere since the last time.
        arrays = [self._arrays[name] for name in launch.arrays]
        known, commands = self._commands.get(launch, ([], []))
        if not commands or any(map(operator.is_not, known, arrays)):
            whole = share_of(launch, 0, 1, self._plan.share_count).own
            commands = [self._command(part) for part in whole]
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
            self._ensembles[threads] = Ensemble(self._plan, self._command, threads, self._device)
        start = time.perf_counter()
        try:
            self._ensembles[threads].play(steps)
        except BaseException:
            del self._ensembles[threads]
            raise
        self._pace.note(threads, len(steps), time.perf_counter() - start)

    def _play_one_by_one(self, steps: range) -> None:
        """On a GPU: a launch for each."""
        for step in steps:
            wp.capture_launch(self._graph(step % AUDIT_INTERVAL == 0))

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
