"""Numbers that count what is done with them, and the functions of Warp for such numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from types import CellType, FunctionType, SimpleNamespace
from typing import Any

import warp as wp

REAL = (wp.float32, wp.float64)


class Tally:
    """Counts operations, of one thread after the other.

    Attributes:
        operations: additions, subtractions, multiplications, comparisons, minima and maxima.
        divisions: divisions and square roots.
    """

    def __init__(self) -> None:
        self.operations = 0
        self.divisions = 0
        self._known: dict[Any, int] = {}  # what this thread has loaded and worked out

    def begin_thread(self) -> None:
        """What the last thread has worked out is not known to the next."""
        self._known.clear()

    def constant(self, value: Any) -> Number:
        """A literal or a scalar argument: the same for all threads."""
        return value if isinstance(value, Number) else Number(self, float(value), None)

    def loaded(self, place: Any, value: float) -> Number:
        """A number that a thread finds at a place of the memory."""
        return Number(self, value, self._known.setdefault(place, len(self._known)))

    def operation(self, name: str, value: float, *operands: Number) -> Number:
        """The result of an operation, which counts if the thread has not done it before."""
        if all(it.name is None for it in operands):
            return self.constant(value)
        key = (name, *(it.value if it.name is None else (it.name,) for it in operands))
        if key not in self._known:
            is_division = name in {"/", "root"}
            self.divisions += is_division
            self.operations += not is_division
        return self.loaded(key, value)


class Number:
    """A floating point number of a thread; `name` tells it from others, None where all have it."""

    def __init__(self, tally: Tally, value: float, name: int | None) -> None:
        self.tally, self.value, self.name = tally, value, name

    def __add__(self, other: Number) -> Number:
        return self.tally.operation("+", self.value + other.value, self, other)

    def __sub__(self, other: Number) -> Number:
        return self.tally.operation("-", self.value - other.value, self, other)

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Vector):
            return Vector(self * it for it in other)
        return self.tally.operation("*", self.value * other.value, self, other)

    def __truediv__(self, other: Number) -> Number:
        quotient = self.value / other.value if other.value else math.nan
        return self.tally.operation("/", quotient, self, other)

    def __neg__(self) -> Number:
        return self._with_sign("negative", -self.value)

    def __abs__(self) -> Number:
        return self._with_sign("magnitude", abs(self.value))

    def __lt__(self, other: Number) -> bool:
        return self._compared("<", self.value < other.value, other)

    def __le__(self, other: Number) -> bool:
        return self._compared("<=", self.value <= other.value, other)

    def __gt__(self, other: Number) -> bool:
        return self._compared(">", self.value > other.value, other)

    def __ge__(self, other: Number) -> bool:
        return self._compared(">=", self.value >= other.value, other)

    def __eq__(self, other: object) -> bool:
        assert isinstance(other, Number)
        return self._compared("==", self.value == other.value, other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None  # type: ignore[assignment]

    def _compared(self, name: str, holds: bool, other: Number) -> bool:
        self.tally.operation(name, 0.0, self, other)
        return holds

    def _with_sign(self, name: str, value: float) -> Number:
        if self.name is None:
            return self.tally.constant(value)
        return self.tally.loaded((name, self.name), value)


class Vector(tuple[Any, ...]):
    """A vector of numbers, or a matrix: a vector of its rows."""

    __slots__ = ()

    def __add__(self, other: Any) -> Vector:
        return Vector(one + another for one, another in zip(self, other, strict=True))

    def __sub__(self, other: Any) -> Vector:
        return Vector(one - another for one, another in zip(self, other, strict=True))

    def __mul__(self, other: Any) -> Vector:
        if isinstance(other, Vector):  # a matrix by a vector
            return Vector(_dot(row, other) for row in self)
        return Vector(it * other for it in self)

    def __truediv__(self, other: Number) -> Vector:
        return Vector(it / other for it in self)

    def __neg__(self) -> Vector:
        return Vector(-it for it in self)


class Whole(int):
    """The index of a thread, divided as whole numbers are in a kernel."""

    def __add__(self, other: int) -> Whole:
        return Whole(int(self) + other)

    __radd__ = __add__

    def __truediv__(self, other: int) -> Whole:
        return Whole(self // other)


def shaped(numbers: Sequence[Number], shape: tuple[int, ...]) -> Any:
    """The number, vector or matrix of these components."""
    if len(shape) == 2:
        width = shape[1]
        return Vector(
            Vector(numbers[first : first + width]) for first in range(0, len(numbers), width)
        )
    return Vector(numbers) if shape else numbers[0]


def counted(function: Any, tally: Tally, thread: list[Whole]) -> Callable[..., Any]:
    """The Python function of a kernel with stand-ins for all that it uses.

    Args:
        function: of the kernel, or of a function that it calls.
        tally: counts what the numbers do.
        thread: the index of the thread that is run, to be kept up to date.
    """

    def stand_in(item: Any) -> Any:
        if isinstance(item, wp.Function):
            return counted(item.func, tally, thread)
        if item in REAL:
            return tally.constant
        if isinstance(item, REAL):
            return tally.constant(item.value)
        if isinstance(item, type) and hasattr(item, "_shape_"):
            zeros = [0.0] * math.prod(item._shape_)
            return lambda *components: shaped(
                [tally.constant(it) for it in components or zeros], item._shape_
            )
        return item

    closure = tuple(CellType(stand_in(cell.cell_contents)) for cell in function.__closure__ or ())
    known = function.__globals__
    names = {it: stand_in(known[it]) for it in function.__code__.co_names if it in known}
    return FunctionType(function.__code__, names | {"wp": _warp(thread)}, closure=closure)


def _warp(thread: list[Whole]) -> SimpleNamespace:
    return SimpleNamespace(
        tid=lambda: thread[0] if len(thread) == 1 else tuple(thread),
        static=lambda value: value,
        vec2i=lambda *components: components,
        atomic_add=_add_to,
        min=_least,
        max=_greatest,
        clamp=lambda x, low, high: _least(_greatest(x, low), high),
        abs=abs,
        sqrt=_root,
        dot=_dot,
        length=lambda vector: _root(_dot(vector, vector)),
    )


def _add_to(array: Any, index: Any, value: Any) -> None:
    array[index] = array[index] + value


def _least(x: Any, y: Any) -> Any:
    if isinstance(x, Number):
        return x.tally.operation("min", min(x.value, y.value), x, y)
    return min(x, y)


def _greatest(x: Any, y: Any) -> Any:
    if isinstance(x, Number):
        return x.tally.operation("max", max(x.value, y.value), x, y)
    return max(x, y)


def _root(x: Number) -> Number:
    return x.tally.operation("root", math.sqrt(x.value), x)


def _dot(one: Vector, other: Vector) -> Number:
    first, *others = (x * y for x, y in zip(one, other, strict=True))
    total: Number = sum(others, first)
    return total
