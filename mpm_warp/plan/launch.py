"""One kernel launch of a plan, and how it is split into shares that run at the same time."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

WORTH_SHARING = 200
"""Items of a launch, at least, whose work takes longer than the threads' wait for each other."""


OFFSET = object()
"""The argument by which a share of a launch gets the number of its first item."""


@dataclass(frozen=True)
class ShareRow:
    """The argument that gives each share of a launch a row of its own of an array."""

    name: str  # of the array
    number: int = 0  # of the share


def share_bounds(length: int, count: int) -> NDArray[np.integer[Any]]:
    """Where each of `count` shares of `length` items begins, and where the last one ends."""
    return length * np.arange(count + 1) // count


@dataclass(frozen=True, kw_only=True, eq=False)
class Launch:
    """One kernel launch; texts among the arguments name arrays of the plan.

    A launch that has `OFFSET` among its arguments can be split along its first axis into shares,
    which may run at the same time: what they write does not overlap, or is their `ShareRow`.
    """

    kernel: Any  # a kernel of Warp
    dim: tuple[int, ...]  # threads along each of its axes
    arguments: tuple[Any, ...]  # those of the kernel, in its order

    @property
    def name(self) -> str:
        """That of its kernel, whichever of its variants it is."""
        # Warp names a kernel by the functions that it was defined in, too.
        return str(self.kernel.key.split("__")[-1])

    @property
    def item_count(self) -> int:
        """How many times the kernel runs."""
        return math.prod(self.dim)

    @property
    def is_shared(self) -> bool:
        """Whether threads share the launch."""
        large = self.item_count >= WORTH_SHARING
        return OFFSET in self.arguments and (large or self.adds_up)

    @property
    def adds_up(self) -> bool:
        """Whether its result depends on how it is split, if only by rounding."""
        return any(isinstance(item, ShareRow) for item in self.arguments)

    @property
    def arrays(self) -> tuple[str, ...]:
        """Names of the arrays that the launch reads or writes."""
        names = (item.name if isinstance(item, ShareRow) else item for item in self.arguments)
        return tuple(name for name in names if isinstance(name, str))

    def share(self, number: int, count: int) -> "Launch":
        """One of `count` shares of the launch, as even as can be."""
        begin, end = share_bounds(self.dim[0], count)[number : number + 2].tolist()
        arguments: list[Any] = []
        for item in self.arguments:
            own = ShareRow(item.name, number) if isinstance(item, ShareRow) else item
            arguments.append(begin if item is OFFSET else own)
        dim = (end - begin, *self.dim[1:])
        return replace(self, dim=dim, arguments=tuple(arguments))

    def call(self, arrays: Mapping[str, Any]) -> tuple[tuple[int, ...], list[Any]]:
        """What the kernel is called with, by the arrays on a device: threads, and arguments."""

        def on_device(item: Any) -> Any:
            if isinstance(item, ShareRow):
                return arrays[item.name][item.number]
            return arrays[item] if isinstance(item, str) else item

        return self.dim, [on_device(item) for item in self.arguments]
