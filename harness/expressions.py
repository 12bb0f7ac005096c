"""Arithmetic expressions in study files, for derived parameters, exclusions and formulas.

An expression is parsed by Python's `ast` and evaluated here node by node; it is never executed as
Python code. It may have what `ALLOWED` lists. All numbers are floats: a power of integers could
otherwise grow without bound.
"""

import ast
import math
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Self

from mpm_warp.fields.declaration import Schema, Value
from mpm_warp.fields.names import nearest_name

LONGEST_EXPRESSION = 200
"""Characters that an expression may have; this limits its depth too."""

NUMBER_OPERATORS: dict[type[ast.AST], Callable[..., Value]] = {
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
EQUALITY_OPERATORS: dict[type[ast.AST], Callable[..., bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
FUNCTIONS: dict[str, Callable[..., float]] = {
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "log10": math.log10,
    "ln": math.log,
    "tan": lambda degrees: math.tan(math.radians(degrees)),
    "round": lambda number: float(round(number)),
    "min": min,
    "max": max,
}
"""Functions by name. Angles are in degrees, like parameters; `log` and `ln` are both natural."""
ALLOWED = "numbers, texts, parameters, + - * / **, comparisons, and, or, not, " + ", ".join(
    f"{name}()" for name in FUNCTIONS
)


class ExpressionError(ValueError):
    """An expression is malformed or has no value; the message is one phrase."""


Parameters = Mapping[str, Value | None]
Evaluator = Callable[[Parameters], Value]
"""Computes the value of a part of an expression from the values of the parameters."""


@dataclass(frozen=True)
class Expression:
    """A valid expression."""

    text: str  # as given in the file
    names: frozenset[str]  # the parameters that it uses
    is_condition: bool  # whether its value is true or false instead of a number
    evaluator: Evaluator = field(compare=False, repr=False)

    @classmethod
    def parsed(cls, text: object) -> Self:
        """Parse an expression.

        Raises:
            ExpressionError: it is malformed, or has something that is not allowed.
        """
        if not isinstance(text, str) or not text.strip():
            raise ExpressionError('must be an expression in quotes, such as "2 * penetration"')
        if len(text) > LONGEST_EXPRESSION:
            raise ExpressionError(
                f"has {len(text)} characters; an expression has at most {LONGEST_EXPRESSION}"
            )
        tree = _tree(text)
        evaluator = _evaluator(tree)
        called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
        dotted = {n.value: n for n in ast.walk(tree) if isinstance(n, ast.Attribute)}
        named = (n for n in ast.walk(tree) if isinstance(n, ast.Name) and id(n) not in called)
        names = (ast.unparse(dotted.get(n, n)) for n in named)
        is_negation = isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.Not)
        is_condition = is_negation or isinstance(tree, ast.Compare | ast.BoolOp)
        return cls(text, frozenset(names), is_condition, evaluator)

    def value(self, parameters: Parameters) -> Value:
        """Its value for these parameters.

        Raises:
            ExpressionError: it has none, as after a division by zero.
        """
        try:
            value = self.evaluator(parameters)
        except (ArithmeticError, ValueError, TypeError) as error:
            raise ExpressionError(f"{self.text!r} has no value: {error}") from None
        if isinstance(value, float) and not math.isfinite(value):
            raise ExpressionError(f"{self.text!r} has no value: it is {value}")
        return value

    def is_true(self, parameters: Parameters) -> bool:
        """Whether the condition holds for these parameters.

        Raises:
            ExpressionError: it has no value, or its value is not true or false.
        """
        value = self.value(parameters)
        if not isinstance(value, bool):
            raise ExpressionError(f"{self.text!r} is {value!r}, neither true nor false")
        return value


def _tree(text: str) -> ast.expr:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Python's warnings about style
            return ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise ExpressionError(f"is not an expression; allowed: {ALLOWED}") from None


def _evaluator(node: ast.expr) -> Evaluator:
    """The evaluator of a node of the syntax tree; a node that is not allowed raises an error."""
    match node:
        case ast.Constant(value=bool() | int() | float() | str() as constant):
            return lambda _: _operand("", constant)
        case ast.Name() | ast.Attribute(value=ast.Name()):
            name = ast.unparse(node)
            return lambda given: _operand(name, given.get(name))
        case ast.BinOp(op=op, left=left, right=right) if type(op) in NUMBER_OPERATORS:
            function, nodes = NUMBER_OPERATORS[type(op)], [left, right]
        case ast.UnaryOp(op=op, operand=operand) if type(op) in NUMBER_OPERATORS:
            function, nodes = NUMBER_OPERATORS[type(op)], [operand]
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return _function_evaluator(operator.not_, bool, operand)
        case ast.BoolOp(op=op, values=values):
            decide, parts = all if isinstance(op, ast.And) else any, [*map(_evaluator, values)]
            return lambda given: decide(_typed(bool, part(given)) for part in parts)
        case ast.Compare(left=left, ops=ops, comparators=others) if all(
            type(op) in NUMBER_OPERATORS or type(op) in EQUALITY_OPERATORS for op in ops
        ):
            links = [*map(_comparison_evaluator, ops, [left, *others], others)]
            return lambda given: all(link(given) for link in links)
        case ast.Call(func=ast.Name(id=name), args=nodes, keywords=[]):
            if name not in FUNCTIONS:
                raise ExpressionError(f"unknown function {name!r}{nearest_name(name, FUNCTIONS)}")
            function = FUNCTIONS[name]
        case _:
            raise ExpressionError(f"{ast.unparse(node)!r} is not allowed; allowed: {ALLOWED}")
    return _function_evaluator(function, float, *nodes)


def _comparison_evaluator(op: ast.cmpop, left: ast.expr, right: ast.expr) -> Evaluator:
    if type(op) in NUMBER_OPERATORS:
        return _function_evaluator(NUMBER_OPERATORS[type(op)], float, left, right)
    sides = _evaluator(left), _evaluator(right)

    def holds(given: Parameters) -> bool:
        one, other = (side(given) for side in sides)
        if type(one) is not type(other):
            raise TypeError(f"{one!r} and {other!r} cannot be equal")
        return EQUALITY_OPERATORS[type(op)](one, other)

    return holds


def _function_evaluator(
    function: Callable[..., Value], kind: type[Value], *nodes: ast.expr
) -> Evaluator:
    """The evaluator of a function whose arguments all have one type, float or bool."""
    parts = [*map(_evaluator, nodes)]
    return lambda given: function(*(_typed(kind, part(given)) for part in parts))


def _typed(kind: type[Value], value: Value) -> Value:
    if not isinstance(value, kind):
        problem = "not a number" if kind is float else "neither true nor false"
        raise TypeError(f"{value!r} is {problem}")
    return value


def _operand(name: str, value: Value | None) -> Value:
    """A constant or the value of a parameter; every number becomes a float."""
    if value is None:
        raise ExpressionError(f"{name} has no value here, unless the study gives it one")
    return value if isinstance(value, (str, bool)) else float(value)


def expression_schema() -> Schema:
    """The JSON schema of an expression; what it means is checked by the harness."""
    return {"type": "string", "minLength": 1, "maxLength": LONGEST_EXPRESSION}
