"""The time step of a run in which what is stable changes on the way."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from mpm_warp.errors import Fault

SLACK = 1.05
"""Ratio of the time step to the wanted one up to which it stays: a change takes some time."""
SURPRISE = 1.1
"""What the critical time step may fall by between two looks, where none is beyond it before."""


@dataclass(kw_only=True, eq=False)
class TimeStepControl:
    """Keeps the time step at a fraction of the critical one, which the watch finds anew.

    Where the critical one has fallen from one look to the next it is expected to fall on as much.
    """

    first: float  # the first time step, which none exceeds [s]
    fraction: float  # time step over the critical one, > 0
    # the critical time step [s], by a function that gives arrays of the run by name
    critical: Callable[[Callable[[str], NDArray[Any]]], float]

    def __post_init__(self) -> None:
        self._critical_before = self.first / self.fraction

    def following(self, time_step: float, array: Callable[[str], NDArray[Any]]) -> float:
        """The time step to go on with [s]; it stays what it is while it is nearly right.

        Raises:
            Fault: the time step is beyond the critical one by now.
        """
        critical = self.critical(array)
        longest = max(1.0, SURPRISE * self.fraction) * critical
        check_time_step(time_step=time_step, longest=longest)
        fall = min(1.0, critical / self._critical_before)
        self._critical_before = critical
        wanted = min(self.first, self.fraction * critical * fall)
        return time_step if wanted / SLACK <= time_step <= wanted * SLACK else wanted


def check_time_step(*, time_step: float, longest: float) -> None:
    """Raise `Fault` where the time step is beyond the longest that is stable [s]."""
    if not time_step <= longest:
        raise Fault(f"time step of {time_step:.4g} s is beyond the stable {longest:.4g} s")
