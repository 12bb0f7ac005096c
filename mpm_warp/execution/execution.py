"""Where a run is computed: a device, and a number of threads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import warp as wp

from mpm_warp.arguments import FROM_ONE, check_whole
from mpm_warp.execution.replay import Replay
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan


def device_names() -> list[str]:
    """Names of the devices of this machine: "cpu", and "cuda:0" and so on for GPUs."""
    return [str(device.alias) for device in wp.get_devices()]


class Steps(Protocol):
    """The steps of one run on a device."""

    def launch(self, launch: Launch) -> None:
        """Launch one kernel of the plan, all of it, now."""

    def replay(self, steps: range, threads: int) -> None:
        """Take the steps of these numbers.

        Args:
            steps: step numbers; they decide which steps are audited.
            threads: threads of the processor, >= 1; a GPU ignores it.
        """


@dataclass
class Execution:
    """Where a run is computed.

    The number of threads of a processor does not change any bit of the result. A GPU adds up sums
    in an order of its own.

    Attributes:
        device: "cpu", or the name that Warp gives to a GPU, for example "cuda:0".
        threads: threads of the processor, one of `mpm_warp.execution.THREAD_COUNTS`. The number may
            change while a run goes on. A GPU ignores it.

    Raises:
        ValueError: the number of threads is not an integer >= 1.
    """

    device: str = "cpu"
    threads: int = 1

    def __post_init__(self) -> None:
        check_whole("threads", self.threads, FROM_ONE, error=ValueError)

    def steps(self, plan: Plan, arrays: dict[str, Any]) -> Steps:
        """The steps of a plan on the device, for one run.

        Args:
            plan: the plan of the run.
            arrays: the arrays of the plan on the device, by name. A batch replaces some of them by
                arrays of its own.
        """
        return Replay(plan, arrays, self.device)

    @property
    def idle_time(self) -> float:
        """Wall-clock time for which the run has waited for other runs [s]."""
        return 0.0

    @property
    def case_count(self) -> int:
        """Number of runs that are computed together."""
        return 1
