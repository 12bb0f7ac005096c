"""A plan: the exact list of arrays and kernel launches of a run, as data.

It can be printed, compared and tested. `mpm_warp.planning` makes one from a scene.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
import warp as wp

from mpm_warp.grid.fitted import Floats, Integers
from mpm_warp.precision import Precision
from mpm_warp.scene import Scene
from mpm_warp.plan.time_step import TimeStepControl


@dataclass(frozen=True, kw_only=True, eq=False)
class Array:
    """One array on the device.

    Attributes:
        dtype: type of Warp, of numbers, vectors or matrices.
        shape: its lengths.
        initial: what it holds when the run starts; None: zeros.
    """

    dtype: Any
    shape: tuple[int, ...]
    initial: np.ndarray | None

    @property
    def byte_count(self) -> int:
        """Bytes on the device."""
        return math.prod(self.shape) * int(wp.types.type_size_in_bytes(self.dtype))

    def allocate(self, device: str) -> wp.array[Any]:
        """The array, filled, on a device; on the processor it is the memory of `initial` itself."""
        if self.initial is None:
            return wp.zeros(self.shape, dtype=self.dtype, device=device)
        return wp.array(self.initial, dtype=self.dtype, device=device, copy=False)


AUDIT_INTERVAL = 16
"""Every step whose number is a multiple of this is audited, where a plan has an audited step."""
WHOLE = {"int": wp.int32, "vec2i": wp.vec2i}
"""Types of whole numbers, which do not depend on the precision."""


def share_bounds(length: int, count: int) -> Integers:
    """Where the `count` shares of so many things begin, and where the last one ends."""
    bounds: Integers = length * np.arange(count + 1) // count
    return bounds


WORTH_SHARING = 200
"""Items of a launch, at least, that take threads longer than to wait for each other."""


class Offset:
    """The argument that tells a share of a launch where it begins."""


@dataclass(frozen=True)
class ShareRow:
    """The argument that gives each share of a launch a row of an array: that of its number."""

    name: str
    number: int = 0


OFFSET = Offset()


@dataclass(frozen=True, kw_only=True, eq=False)
class Launch:
    """One kernel launch over `dim` threads; texts among the arguments name arrays of the plan.

    One that has `OFFSET` among its arguments can be split along its first axis into shares, which
    may run at the same time: what they write does not overlap, or is their `ShareRow`.

    Attributes:
        kernel: a kernel of Warp.
        dim: threads along each of its axes.
        arguments: those of the kernel, in its order.
    """

    share_axis: ClassVar[int] = 0
    """Axis of an `ShareRow` array along which the rows of the shares lie."""
    kernel: Any
    dim: tuple[int, ...]
    arguments: tuple[Any, ...]

    @property
    def name(self) -> str:
        """That of its kernel, whichever of its variants it is."""
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

    def share(self, number: int, count: int) -> Launch:
        """One of `count` shares of the launch, as even as can be."""
        begin, end = share_bounds(self.dim[0], count)[number : number + 2].tolist()
        arguments: list[Any] = []
        for item in self.arguments:
            own = ShareRow(item.name, number) if isinstance(item, ShareRow) else item
            arguments.append(begin if item is OFFSET else own)
        dim = (end - begin, *self.dim[1:])
        return replace(self, dim=dim, arguments=tuple(arguments))

    def call(self, arrays: Mapping[str, Any]) -> tuple[tuple[int, ...], list[Any]]:
        """What the kernel is called with: over which threads, and its arguments.

        Args:
            arrays: those of the plan on a device, by name.
        """

        def on_device(item: Any) -> Any:
            if isinstance(item, ShareRow):
                return arrays[item.name][(slice(None),) * self.share_axis + (item.number,)]
            return arrays[item] if isinstance(item, str) else item

        return self.dim, [on_device(item) for item in self.arguments]


@dataclass(kw_only=True, eq=False)
class StepPlan:
    """The arrays and the launches of a step, whatever scene they come from.

    Attributes:
        precision: floating point types.
        time_step: length of every step [s], of the first ones where there is a control.
        longest_time_step: beyond which a run is not stable [s].
        speed_limit: speed of the fastest wave, which no particle exceeds in a sound run [m/s].
        particle_bounds: lowest and highest coordinates that particles may have [m].
        control: changes the time step during the run; None where what is stable stays the same.
        share_count: into how many shares launches may be split: so many sums does a step add up,
            in one order, whether the shares run one after the other or at the same time.
        remedy: what may help where a run diverges.
        particle_count: particles at the start.
        arrays: by name, "particle.mass" say; the first word tells over what they run.
        step: the launches of one step, in order.
        audited_step: the same with an audit of energy in it, to be taken now and then; or none.
    """

    precision: Precision
    time_step: float
    longest_time_step: float
    speed_limit: float
    particle_bounds: tuple[Floats, Floats]
    control: TimeStepControl | None = None
    share_count: int = 1
    remedy: str = "try a smaller time_step_fraction"
    particle_count: int = 0
    arrays: dict[str, Array] = field(default_factory=dict)
    step: list[Launch] = field(default_factory=list)
    audited_step: list[Launch] = field(default_factory=list)

    @property
    def launches(self) -> list[Launch]:
        """Every launch of the run, those of a step first."""
        return [*self.step, *(it for it in self.audited_step if it not in self.step)]

    def add_array(self, name: str, kind: str, values: np.ndarray) -> str:
        """Add an array that starts with the given values; `kind` is a type of the precision."""
        dtype = self._dtype(kind)
        components = getattr(dtype, "_shape_", ())
        shape = values.shape[: values.ndim - len(components)]
        scalar = np.int32 if kind in WHOLE else self.precision.numpy_name
        initial = np.array(values, dtype=scalar, order="C")
        self.arrays[name] = Array(dtype=dtype, shape=shape, initial=initial)
        return name

    def add_zeros(self, name: str, kind: str, shape: int | tuple[int, ...]) -> str:
        """Add an array that starts with zeros."""
        self.arrays[name] = Array(dtype=self._dtype(kind), shape=_tuple(shape), initial=None)
        return name

    def add_launch(self, kernel: Any, dim: int | tuple[int, ...], *arguments: Any) -> None:
        """Add a launch to the end of the step."""
        self.step.append(Launch(kernel=kernel, dim=_tuple(dim), arguments=arguments))

    def _dtype(self, kind: str) -> Any:
        return WHOLE[kind] if kind in WHOLE else getattr(self.precision, kind)


@dataclass(kw_only=True, eq=False)
class Plan(StepPlan):
    """All that a run of a scene consists of.

    Attributes:
        scene: what is run.
        admission: the launch by which a layer of soil enters; None where there is no window.
    """

    scene: Scene
    admission: Launch | None = None

    @property
    def launches(self) -> list[Launch]:
        """See `StepPlan`."""
        launches = super().launches
        return launches if self.admission is None else [*launches, self.admission]


def _tuple(lengths: int | tuple[int, ...]) -> tuple[int, ...]:
    return lengths if isinstance(lengths, tuple) else (lengths,)
