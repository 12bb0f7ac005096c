"""A plan: the exact list of arrays and kernel launches of a run, as data.

It can be printed, compared and tested; it knows no scene.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import warp as wp
from numpy.typing import NDArray

from mpm_warp.errors import Fault, SceneError
from mpm_warp.fields.checks import (
    FROM_ONE,
    POSITIVE,
    Range,
    as_array,
    check_array,
    check_number,
    check_whole,
)
from mpm_warp.fields.names import nearest_name
from mpm_warp.kernel_types import mat22, real, vector
from mpm_warp.plan.launch import OFFSET, Launch

AUDIT_INTERVAL = 16
"""Steps from one audited step to the next, if a plan has an audited step."""
WHOLE = {"int": wp.int32, "vec2i": wp.vec2i}
"""Integer types."""
SLACK = 1.05
"""Ratio of the time step and the wanted one up to which it is kept, because a change takes time."""
LARGEST_FALL = 1.1
"""Factor by which the critical time step may fall between two checks before the run ends."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Array:
    """One array on the device."""

    kind: str  # name of its type, as "vec2"
    dtype: Any  # that type of Warp
    shape: tuple[int, ...]
    initial: np.ndarray | None  # initial values; None: zeros
    counts: tuple[int, ...] = ()  # of an array of indices: the bound of each component
    may_be_none: bool = False  # whether indices may be -1, which stands for none
    least: float = -math.inf  # least value that may be assigned

    @property
    def byte_count(self) -> int:
        """Bytes on the device."""
        return math.prod(self.shape) * int(wp.types.type_size_in_bytes(self.dtype))

    def allocate(self, device: str) -> wp.array[Any]:
        """The array with its initial values on a device; on a processor in the memory of these."""
        if self.initial is None:
            return wp.zeros(self.shape, dtype=self.dtype, device=device)
        return wp.array(self.initial, dtype=self.dtype, device=device, copy=False)

    def check(self, name: str, values: object) -> None:
        """Raise `ValueError` if the array `name` cannot take the values, or one for all."""
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


@dataclass(kw_only=True, eq=False)
class TimeStepControl:
    """Keeps the time step at a fraction of the critical one, which changes during a run.

    If the critical one has fallen between two checks, it is expected to fall by the same factor.
    """

    first: float  # the first time step, the greatest [s]
    fraction: float  # time step over the critical one, > 0
    # (function from names to arrays of the run) -> critical time step [s]
    critical: Callable[[Callable[[str], NDArray[Any]]], float]

    def __post_init__(self) -> None:
        self._critical_before = self.first / self.fraction

    def following(self, time_step: float, array: Callable[[str], NDArray[Any]]) -> float:
        """The next time step [s], the present one if it is nearly right.

        Raises:
            Fault: the present time step exceeds the critical one.
        """
        critical = self.critical(array)
        longest = max(1.0, LARGEST_FALL * self.fraction) * critical
        check_time_step(time_step=time_step, longest=longest)
        fall = min(1.0, critical / self._critical_before)
        self._critical_before = critical
        wanted = min(self.first, self.fraction * critical * fall)
        return time_step if wanted / SLACK <= time_step <= wanted * SLACK else wanted


def check_time_step(*, time_step: float, longest: float) -> None:
    """Raise `Fault` if the time step exceeds the longest stable one [s]."""
    if not time_step <= longest:
        raise Fault(f"time step of {time_step:.4g} s is beyond the stable {longest:.4g} s")


SMALLER_STEP = "try a smaller time_step_fraction"
"""Default remedy in the message of a run that diverges."""


