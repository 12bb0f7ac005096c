"""Where a run is computed, and a plan there: its arrays, and the ways to launch its kernels."""

import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.arguments import FROM_ONE, check_kind, check_known, check_whole
from mpm_warp.execution import THREAD_COUNTS
from mpm_warp.execution.replay import Replay
from mpm_warp.kernel_types import kernels_kept
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan


def device_names() -> list[str]:
    """Names of the devices of this machine: "cpu", and "cuda:0" and so on for GPUs."""
    return [str(device.alias) for device in wp.get_devices()]


@dataclass
class Execution:
    """Where a run is computed.

    The number of threads of a processor does not change any bit of the result. A GPU adds up sums
    in an order of its own.

    Attributes:
        device: "cpu", or the name that Warp gives to a GPU, for example "cuda:0".
        threads: threads of the processor, one of `mpm_warp.execution.THREAD_COUNTS`. The number may
            change while a run goes on. A GPU ignores it.
        case_count: number of runs that are computed together.

    Raises:
        SceneError: there is no such device here, or the number of threads is another.
    """

    device: str = "cpu"
    threads: int = 1
    case_count: int = field(default=1, init=False)

    def __post_init__(self) -> None:
        check_kind("device", self.device, str)
        check_whole("threads", self.threads, FROM_ONE)
        check_known("device", self.device, device_names())
        check_known("threads", self.threads, THREAD_COUNTS)

    def steps(self, plan: Plan, arrays: dict[str, Any]) -> Replay:
        """The steps of a plan on the device, for one run with its arrays there, by name."""
        return Replay(plan, arrays, self.device)

    @property
    def idle_time(self) -> float:
        """Wall-clock time for which the run has waited for other runs [s]."""
        return 0.0


class DeviceRun:
    """The arrays of a plan on a device, filled, and its launches, compiled.

    Args:
        plan: it is for this run alone.
        execution: where and on how many threads.

    Attributes:
        plan: its arrays and launches.
        arrays: on the device, by the names of the plan.
        compile_time: wall-clock time to compile the kernels or to load them from the cache [s].
    """

    def __init__(self, plan: Plan, execution: Execution) -> None:
        self.plan = plan
        self.arrays = {
            name: array.allocate(execution.device) for name, array in plan.arrays.items()
        }
        self._execution = execution
        self._host = wp.get_device("cpu")
        self._seen: dict[str, NDArray[Any]] = {}
        start = time.perf_counter()
        with kernels_kept():
            self._steps = execution.steps(plan, self.arrays)
        self.compile_time = time.perf_counter() - start

    def array(self, name: str) -> NDArray[Any]:
        """The present values of an array; on a processor writing to them changes the run."""
        if name in self._seen:
            return self._seen[name]
        values: NDArray[Any] = self.arrays[name].numpy()
        if self.arrays[name].device == self._host:
            self._seen[name] = values  # asked for often where particles are few
        return values

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Give an array other values, or one value everywhere."""
        array = self.arrays[name]
        if array.device == self._host:
            self.array(name)[...] = values
        elif isinstance(values, float):
            array.fill_(values)
        else:
            array.assign(values)

    def launch(self, launch: Launch) -> None:
        """Launch a kernel of the plan, all of it, now."""
        self._steps.launch(launch)

    def replay(self, steps: range) -> None:
        """Take the steps of these numbers, which decide which of them are audited."""
        self._steps.replay(steps, self._execution.threads)

    def change_time_step(self, changed: Plan) -> None:
        """Go on with the launches of the same plan with another time step."""
        self.plan.time_step = changed.time_step
        self.plan.step, self.plan.audited_step = changed.step, changed.audited_step
        self._steps = self._execution.steps(self.plan, self.arrays)
