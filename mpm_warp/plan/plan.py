"""A plan: the exact list of arrays and kernel launches of a run, as data.

It can be printed, compared and tested. Nothing here knows of a scene. A launch may be split into
shares that run at the same time.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.arguments import (
    FROM_ONE,
    POSITIVE,
    Range,
    as_array,
    check_array,
    check_number,
    check_whole,
)
from mpm_warp.errors import Fault, SceneError
from mpm_warp.kernel_types import mat22, real, vector
from mpm_warp.parameters import nearest_name

AUDIT_INTERVAL = 16
"""Every so many steps one is audited, where a plan has an audited step."""
WHOLE = {"int": wp.int32, "vec2i": wp.vec2i}
"""Types of whole numbers."""

WORTH_SHARING = 200
"""Fewest items of a launch whose work takes longer than the threads wait for each other."""
OFFSET = object()
"""Argument in whose place a share of a launch gets the number of its first item."""
SLACK = 1.05
"""Ratio of the time step to the wanted one up to which it stays: a change takes some time."""
SURPRISE = 1.1
"""What the critical time step may fall by between two looks, where none is beyond it before."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Array:
    """One array on the device."""

    kind: str  # name of its type, "vec2" say
    dtype: Any  # that type of Warp
    shape: tuple[int, ...]  # its lengths
    initial: np.ndarray | None  # what it holds when the run starts; None: zeros
    # how many there are of what its numbers are indices of, for each component; none where they are
    # no indices
    counts: tuple[int, ...] = ()
    may_be_none: bool = False  # whether indices may be -1 all, for none
    least: float = -math.inf  # lowest value that may be assigned

    @property
    def byte_count(self) -> int:
        """Bytes on the device."""
        return math.prod(self.shape) * int(wp.types.type_size_in_bytes(self.dtype))

    def allocate(self, device: str) -> wp.array[Any]:
        """The array, filled, on a device; on the processor it is the memory of `initial` itself."""
        if self.initial is None:
            return wp.zeros(self.shape, dtype=self.dtype, device=device)
        return wp.array(self.initial, dtype=self.dtype, device=device, copy=False)

    def check(self, name: str, values: object) -> None:
        """Raise `ValueError` where values, or one for all, do not fit the array of that name."""
        given = as_array(values)
        scalar = getattr(self.dtype, "_wp_scalar_type_", self.dtype)
        is_whole = self.kind in WHOLE
        limits: Any = (np.iinfo if is_whole else np.finfo)(wp.dtype_to_numpy(scalar))
        allowed = Range(minimum=max(float(limits.min), self.least), maximum=float(limits.max))
        shape = (*self.shape, *getattr(self.dtype, "_shape_", ())) if given.ndim else ()
        kinds = "iu" if is_whole else "fiu"
        check_array(name, given, shape, allowed, kinds=kinds, error=ValueError)
        if self.counts:
            row = (len(self.counts),)
            indices = given.reshape(-1, *row) if given.ndim else np.full((1, *row), given)
            there = indices[(indices != -1).any(axis=1)] if self.may_be_none else indices
            for part, count in zip(there.T, self.counts, strict=True):
                within = Range(minimum=0, maximum=count - 1)
                check_array(
                    f"{name}: index", part, part.shape, within, kinds="iu", error=ValueError
                )


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


SMALLER_STEP = "try a smaller time_step_fraction"
"""Default remedy in the message of a run that diverges."""


