"""A kernel launch as data. It may be split into shares that run at the same time."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

WORTH_SHARING = 200
"""Least number of items of a launch that threads share; for fewer the wait takes longer."""
OFFSET = object()
"""Stands for the argument that is the number of the first item of a share."""


@dataclass(frozen=True)
class ShareRow:
    """The argument by which each share of a launch gets its own row of an array."""

    name: str  # of the array
    number: int = 0  # of the share


def share_bounds(length: int, count: int) -> NDArray[np.integer[Any]]:
    """First items of `count` shares of `length` items, and `length`."""
    return length * np.arange(count + 1) // count


@dataclass(frozen=True, kw_only=True, eq=False)
class Launch:
    """One kernel launch; texts among the arguments name arrays of the plan.

    A launch with the argument `OFFSET` can be split along its first axis into shares. They may run
    at the same time: each writes to other items, or to its `ShareRow`.
    """

    kernel: Any  # a kernel of Warp
    dim: tuple[int, ...]  # threads along each of its axes
    arguments: tuple[Any, ...]  # in the order of the kernel

    @property
    def name(self) -> str:
        """Name of the kernel, the same for all variants."""
        # Warp's name has the enclosing functions in front.
        return str(self.kernel.key.split("__")[-1])

    @property
    def item_count(self) -> int:
        """Number of threads."""
        return math.prod(self.dim)

    @property
    def is_shared(self) -> bool:
        """Whether threads share the launch."""
        large = self.item_count >= WORTH_SHARING
        return OFFSET in self.arguments and (large or self.adds_up)

    @property
    def adds_up(self) -> bool:
        """Whether the number of shares changes the result, by rounding."""
        return any(isinstance(item, ShareRow) for item in self.arguments)

    @property
    def arrays(self) -> tuple[str, ...]:
        """Names of the arrays that the launch reads or writes."""
        names = (item.name if isinstance(item, ShareRow) else item for item in self.arguments)
        return tuple(name for name in names if isinstance(name, str))

    def share(self, number: int, count: int) -> "Launch":
        """One of `count` shares of about equal size."""
        begin, end = share_bounds(self.dim[0], count)[number : number + 2].tolist()
        arguments: list[Any] = []
        for item in self.arguments:
            own = ShareRow(item.name, number) if isinstance(item, ShareRow) else item
            arguments.append(begin if item is OFFSET else own)
        dim = (end - begin, *self.dim[1:])
        return replace(self, dim=dim, arguments=tuple(arguments))

    def call(self, arrays: Mapping[str, Any]) -> tuple[tuple[int, ...], list[Any]]:
        """Threads and arguments of the kernel, with the arrays on a device."""

        def on_device(item: Any) -> Any:
            if isinstance(item, ShareRow):
                return arrays[item.name][item.number]
            return arrays[item] if isinstance(item, str) else item

        return self.dim, [on_device(item) for item in self.arguments]
