"""Batched plan: several runs as one run, in which each launch of a step works on all of them."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from mpm_warp.execution.batched_kernel import make_batched_kernel, real_arguments
from mpm_warp.plan.launch import Launch, ShareRow
from mpm_warp.plan.plan import Plan


@dataclass(frozen=True, kw_only=True, eq=False)
class BatchedLaunch(Launch):
    """A launch over several cases.

    `dim` is that of one case, and shares are shares of each case.

    Attributes:
        case_count: number of cases: the length of the first axis of every array.
        chunk_size: items of a case that one thread does; None: all of them.
    """

    share_axis: ClassVar[int] = 1
    case_count: int
    chunk_size: int | None

    @property
    def item_count(self) -> int:
        """How many times the kernel of one case runs, over all cases."""
        return self.case_count * super().item_count

    def call(self, arrays: Mapping[str, Any]) -> tuple[tuple[int, ...], list[Any]]:
        """The threads over which the batched kernel is launched, and its arguments.

        Args:
            arrays: the arrays of the batched plan on a device, by name.
        """
        (*others, item_count), arguments = super().call(arrays)
        chunk_size = self.chunk_size or max(1, item_count)
        dim = (self.case_count, *others, -(-item_count // chunk_size))
        return dim, [item_count, chunk_size, *arguments]


def batch_key(plan: Plan) -> Hashable:
    """What plans have in common that can be batched: all but values of arrays and real numbers."""

    def common(launch: Launch) -> Iterator[Hashable]:
        reals = real_arguments(launch.kernel)
        for position, argument in enumerate(launch.arguments):
            name = argument.name if isinstance(argument, ShareRow) else argument
            if isinstance(name, str):
                yield name, plan.arrays[name].dtype, plan.arrays[name].shape
            elif position not in reals:
                yield argument if isinstance(argument, Hashable) else tuple(argument)

    launches = (*plan.step, *plan.audited_step)
    return tuple((launch.kernel, launch.dim, *common(launch)) for launch in launches)


def batched_plan(
    plans: Sequence[Plan],
    arrays: Sequence[dict[str, Any]],
    device: str,
    chunk_size: int | None,
) -> tuple[Plan, dict[str, Any]]:
    """Make one plan of the plans of several runs.

    Args:
        plans: plans of the runs, all of one batch key.
        arrays: arrays of each run on the device, in their present state. Those that a step works on
            are replaced by rows of the arrays of the batched plan.
        device: the device.
        chunk_size: items of a case that one thread does; None: all of them.

    Returns:
        A plan whose steps are those of all runs, and its arrays on the device.
    """
    first = plans[0]
    names = dict.fromkeys(name for launch in _distinct_launches(first) for name in launch.arrays)
    batched = {name: _joined(name, arrays, device) for name in names}
    over_all: dict[Launch, Launch] = {}
    for alike in zip(*map(_distinct_launches, plans), strict=True):
        launch = alike[0]
        arguments = list(launch.arguments)
        for position, kind in real_arguments(launch.kernel).items():
            name = f"argument.{len(over_all)}.{position}"
            values = [it.arguments[position] for it in alike]
            batched[name] = wp.array(values, dtype=kind, device=device)
            arguments[position] = name
        over_all[launch] = BatchedLaunch(
            kernel=make_batched_kernel(launch.kernel),
            dim=launch.dim,
            arguments=tuple(arguments),
            case_count=len(plans),
            chunk_size=chunk_size,
        )
    step, audited = ([over_all[it] for it in part] for part in (first.step, first.audited_step))
    return replace(first, arrays={}, step=step, audited_step=audited), batched


def _distinct_launches(plan: Plan) -> list[Launch]:
    return list(dict.fromkeys([*plan.step, *plan.audited_step]))


def _joined(name: str, arrays: Sequence[dict[str, Any]], device: str) -> Any:
    """The arrays of one name of all runs as one array; the runs get its rows instead."""
    of_runs = [of_run[name] for of_run in arrays]
    whole = wp.empty((len(of_runs), *of_runs[0].shape), dtype=of_runs[0].dtype, device=device)
    for number, of_run in enumerate(arrays):
        wp.copy(whole[number], of_runs[number])
        of_run[name] = whole[number]
    return whole