@dataclass(kw_only=True, eq=False)
class Plan:
    """All arrays and launches of a run."""

    time_step: float  # length of every step [s], of the first ones where there is a control
    longest_time_step: float  # beyond which a run is not stable [s]
    speed_limit: float  # speed of the fastest wave, which no particle exceeds in a sound run [m/s]
    # lowest and highest coordinates that particles may have [m]
    particle_bounds: tuple[Floats, Floats]
    # changes the time step during the run; None where what is stable stays the same
    control: TimeStepControl | None = None
    # into how many shares launches may be split: so many sums does a step add up, in one order,
    # whether the shares run one after the other or at the same time
    share_count: int = 1
    remedy: str = SMALLER_STEP  # what may help where a run diverges
    particle_count: int = 0  # particles at the start
    # what kernels are given by name beside arrays: numbers of the grid, properties of the soil
    given: dict[str, Any] = field(default_factory=dict)
    # by name, "particle.mass" say; the first word says over what they run
    arrays: dict[str, Array] = field(default_factory=dict)
    step: list[Launch] = field(default_factory=list)  # the launches of one step, in order
    # the same with an audit of energy in it, to be taken now and then; or none
    audited_step: list[Launch] = field(default_factory=list)
    # launches that the host orders between steps, by name
    between_steps: dict[str, Launch] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_whole("share_count", self.share_count, FROM_ONE)
        check_number("time_step", self.time_step, POSITIVE, unit="s")

    @property
    def launches(self) -> list[Launch]:
        """Every launch of the run, those of a step first."""
        audit = [launch for launch in self.audited_step if launch not in self.step]
        return [*self.step, *audit, *self.between_steps.values()]

    def add_array(
        self,
        name: str,
        kind: str,
        values: np.ndarray,
        counts: tuple[int, ...] = (),
        may_be_none: bool = False,
        least: float = -math.inf,
    ) -> str:
        """Add an array that starts with the given values; returns its name.

        Its `kind` is "real", "vec2", ..., or "int", "vec2i"; the last axes of the values are the
        components of a vector. What the others are is said in `Array`.

        Raises:
            SceneError: the plan has an array of that name, or of one that is the same in kernels.
        """
        dtype = _type_of(kind)
        components = getattr(dtype, "_shape_", ())
        shape = values.shape[: values.ndim - len(components)]
        scalar = np.int32 if kind in WHOLE else np.float64
        initial = np.array(values, dtype=scalar, order="C")
        return self._add(name, Array(kind, dtype, shape, initial, counts, may_be_none, least))

    def add_zeros(
        self, name: str, kind: str, shape: int | tuple[int, ...], counts: tuple[int, ...] = ()
    ) -> str:
        """Add an array that starts with zeros, see `add_array`; returns its name."""
        lengths = shape if isinstance(shape, tuple) else (shape,)
        return self._add(name, Array(kind, _type_of(kind), lengths, None, counts))

    def check_known(self, name: str) -> None:
        """Raise `KeyError`, which names the nearest, where there is no array of that name."""
        if not isinstance(name, str) or name not in self.arrays:
            raise KeyError(f"no array {name!r} in this run{nearest_name(str(name), self.arrays)}")

    def initial(self, name: str) -> NDArray[Any]:
        """What an array starts with, where it was given values; they may still be changed."""
        values = self.arrays[name].initial
        assert values is not None, f"{name} starts with zeros"
        return values

    def launch(self, kernel: Any, over: int | tuple[int, ...], **arguments: Any) -> Launch:
        """A launch; its arguments go by the names that they have in the kernel.

        What is not among them is what the plan has `given`, or the array of the same name,
        `node_mass` being "node.mass", the length of a step for `time_step`, `OFFSET` for `offset`;
        and where the plan is without an array that there is `maybe`, None.
        `over` is the threads along each axis. A text names an array, None stands for an empty one.

        Raises:
            TypeError: an argument is missing, or the kernel has none of that name.
        """
        kinds = kernel.func.__annotations__
        absent = [name for name, kind in kinds.items() if getattr(kind, "may_be_absent", False)]
        known: dict[str, Any] = dict.fromkeys(absent)
        known |= {name.replace(".", "_"): name for name in self.arrays}
        known |= {"offset": OFFSET, "time_step": self.time_step, **self.given, **arguments}
        missing = [name for name in kinds if name not in known]
        unknown = [name for name in arguments if name not in kinds]
        if missing or unknown:
            raise TypeError(
                f"kernel {kernel.key}: arguments missing: {missing}, unknown: {unknown}; it takes "
                f"{', '.join(kinds)}"
            )
        dim = over if isinstance(over, tuple) else (over,)
        return Launch(kernel=kernel, dim=dim, arguments=tuple(known[name] for name in kinds))

    def add_launch(self, kernel: Any, over: int | tuple[int, ...], **arguments: Any) -> None:
        """Add a launch to the end of the step; what is given and what not is said in `launch`."""
        self.step.append(self.launch(kernel, over, **arguments))

    def audit(self, *records: Launch, before: str = "", after: str = "") -> None:
        """Insert launches into the audited step, a copy of the complete step but for them.

        They stand right before or right after the launch of the step that has a name, or at the
        end, after what has been inserted so far.
        """
        audited = self.audited_step or list(self.step)
        at = len(audited)
        if name := before or after:
            place = next(launch for launch in self.step if launch.name == name)
            at = audited.index(place) + (name == after)
        self.audited_step = [*audited[:at], *records, *audited[at:]]

    def _add(self, name: str, array: Array) -> str:
        in_kernels = name.replace(".", "_")
        for other in self.arrays:
            if other == name:
                raise SceneError(f"array {name!r} is added twice: only one part may have it")
            if other.replace(".", "_") == in_kernels:
                raise SceneError(
                    f"array {name!r} goes not with {other!r}: kernels know both as {in_kernels!r}"
                )
        self.arrays[name] = array
        return name


def _type_of(kind: str) -> Any:
    """The type of that name: "real", "mat22", "vec" and a length, or one of `WHOLE`."""
    if kind in WHOLE:
        return WHOLE[kind]
    return {"real": real, "mat22": mat22}.get(kind) or vector(int(kind.removeprefix("vec")))


class Run(Protocol):
    """A run of a plan on a device, as what accompanies it between steps sees it."""

    @property
    def plan(self) -> Plan:
        """What it consists of."""

    def array(self, name: str) -> NDArray[Any]:
        """An array of the plan on the host: the device's own memory where they share it."""

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Give an array of the plan other values, or one value everywhere."""

    def launch(self, launch: Launch) -> None:
        """Launch a kernel of the plan."""
