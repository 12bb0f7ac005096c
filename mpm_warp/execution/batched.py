"""Batched plan: several runs as one run, in which each launch of a step works on all of them.

Its kernels are made from the sources of those for one case. Every array gets a first axis, the
case. Every real number becomes an array over cases:

    kernel of one case     x[i], a                launched over items i
    batched kernel         x[case, i], a[case]    launched over cases and items
"""

import ast
import functools
import inspect
import textwrap
import types
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from mpm_warp.kernel_types import real
from mpm_warp.plan.launch import Launch, ShareRow
from mpm_warp.plan.plan import Plan

OF_CASES = "_of_cases"


@functools.cache
def make_batched_kernel(kernel: Any) -> Any:
    """The batched kernel, launched over cases and items; the items of a case keep their order.

    Args:
        kernel: a kernel that assigns ``wp.tid()`` once, in a statement of its own, or never.
    """
    own = [name for name, kind in _arguments(kernel) if _is_array(kind) or _is_real(kind)]
    signature = {
        f"{name}{OF_CASES}" if name in own else name: _batched(kind)
        for name, kind in _arguments(kernel)
    }
    source = kernel.func
    function: Any = types.FunctionType(
        source.__code__, source.__globals__, source.__name__, None, source.__closure__
    )
    function.__annotations__ = signature
    function.__signature__ = inspect.Signature(
        [
            inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=kind)
            for name, kind in signature.items()
        ]
    )
    return wp.Kernel(
        function,
        key=f"{kernel.key}{OF_CASES}",
        module=wp.get_module(f"{kernel.module.name}{OF_CASES}"),
        options=kernel.options,
        source=_batched_source(source, signature, own),  # Warp knows compiled kernels by it
    )


def real_arguments(kernel: Any) -> dict[int, Any]:
    """Positions and types of the arguments that are real numbers, or vectors of them.

    Each case has its own; integers are the same for all cases.
    """
    arguments = enumerate(_arguments(kernel))
    return {position: kind for position, (_, kind) in arguments if _is_real(kind)}


def _arguments(kernel: Any) -> list[tuple[str, Any]]:
    """Names and types of the arguments."""
    return [(argument.label, argument.type) for argument in kernel.adj.args]


def _is_array(kind: Any) -> bool:
    """Whether an argument is an array, written as `wp.array(dtype=...)` or as `wp.array[...]`."""
    return hasattr(kind, "ndim")


def _is_real(kind: Any) -> bool:
    return getattr(kind, "_wp_scalar_type_", kind) is real


def _batched(kind: Any) -> Any:
    if _is_array(kind):
        return wp.array(dtype=kind.dtype, ndim=kind.ndim + 1)
    return wp.array(dtype=kind) if _is_real(kind) else kind


def _batched_source(function: Any, arguments: Iterable[str], own: list[str]) -> str:
    """The source with an index more, the case, and the view of a case for each array of cases."""
    (definition,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
    assert isinstance(definition, ast.FunctionDef)
    indices, body = ["item"], list[str]()
    for statement in definition.body:
        match statement:
            case ast.Assign(targets=[ast.Tuple(elts=names)], value=value) if _is_index(value):
                indices = [ast.unparse(name) for name in names]
            case _:
                body.append(ast.unparse(statement).replace("wp.tid()", "item"))
    views = [f"{name} = {name}{OF_CASES}[case]" for name in own]
    lines = [f"case, {', '.join(indices)} = wp.tid()", *views, *body]
    head = f"def {definition.name}({', '.join(arguments)}):\n"
    return head + textwrap.indent("\n".join(lines), "    ")


def _is_index(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and ast.unparse(node) == "wp.tid()"


@dataclass(frozen=True, kw_only=True, eq=False)
class BatchedLaunch(Launch):
    """A launch over several cases.

    `dim` is that of one case, and shares are shares of each case.

    Attributes:
        case_count: number of cases: the length of the first axis of every array.
    """

    share_axis: ClassVar[int] = 1
    case_count: int

    @property
    def item_count(self) -> int:
        """How many times the kernel runs, over all cases."""
        return self.case_count * super().item_count

    def call(self, arrays: Mapping[str, Any]) -> tuple[tuple[int, ...], list[Any]]:
        """The threads over which the batched kernel is launched, and its arguments.

        Args:
            arrays: the arrays of the batched plan on a device, by name.
        """
        dim, arguments = super().call(arrays)
        return (self.case_count, *dim), arguments


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
    plans: Sequence[Plan], arrays: Sequence[dict[str, Any]], device: str
) -> tuple[Plan, dict[str, Any]]:
    """Make one plan of the plans of several runs.

    Args:
        plans: plans of the runs, all of one batch key.
        arrays: arrays of each run on the device, in their present state. Those that a step works on
            are replaced by rows of the arrays of the batched plan.
        device: the device.

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
            values = [own.arguments[position] for own in alike]
            batched[name] = wp.array(values, dtype=kind, device=device)
            arguments[position] = name
        over_all[launch] = BatchedLaunch(
            kernel=make_batched_kernel(launch.kernel),
            dim=launch.dim,
            arguments=tuple(arguments),
            case_count=len(plans),
        )
    step, audited = ([over_all[one] for one in part] for part in (first.step, first.audited_step))
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
