"""Small arithmetic in study definitions: for derived parameters and for exclusions.

An expression is read into Python's syntax tree and worked out here, node by node; nothing is
executed. It has what `ALLOWED` says. Numbers are floats, so that no power grows without bound.
"""

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Self

from mpm_warp.parameters import Value, nearest_name

LONGEST = 200
"""Characters that an expression may have, which bounds its depth too."""

OF_NUMBERS: dict[type[ast.AST], Callable[..., Value]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
EQUALITY: dict[type[ast.AST], Callable[..., bool]] = {ast.Eq: operator.eq, ast.NotEq: operator.ne}
FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "ln": math.log,
    "tan": lambda degrees: math.tan(math.radians(degrees)),
    "round": lambda number: float(round(number)),
    "min": min,
    "max": max,
}
"""Angles are in degrees, as those of parameters are; `log` and `ln` are the natural logarithm."""
ALLOWED = "numbers, texts, parameters, + - * / **, comparisons, and, or, not, " + ", ".join(
    f"{name}()" for name in FUNCTIONS
)


class ExpressionError(ValueError):
    """An expression is malformed or has no value; the message is one phrase."""


Parameters = Mapping[str, Value | None]
Meaning = Callable[[Parameters], Value]
"""What works a piece of an expression out, from the values of the parameters."""


@dataclass(frozen=True)
class Expression:
    """A well-formed expression."""

    text: str  # as it was written
    names: frozenset[str]  # the parameters that it needs
    is_condition: bool  # whether it is true or false, no number
    meaning: Meaning = field(compare=False, repr=False)

    @classmethod
    def parsed(cls, text: object) -> Self:
        """Read an expression."""
        if not isinstance(text, str) or not text.strip():
            raise ExpressionError('must be an expression in a text, as "2 * penetration"')
        if len(text) > LONGEST:
            raise ExpressionError(
                f"has {len(text)} characters; an expression has at most {LONGEST}"
            )
        tree = _tree(text)
        meaning = _meaning(tree)
        called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
        names = (n for n in ast.walk(tree) if isinstance(n, ast.Name) and id(n) not in called)
        is_negation = isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.Not)
        is_condition = is_negation or isinstance(tree, ast.Compare | ast.BoolOp)
        return cls(text, frozenset(name.id for name in names), is_condition, meaning)

    def value(self, parameters: Parameters) -> Value:
        """Work it out."""
        try:
            value = self.meaning(parameters)
        except (ArithmeticError, ValueError, TypeError) as error:
            raise ExpressionError(f"{self.text!r} has no value: {error}") from None
        if isinstance(value, float) and not math.isfinite(value):
            raise ExpressionError(f"{self.text!r} has no value: it is {value}")
        return value

    def is_true(self, parameters: Parameters) -> bool:
        """Work out a condition."""
        value = self.value(parameters)
        if not isinstance(value, bool):
            raise ExpressionError(f"{self.text!r} is {value!r}, neither true nor false")
        return value


def _tree(text: str) -> ast.expr:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # remarks on style, to whoever writes programs
            return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise ExpressionError(f"is no expression; allowed: {ALLOWED}") from None


def _meaning(node: ast.expr) -> Meaning:
    """What works out one of the few things that an expression may have; others are refused."""
    match node:
        case ast.Constant(value=bool() | int() | float() | str() as constant):
            return lambda _: _plain("", constant)
        case ast.Name(id=name):
            return lambda given: _plain(name, given[name])
        case ast.BinOp(op=op, left=left, right=right) if type(op) in OF_NUMBERS:
            function, nodes = OF_NUMBERS[type(op)], [left, right]
        case ast.UnaryOp(op=op, operand=operand) if type(op) in OF_NUMBERS:
            function, nodes = OF_NUMBERS[type(op)], [operand]
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return _applied(operator.not_, bool, operand)
        case ast.BoolOp(op=op, values=values):
            decide, parts = all if isinstance(op, ast.And) else any, [*map(_meaning, values)]
            return lambda given: decide(_of_kind(bool, part(given)) for part in parts)
        case ast.Compare(left=left, ops=ops, comparators=others) if all(
            type(op) in OF_NUMBERS or type(op) in EQUALITY for op in ops
        ):
            links = [*map(_compared, ops, [left, *others], others)]
            return lambda given: all(link(given) for link in links)
        case ast.Call(func=ast.Name(id=name), args=nodes, keywords=[]):
            if name not in FUNCTIONS:
                raise ExpressionError(f"unknown function {name!r}{nearest_name(name, FUNCTIONS)}")
            function = FUNCTIONS[name]
        case _:
            raise ExpressionError(f"{ast.unparse(node)!r} is not allowed; allowed: {ALLOWED}")
    return _applied(function, float, *nodes)


def _compared(op: ast.cmpop, left: ast.expr, right: ast.expr) -> Meaning:
    if type(op) in OF_NUMBERS:
        return _applied(OF_NUMBERS[type(op)], float, left, right)
    sides = _meaning(left), _meaning(right)

    def holds(given: Parameters) -> bool:
        one, other = (side(given) for side in sides)
        if type(one) is not type(other):
            raise TypeError(f"{one!r} and {other!r} cannot be equal")
        return EQUALITY[type(op)](one, other)

    return holds


def _applied(function: Callable[..., Value], kind: type[Value], *nodes: ast.expr) -> Meaning:
    """The meaning of a function of numbers, or of truths."""
    parts = [*map(_meaning, nodes)]
    return lambda given: function(*(_of_kind(kind, part(given)) for part in parts))


def _of_kind(kind: type[Value], value: Value) -> Value:
    if not isinstance(value, kind):
        told = "not a number" if kind is float else "neither true nor false"
        raise TypeError(f"{value!r} is {told}")
    return value


def _plain(name: str, value: Value | None) -> Value:
    """A value in which a number is a float, whatever it is written as."""
    if value is None:
        raise ExpressionError(f"{name} is what the scene derives itself; give it a value")
    return value if isinstance(value, (str, bool)) else float(value)
