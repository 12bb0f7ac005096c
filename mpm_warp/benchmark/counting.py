"""What the launches of a step work out and move at the least, counted from the kernels themselves.

Warp compiles a kernel from a Python function. Here the same function is called for some threads of
a launch, on numbers that count. So the count is of the kernel as it is, with the branches that its
threads take on the arrays of a run; these stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mpm_warp.benchmark.counting_numbers import Number, Tally, Whole, counted, shaped
from mpm_warp.plan.plan import Offset, Launch, ShareRow
from mpm_warp.simulation import TimeLoop

SAMPLED = 250
"""Threads of a launch that are run; all where there are fewer."""


@dataclass(frozen=True)
class Work:
    """What a launch has to do at the least.

    Each component of a vector counts. What a thread has worked out before does not count again, nor
    does what only depends on literals and scalar arguments, nor a change of sign, nor indices.

    Attributes:
        operations: additions, subtractions, multiplications, comparisons, minima and maxima of
            floating point numbers.
        divisions: divisions and square roots.
        traffic: bytes of the array elements that are read and of those that are written, each
            moved once [byte].
    """

    operations: float
    divisions: float
    traffic: float


def stage_work(loop: TimeLoop) -> dict[str, Work]:
    """The work of each launch of a step, by the name of its kernel; the step is really taken.

    Args:
        loop: a run on the processor.

    Raises:
        AttributeError: a kernel calls a function of Warp that numbers that count do not know.
    """
    work = {}
    for launch in loop.plan.step:
        work[launch.name] = Count(launch, loop.arrays).work()
        loop.launch(launch)  # leaves what the next one finds
    return work


class Count:
    """Threads of a launch, run on numbers that count.

    Args:
        launch: which threads are run is chosen at random, the same every time.
        arrays: the arrays of its plan, on the processor.

    Attributes:
        memories: the arrays among its arguments, by name, and what was stored in them.
    """

    def __init__(self, launch: Launch, arrays: Mapping[str, Any]) -> None:
        self.memories: dict[str, Memory] = {}
        self._tally = Tally()
        dim, arguments = launch.call(arrays)
        thread_count = math.prod(dim)
        chosen = np.random.default_rng(0).permutation(thread_count)[:SAMPLED]
        self._share = len(chosen) / thread_count
        stand_ins = list(map(self._stand_in, launch.arguments, arguments))
        thread: list[Whole] = []
        run = counted(launch.kernel.func, self._tally, thread)
        for number in chosen:
            thread[:] = [Whole(it) for it in np.unravel_index(number, dim)]
            self._tally.begin_thread()
            for memory in self.memories.values():
                memory.begin_thread()
            run(*stand_ins)

    def work(self) -> Work:
        """The work of all threads, from those that were run."""
        return Work(
            operations=self._tally.operations / self._share,
            divisions=self._tally.divisions / self._share,
            traffic=sum(memory.traffic(self._share) for memory in self.memories.values()),
        )

    def _stand_in(self, item: Any, argument: Any) -> Any:
        if isinstance(item, str | ShareRow):
            name = item.name if isinstance(item, ShareRow) else item
            self.memories[name] = Memory(name, argument, self._tally)
            return self.memories[name]
        if isinstance(item, float):
            return self._tally.constant(item)
        return 0 if isinstance(item, Offset) else argument


class Memory:
    """Stands in for an array; what a thread stores is for itself alone.

    Args:
        name: of the array.
        array: what it holds.
        tally: counts what is done with its numbers.

    Attributes:
        stored: what threads have stored: a list of (index, element).
    """

    def __init__(self, name: str, array: Any, tally: Tally) -> None:
        self._name, self._tally = name, tally
        self._values: np.ndarray = array.numpy()
        self._size: int = self._values.nbytes
        self._element_size: float = self._size / math.prod(array.shape)
        self._here: dict[Any, Any] = {}
        self._load_count = 0
        self.stored: list[tuple[Any, Any]] = []

    def begin_thread(self) -> None:
        """The next thread finds nothing of what the last one stored."""
        self._here = {}

    def __getitem__(self, index: Any) -> Any:
        if index not in self._here:
            self._load_count += 1
            self._here[index] = self._element(index)
        return self._here[index]

    def __setitem__(self, index: Any, element: Any) -> None:
        self._here[index] = element
        self.stored.append((index, element))

    def traffic(self, share: float) -> float:
        """Bytes that all threads read and write, from what a share of them did [byte]."""
        return sum(
            min(self._size, count * self._element_size / share)
            for count in (self._load_count, len(self.stored))
        )

    def _element(self, index: Any) -> Any:
        values = self._values[index]
        if values.dtype.kind == "i":
            whole = values.tolist()
            return whole if isinstance(whole, int) else tuple(whole)
        numbers: list[Number] = [
            self._tally.loaded((self._name, index, place), value)
            for place, value in enumerate(values.ravel().tolist())
        ]
        return shaped(numbers, values.shape)