@dataclass(kw_only=True, eq=False)
class Plan:
    """All arrays and launches of a run."""

    time_step: float  # the first time step; without a control that of all steps [s]
    longest_time_step: float  # longest stable time step [s]
    speed_limit: float  # speed of the fastest wave, above that of all particles [m/s]
    particle_bounds: tuple[Floats, Floats]  # lowest and highest coordinates of particles [m]
    control: TimeStepControl | None = None  # changes the time step; None: it stays
    # number of shares of a launch, and of the private sums of launches that add up. The sums are
    # added in one order, however many threads take part
    share_count: int = 1
    remedy: str = SMALLER_STEP  # what may help if the run diverges
    particle_count: int = 0  # particles at the start
    given: dict[str, Any] = field(default_factory=dict)  # further arguments of kernels, by name
    # by name, as "particle.mass"; the first word says over what the array runs
    arrays: dict[str, Array] = field(default_factory=dict)
    step: list[Launch] = field(default_factory=list)  # the launches of one step, in order
    # the launches of every 16th step, with further records; empty: all steps are the same
    audited_step: list[Launch] = field(default_factory=list)
    between_steps: dict[str, Launch] = field(default_factory=dict)  # launches of the host, by name

    def __post_init__(self) -> None:
        check_whole("share_count", self.share_count, FROM_ONE)
        check_number("time_step", self.time_step, POSITIVE, unit="s")

    @property
    def launches(self) -> list[Launch]:
        """All launches of the run, those of a step first."""
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
        """Add an array with initial values; returns its name.

        The `kind` is "real", "vec2", ..., or "int", "vec2i"; the last axes of the values are the
        components of a vector. Further arguments are those of `Array`.

        Raises:
            SceneError: the plan has an array of that name, or of the same name in kernels.
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
        """Add an array of zeros, see `add_array`; returns its name."""
        lengths = shape if isinstance(shape, tuple) else (shape,)
        return self._add(name, Array(kind, _type_of(kind), lengths, None, counts))

    def check_known(self, name: str) -> None:
        """Raise `KeyError`, which names the nearest, if there is no array of that name."""
        if not isinstance(name, str) or name not in self.arrays:
            raise KeyError(f"no array {name!r} in this run{nearest_name(str(name), self.arrays)}")

    def initial(self, name: str) -> NDArray[Any]:
        """The initial values of an array that was added with values; they may be changed."""
        values = self.arrays[name].initial
        assert values is not None, f"{name} starts with zeros"
        return values

    def launch(self, kernel: Any, over: int | tuple[int, ...], **arguments: Any) -> Launch:
        """A launch over threads along each axis; arguments are named as in the kernel.

        An argument that is not given is that of `Plan.given`, the time step, `OFFSET`, or the array
        of the same name: "node.mass" for `node_mass`. If the plan lacks an array of the type
        `maybe`, its argument is None, an empty array. A text names an array.

        Raises:
            TypeError: an argument is missing, or the kernel has no argument of that name.
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
        """Add a launch to the end of the step, see `launch`."""
        self.step.append(self.launch(kernel, over, **arguments))

    def audit(self, *records: Launch, before: str = "", after: str = "") -> None:
        """Insert launches into the audited step, which otherwise is a copy of the step.

        They come directly before or after the launch of the step with this name, or at the end.
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
                raise SceneError(f"array {name!r} is added twice: a scene has one part of a kind")
            if other.replace(".", "_") == in_kernels:
                raise SceneError(
                    f"array {name!r} goes not with {other!r}: kernels know both as {in_kernels!r}"
                )
        self.arrays[name] = array
        return name


def _type_of(kind: str) -> Any:
    """The type of a name: "real", "mat22", "vec" with a length, or one of `WHOLE`."""
    if kind in WHOLE:
        return WHOLE[kind]
    return {"real": real, "mat22": mat22}.get(kind) or vector(int(kind.removeprefix("vec")))


class Run(Protocol):
    """A run of a plan on a device, as parts and the watch see it."""

    @property
    def plan(self) -> Plan:
        """Arrays and launches of the run."""

    def array(self, name: str) -> NDArray[Any]:
        """An array of the plan on the host; on a processor it is the array of the run itself."""

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Set the values of an array of the plan, or one value everywhere."""

    def launch(self, launch: Launch) -> None:
        """Launch a kernel of the plan."""
