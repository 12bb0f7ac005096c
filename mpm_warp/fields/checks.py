"""Checks of numbers, arrays and indices from a user. Kernels do not check the bounds of arrays.

Each check raises an error of one line with the argument, its value and what is allowed. A name
includes the part: "contact: nodes". The error is a `SceneError`, or of the class `error`.
"""

import math
import reprlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpm_warp.errors import SceneError


@dataclass(frozen=True, kw_only=True)
class Range:
    """Finite numbers within bounds."""

    above: float = -math.inf  # exclusive
    below: float = math.inf  # exclusive
    minimum: float = -math.inf  # inclusive
    maximum: float = math.inf  # inclusive

    def holds(self, lowest: Any, highest: Any) -> bool:
        """Whether the lowest and the highest of some values are in the range; NaN never is."""
        return bool(
            self.above < lowest
            and highest < self.below
            and self.minimum <= lowest
            and highest <= self.maximum
        )

    @property
    def allowed(self) -> str:
        """The bounds as a text; "" for none."""
        bounds = (">", self.above), (">=", self.minimum), ("<", self.below), ("<=", self.maximum)
        return " and ".join(f"{sign} {bound:g}" for sign, bound in bounds if math.isfinite(bound))


FINITE = Range()
POSITIVE = Range(above=0.0)
NOT_NEGATIVE = Range(minimum=0.0)
FROM_ONE = Range(minimum=1)
SHARE = Range(minimum=0.0, maximum=1.0)


def check_number(
    name: str,
    value: object,
    allowed: Range = FINITE,
    *,
    unit: str = "",
    error: type[ValueError] = SceneError,
) -> None:
    """Check that a value is a finite number within a range."""
    if isinstance(value, np.generic):
        value = value.item()  # a number of low precision cannot be compared with all limits
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    if not (is_number and allowed.holds(value, value)):
        kind = "" if is_number and FINITE.holds(value, value) else "a finite number "
        given = f"{in_words(value)}{f' {unit}' if unit and is_number else ''}"
        raise error(f"{name} = {given} must be {kind}{allowed.allowed}")


def check_whole(
    name: str, value: object, allowed: Range, *, error: type[ValueError] = SceneError
) -> None:
    """Check that a value has an integer type and is within a range."""
    is_whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not is_whole:
        raise error(f"{name} = {in_words(value)} must be an integer {allowed.allowed}")
    check_number(name, value, allowed, error=error)


def check_kind(name: str, value: object, kind: type | tuple[type, ...]) -> None:
    """Check that a value is an instance of a class, or of one of several."""
    if not isinstance(value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        words = " or ".join("None" if kind is type(None) else kind.__name__ for kind in kinds)
        raise SceneError(f"{name} = {in_words(value)} must be of type {words}")


def check_known(name: str, value: object, known: Collection[object]) -> None:
    """Check that a value is one of the `known`."""
    if value not in known:
        raise SceneError(f"{name} = {in_words(value)} must be one of {', '.join(map(str, known))}")


def as_array(values: object) -> NDArray[Any]:
    """Values as an array; for lists of different lengths an array of objects, which is refused."""
    try:
        return np.asarray(values)
    except ValueError:
        return np.array(None)


def check_array(
    name: str,
    values: object,
    shape: Sequence[int | None],
    allowed: Range = FINITE,
    *,
    kinds: str = "fiu",
    error: type[ValueError] = SceneError,
) -> None:
    """Check that values are an array of numbers of a shape, all finite and within a range.

    None in the shape allows any length. `kinds` are the letters of numpy for kinds of numbers.
    """
    if not (isinstance(values, np.ndarray) and values.dtype.kind in kinds):
        what = {"b": "true and false", "iu": "integers"}.get(kinds, "numbers")
        raise error(f"{name} = {in_words(values)} must be an array of {what}")
    lengths = zip(values.shape, shape, strict=False)
    if values.ndim != len(shape) or any(b is not None and a != b for a, b in lengths):
        wanted = ", ".join("any" if length is None else str(length) for length in shape)
        raise error(
            f"{name} has shape {values.shape}, must have ({wanted}{',' * (len(shape) < 2)})"
        )
    if values.size and not allowed.holds(values.min().item(), values.max().item()):
        places = np.ndindex(values.shape)
        worst = next(it for it in places if not allowed.holds(*2 * [values[it].item()]))
        place = ", ".join(map(str, worst))
        check_number(f"{name}[{place}]", values[worst].item(), allowed, error=error)


def check_rising(name: str, values: NDArray[Any], *, may_stay: bool = False) -> None:
    """Check that each value is above the one before; with `may_stay` not below it."""
    change = np.diff(values)
    wrong = np.flatnonzero(change < 0.0 if may_stay else change <= 0.0)
    if len(wrong):
        before, value = values[wrong[0] : wrong[0] + 2]
        bound = f"{'>=' if may_stay else '>'} {before:g}"
        raise SceneError(f"{name}[{wrong[0] + 1}] = {value:g} must be {bound}, the one before")


def check_nodes(name: str, nodes: Any, count: int) -> None:
    """Check that nodes are flat indices of a grid with `count` nodes, each once."""
    check_array(name, nodes, (None,), Range(minimum=0, maximum=count - 1), kinds="iu")
    present = np.bincount(nodes, minlength=1)
    if present.max() > 1:
        raise SceneError(f"{name}: node {present.argmax()} is there more than once")


def in_words(value: object) -> str:
    """A value as a short text of one line."""
    if isinstance(value, float):
        return f"{value:g}"
    return " ".join(reprlib.repr(value).split())


def shown(value: object) -> str:
    """A value in one line for a message. Huge integers and deeply nested tables cannot be shown."""
    try:
        text = repr(value)
        return " ".join(text.split()) if "\n" in text else text
    except (ValueError, RecursionError):
        return "(too long to show)"
