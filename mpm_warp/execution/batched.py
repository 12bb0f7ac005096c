"""Batched plan: several runs as one run, in which each launch of a step works on all of them.

Its kernels are made from the sources of those for one case. Every array gets a first axis, the
case. Every real number becomes an array over cases:

    kernel of one case     x[i], a                launched over items i
    batched kernel         x[case, i], a[case]    launched over cases and chunks of their items

A thread works through one chunk. A chunk is one item on a GPU, which has a thread for each item. On
a processor it is all items of a case, so that the views of its arrays are made only once.
"""

import ast
import functools
import inspect
import textwrap
import types
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from mpm_warp.plan.launch import Launch, ShareRow
from mpm_warp.plan.plan import Plan

OF_CASES = "_of_cases"


@functools.cache
def make_batched_kernel(kernel: Any) -> Any:
    """The batched kernel; its first two arguments are the items of a case and those of a chunk.

    The last index of a thread counts the items, so they keep their order.

    Args:
        kernel: a kernel that assigns ``wp.tid()`` once, in a statement of its own, or never, and
            that does not return from within a loop.

    Raises:
        NotImplementedError: the kernel returns from within a loop.
    """
    own = [name for name, kind in _arguments(kernel) if _is_array(kind) or _is_real(kind)]
    signature = {"item_count": int, "chunk_size": int}
    for name, kind in _arguments(kernel):
        signature[name + OF_CASES if name in own else name] = _batched(kind)
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
        source=_batched_source(source, own),  # Warp knows compiled kernels by their source
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
    return getattr(kind, "_wp_scalar_type_", kind) in {wp.float64, wp.float32}


def _batched(kind: Any) -> Any:
    if _is_array(kind):
        return wp.array(dtype=kind.dtype, ndim=kind.ndim + 1)
    return wp.array(dtype=kind) if _is_real(kind) else kind


def _batched_source(function: Any, own: list[str]) -> str:
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    return ast.unparse(ast.fix_missing_locations(_LoopOverChunk(own).visit(tree)))


class _LoopOverChunk(ast.NodeTransformer):
    """Puts the body of a kernel into a loop over a chunk of the items of a case.

    Args:
        own: names of the arguments of which each case has its own.
    """

    def __init__(self, own: list[str]) -> None:
        self._own = own
        self._is_in_loop = False

    def visit_FunctionDef(self, function: ast.FunctionDef) -> ast.FunctionDef:
        body: list[ast.stmt] = []
        item, others = "item", list[str]()
        for statement in map(self.visit, function.body):
            match statement:
                case ast.Assign(targets=[ast.Tuple(elts=names)], value=value) if _is_index(value):
                    *others, item = map(ast.unparse, names)
                case ast.Assign() if any(map(_is_index, ast.walk(statement))):
                    body += ast.parse(ast.unparse(statement).replace("wp.tid()", item)).body
                case _:
                    body.append(statement)
        views = "\n".join(f"{name} = {name}{OF_CASES}[case]" for name in self._own)
        begin = ast.parse(
            f"{', '.join(['case', *others, 'chunk'])} = wp.tid()\n"
            f"{views}\n"
            "begin = chunk * chunk_size\n"
            f"for {item} in range(begin, wp.min(begin + chunk_size, item_count)): pass"
        ).body
        loop = begin[-1]
        assert isinstance(loop, ast.For)
        loop.body = body
        function.body = begin
        function.decorator_list = []
        for argument in function.args.args:
            if argument.arg in self._own:
                argument.arg += OF_CASES
        function.args.args[:0] = [ast.arg("item_count"), ast.arg("chunk_size")]
        return function

    def visit_For(self, loop: ast.For) -> ast.AST:
        outside, self._is_in_loop = self._is_in_loop, True
        self.generic_visit(loop)
        self._is_in_loop = outside
        return loop

    def visit_Return(self, statement: ast.Return) -> ast.stmt:
        if self._is_in_loop:
            raise NotImplementedError("a batched kernel cannot be left from within a loop")
        return ast.Continue()


def _is_index(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and ast.unparse(node) == "wp.tid()"


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
            values = [own.arguments[position] for own in alike]
            batched[name] = wp.array(values, dtype=kind, device=device)
            arguments[position] = name
        over_all[launch] = BatchedLaunch(
            kernel=make_batched_kernel(launch.kernel),
            dim=launch.dim,
            arguments=tuple(arguments),
            case_count=len(plans),
            chunk_size=chunk_size,
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
