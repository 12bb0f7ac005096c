"""A plan on a device: its arrays, and the ways to launch its kernels."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.execution.execution import Execution
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.precision import kernels_kept


class DeviceRun:
    """The arrays of a plan on a device, filled, and its launches, compiled.

    Args:
        plan: it is for this run alone.
        execution: where and on how many threads.

    Attributes:
        plan: its arrays and launches.
        arrays: on the device, by the names of the plan; a batch may replace them.
        compile_time: wall-clock time to compile the kernels or to load them from the cache [s].
    """

    def __init__(self, plan: Plan, execution: Execution) -> None:
        self.plan = plan
        self.arrays = {
            name: array.allocate(execution.device) for name, array in plan.arrays.items()
        }
        self._execution = execution
        self._host = wp.get_device("cpu")
        self._seen: dict[str, tuple[Any, NDArray[Any]]] = {}
        start = time.perf_counter()
        with kernels_kept():
            self._steps = execution.steps(plan, self.arrays)
        self.compile_time = time.perf_counter() - start

    def array(self, name: str) -> NDArray[Any]:
        """The present values of an array; on a processor writing to them changes the run.

        Raises:
            KeyError: the run has no array of that name.
        """
        array = self.arrays[name]
        seen, values = self._seen.get(name, (None, np.empty(0)))
        if seen is not array:
            values = array.numpy()
            if array.device == self._host:
                self._seen[name] = array, values  # asked for often where particles are few
        return values

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Give an array other values, or one value everywhere.

        Raises:
            KeyError: the run has no array of that name.
        """
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
