"""Several runs as one: each launch of a step is over all of them."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from mpm_warp.execution.over_cases import make_over_cases, numbers_of
from mpm_warp.plan.launch import Launch, ShareRow
from mpm_warp.plan.plan import Plan


@dataclass(frozen=True, kw_only=True, eq=False)
class StackedLaunch(Launch):
    """A launch over several cases; `dim`, and what is shared, are those of one of them.

    Attributes:
        case_count: how many cases: the length of the first axis of every array.
        chunk_size: items of a case that a thread does; None: all.
    """

    share_axis: ClassVar[int] = 1
    case_count: int
    chunk_size: int | None

    @property
    def item_count(self) -> int:
        """See `Launch`."""
        return self.case_count * super().item_count

    def call(self, arrays: Mapping[str, Any]) -> tuple[tuple[int, ...], list[Any]]:
        """See `Launch`."""
        (*others, item_count), arguments = super().call(arrays)
        chunk_size = self.chunk_size or max(1, item_count)
        dim = (self.case_count, *others, -(-item_count // chunk_size))
        return dim, [item_count, chunk_size, *arguments]


def likeness(plan: Plan) -> Hashable:
    """What the plans that can be stacked have in common: all but values of arrays and numbers."""

    def kinds(launch: Launch) -> Iterator[Hashable]:
        numbers = numbers_of(launch.kernel)
        for position, argument in enumerate(launch.arguments):
            name = argument.name if isinstance(argument, ShareRow) else argument
            if isinstance(name, str):
                yield name, plan.arrays[name].dtype, plan.arrays[name].shape
            elif position not in numbers:
                yield argument if isinstance(argument, Hashable) else tuple(argument)

    launches = (*plan.step, *plan.audited_step)
    return tuple((launch.kernel, launch.dim, *kinds(launch)) for launch in launches)


def stack(
    plans: Sequence[Plan],
    arrays: Sequence[dict[str, Any]],
    device: str,
    chunk_size: int | None,
) -> tuple[Plan, dict[str, Any]]:
    """Stack runs whose plans have one likeness.

    Args:
        plans: of the runs.
        arrays: of each run, as it has left them on the device. Those that a step works on are
            replaced by their rows of the stack's.
        device: where they are.
        chunk_size: items of a case that a thread does; None: all.

    Returns:
        A plan whose steps are those of all runs, and its arrays on the device.
    """
    first = plans[0]
    stacked = {name: _joined(name, arrays, device) for name in _names(first)}
    over_all: dict[Launch, Launch] = {}
    for alike in zip(*map(_distinct_launches, plans), strict=True):
        launch = alike[0]
        arguments = list(launch.arguments)
        for position, kind in numbers_of(launch.kernel).items():
            name = f"number.{len(over_all)}.{position}"
            values = [it.arguments[position] for it in alike]
            stacked[name] = wp.array(values, dtype=kind, device=device)
            arguments[position] = name
        over_all[launch] = StackedLaunch(
            kernel=make_over_cases(launch.kernel),
            dim=launch.dim,
            arguments=tuple(arguments),
            case_count=len(plans),
            chunk_size=chunk_size,
        )
    step, audited = ([over_all[it] for it in part] for part in (first.step, first.audited_step))
    return replace(first, arrays={}, step=step, audited_step=audited), stacked


def _distinct_launches(plan: Plan) -> list[Launch]:
    return list(dict.fromkeys([*plan.step, *plan.audited_step]))


def _names(plan: Plan) -> list[str]:
    """Names of the arrays that a step works on."""
    return list(dict.fromkeys(name for it in _distinct_launches(plan) for name in it.arrays))


def _joined(name: str, arrays: Sequence[dict[str, Any]], device: str) -> Any:
    """One array of the arrays of all runs, whose own become rows of it."""
    own = [of_run[name] for of_run in arrays]
    whole = wp.empty((len(own), *own[0].shape), dtype=own[0].dtype, device=device)
    for number, of_run in enumerate(arrays):
        wp.copy(whole[number], own[number])
        of_run[name] = whole[number]
    return whole
