"""Small arithmetic in study definitions: for derived parameters and for exclusions.

An expression is read into Python's syntax tree and worked out here, node by node; nothing is
executed. It has numbers, texts, names of parameters, ``+ - * / **``, comparisons, ``and``, ``or``,
``not`` and a few functions. Numbers are floats, so that no power grows without bound.
"""

from __future__ import annotations

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from mpm_warp.parameters import Value, nearest_name

LONGEST = 200
"""Characters that an expression may have, which bounds its depth too."""

ARITHMETIC: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: math.pow,
}
ORDER: dict[type[ast.cmpop], Callable[[float, float], bool]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
EQUALITY: dict[type[ast.cmpop], Callable[[Value, Value], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
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


@dataclass(frozen=True)
class Expression:
    """A well-formed expression: as it was written, the parameters that it needs, its syntax."""

    text: str
    names: frozenset[str]
    tree: ast.expr = field(compare=False, repr=False)

    @classmethod
    def parsed(cls, text: object) -> Expression:
        """Read an expression."""
        if not isinstance(text, str) or not text.strip():
            raise ExpressionError('must be an expression in a text, as "2 * penetration"')
        if len(text) > LONGEST:
            raise ExpressionError(
                f"has {len(text)} characters; an expression has at most {LONGEST}"
            )
        tree = _tree(text)
        _check(tree)
        called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
        names = (n for n in ast.walk(tree) if isinstance(n, ast.Name) and id(n) not in called)
        return cls(text, frozenset(name.id for name in names), tree)

    @property
    def is_condition(self) -> bool:
        """Whether it is true or false, no number."""
        is_negation = isinstance(self.tree, ast.UnaryOp) and isinstance(self.tree.op, ast.Not)
        return is_negation or isinstance(self.tree, ast.Compare | ast.BoolOp)

    def value(self, parameters: Mapping[str, Value | None]) -> Value:
        """Work it out."""
        try:
            value = _value(self.tree, parameters)
        except (ArithmeticError, ValueError, TypeError) as error:
            raise ExpressionError(f"{self.text!r} has no value: {error}") from None
        if isinstance(value, float) and not math.isfinite(value):
            raise ExpressionError(f"{self.text!r} has no value: it is {value}")
        return value

    def is_true(self, parameters: Mapping[str, Value | None]) -> bool:
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


def _check(node: ast.expr) -> None:
    """Refuse what is not among the few things that an expression may have."""
    match node:
        case ast.Constant(value=bool() | int() | float() | str()) | ast.Name():
            return
        case ast.BinOp(left=left, op=op, right=right) if type(op) in ARITHMETIC:
            parts = [left, right]
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() | ast.Not(), operand=operand):
            parts = [operand]
        case ast.BoolOp(values=parts):
            pass
        case ast.Compare(left=left, ops=ops, comparators=others) if all(
            type(op) in ORDER or type(op) in EQUALITY for op in ops
        ):
            parts = [left, *others]
        case ast.Call(func=ast.Name(id=name), args=parts, keywords=[]):
            if name not in FUNCTIONS:
                raise ExpressionError(f"unknown function {name!r}{nearest_name(name, FUNCTIONS)}")
        case _:
            raise ExpressionError(f"{ast.unparse(node)!r} is not allowed; allowed: {ALLOWED}")
    for part in parts:
        _check(part)


def _value(node: ast.expr, parameters: Mapping[str, Value | None]) -> Value:
    value: Value
    match node:
        case ast.Constant(value=str() | bool() | int() | float() as constant):
            value = constant
        case ast.Name(id=name):
            given = parameters[name]
            if given is None:
                raise ExpressionError(f"{name} is what the scene derives itself; give it a value")
            value = given
        case ast.BinOp(left=left, op=op, right=right):
            value = ARITHMETIC[type(op)](_number(left, parameters), _number(right, parameters))
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            value = not _truth(operand, parameters)
        case ast.UnaryOp(op=op, operand=operand):
            number = _number(operand, parameters)
            value = -number if isinstance(op, ast.USub) else number
        case ast.BoolOp(op=op, values=parts):
            decide = all if isinstance(op, ast.And) else any
            value = decide(_truth(part, parameters) for part in parts)
        case ast.Compare():
            value = _compared(node, parameters)
        case ast.Call(func=ast.Name(id=name), args=parts):
            value = FUNCTIONS[name](*(_number(part, parameters) for part in parts))
        case _:
            raise AssertionError(f"{ast.dump(node)} has passed the check")
    # A number is a float, whatever it is written as.
    return value if isinstance(value, (str, bool)) else float(value)


def _compared(node: ast.Compare, parameters: Mapping[str, Value | None]) -> bool:
    left = node.left
    for op, right in zip(node.ops, node.comparators, strict=True):
        if type(op) in ORDER:
            holds = ORDER[type(op)](_number(left, parameters), _number(right, parameters))
        else:
            values = _value(left, parameters), _value(right, parameters)
            if type(values[0]) is not type(values[1]):
                raise TypeError(f"{values[0]!r} and {values[1]!r} cannot be equal")
            holds = EQUALITY[type(op)](*values)
        if not holds:
            return False
        left = right
    return True


def _number(node: ast.expr, parameters: Mapping[str, Value | None]) -> float:
    value = _value(node, parameters)
    if not isinstance(value, float):
        raise TypeError(f"{value!r} is not a number")
    return value


def _truth(node: ast.expr, parameters: Mapping[str, Value | None]) -> bool:
    value = _value(node, parameters)
    if not isinstance(value, bool):
        raise TypeError(f"{value!r} is neither true nor false")
    return value
