"""Arithmetic in study definitions: what it can, and that it can nothing else."""

import math

import pytest

from harness.study.expressions import LONGEST, Expression, ExpressionError

PARAMETERS = {"a": 2.0, "n": 3, "flag": True, "word": "tresca", "none": None}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3 - 4 / 8", 6.5),
        ("2 ** 3 ** 2", 512.0),
        ("-a ** 2 + n", -1.0),
        ("(1 + a) * n", 9.0),
        ("min(a, n) + max(1, 2, 3)", 5.0),
        ("sqrt(16) + round(2.6)", 7.0),
        ("tan(45)", math.tan(math.pi / 4)),
        ("a < n <= 3", True),
        ("a < n < 3", False),
        ("word == 'tresca' and not a == 3", True),
        ("word != 'tresca' or flag", True),
    ],
)
def test_values(text: str, value: float) -> None:
    assert Expression.parsed(text).value(PARAMETERS) == value


def test_the_parameters_that_are_needed() -> None:
    assert Expression.parsed("max(a, n) > sqrt(2)").names == {"a", "n"}


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "().__class__.__bases__",
        "a.real",
        "a[0]",
        "[1, 2]",
        "{1}",
        "lambda: 1",
        "(a := 3)",
        "[x for x in a]",
        "f'{a}'",
        "open('x')",
        "max(*a)",
        "round(1, ndigits=2)",
        "a if flag else n",
        "a is n",
        "a in n",
        "a % n",
        "~n",
        "1j",
        "b'x'",
        "...",
        "None",
        "a = 1",
        "1; 2",
        "",
        "  ",
        "\0",
        "\ud800",
        "(" * 150,
        "-" * (LONGEST - 1) + "(",
        "1" * (LONGEST + 1),
        7,
        ["a"],
    ],
)
def test_anything_else_is_refused(text: object) -> None:
    with pytest.raises(ExpressionError) as caught:
        Expression.parsed(text)
    assert "\n" not in str(caught.value).replace("\\n", "")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("1 / (a - 2)", "division by zero"),
        ("9 ** 9 ** 9 ** 9", "math range error|Result too large|out of range"),
        ("(-1) ** 0.5", "math domain error|expected"),
        ("sqrt(-1)", "domain|nonnegative"),
        ("1e308 * 10", "inf"),
        ("word + 1", "'tresca' is not a number"),
        ("flag * 2", "True is not a number"),
        ("word < 'a'", "not a number"),
        ("word == 1", "cannot be equal"),
        ("a and flag", "neither true nor false"),
        ("none + 1", "derives itself"),
        ("sqrt(1, 2)", "argument"),
    ],
)
def test_what_has_no_value_says_why(text: str, why: str) -> None:
    with pytest.raises(ExpressionError, match=why):
        Expression.parsed(text).value(PARAMETERS)


def test_a_condition_is_true_or_false() -> None:
    assert Expression.parsed("a > 1").is_true(PARAMETERS)
    with pytest.raises(ExpressionError, match="neither true nor false"):
        Expression.parsed("a + 1").is_true(PARAMETERS)
