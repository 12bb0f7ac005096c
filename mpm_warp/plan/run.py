"""A run of a plan, as what accompanies it between steps sees it: the inflow, the watch."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan


class Run(Protocol):
    """A run of a plan on a device."""

    @property
    def plan(self) -> Plan:
        """What it consists of."""

    def array(self, name: str) -> NDArray[Any]:
        """An array of the plan on the host: the device's own memory where they share it."""

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Give an array of the plan other values, or one value everywhere."""

    def launch(self, launch: Launch) -> None:
        """Launch a kernel of the plan."""
