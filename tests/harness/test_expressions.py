"""What stands for a value in a study: arithmetic, and that it can nothing else; distributions."""

import math
from pathlib import Path

import numpy as np
import pytest

from harness.expressions import LONGEST_EXPRESSION, Expression, ExpressionError
from harness.study.distributions import INPUT, sampled
from mpm_warp.errors import ParameterError
from mpm_warp.fields.checks import Range
from mpm_warp.fields.declaration import Parameter
from tests.harness.conftest import HEAD, study_in, values

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
        *("__import__('os').system('true')", "().__class__.__bases__", "a.b.real", "a[0]"),
        *("[1, 2]", "{1}", "lambda: 1", "(a := 3)", "[x for x in a]", "f'{a}'"),
        *("open('x')", "max(*a)", "round(1, ndigits=2)"),
        *("a if flag else n", "a is n", "a in n", "a % n", "~n", "1j", "b'x'", "...", "None"),
        *("a = 1", "1; 2", "", "  ", "\0", "\ud800"),
        *("(" * 150, "-" * (LONGEST_EXPRESSION - 1) + "(", "1" * (LONGEST_EXPRESSION + 1)),
        *(7, ["a"]),
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
        ("none + 1", "none has no value here, unless the study gives it one"),
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


def declared(**bounds: float) -> Parameter:
    return Parameter(
        name="x", kind=float, default=0.0, meaning="x", bounds=Range(**bounds), form=INPUT
    )


@pytest.mark.parametrize(
    ("written", "mean", "deviation"),
    [
        (3.0, 3.0, 0.0),
        ({"low": 2.0, "high": 4.0}, 3.0, 2.0 / math.sqrt(12.0)),
        ({"low": 1.0, "high": math.e**2}, (math.e**2 - 1.0) / 2.0, None),
        ({"low": 0.0, "mode": 3.0, "high": 6.0}, 3.0, math.sqrt(1.5)),
        ({"mean": 3.0, "deviation": 0.5}, 3.0, 0.5),
        ({"mean": 3.0, "deviation": 0.9, "shape": "lognormal"}, 3.0, 0.9),
        ({"p10": 1.0, "p50": 2.0, "p90": 3.0}, 2.0, 2.5 / math.sqrt(12.0)),
    ],
)
def test_an_input_has_these_moments(written: object, mean: float, deviation: float | None) -> None:
    """A Latin hypercube of n draws has a mean within its range over n of the exact one."""
    count = 20_000
    drawn = sampled({"x": declared().checked(written)}, count, 1)["x"]
    assert drawn.mean() == pytest.approx(mean, abs=20.0 / count * max(1.0, np.ptp(drawn)))
    if deviation is not None:
        assert drawn.std() == pytest.approx(deviation, abs=20.0 / count * max(1.0, np.ptp(drawn)))


@pytest.mark.parametrize(
    "written",
    [
        *("x", -1.0, True, {}, {"low": 1.0}),
        {"low": 2.0, "high": 1.0},
        {"low": -1.0, "high": 1.0},
        {"mean": 1.0, "deviation": 0.0},
        {"mean": 1.0, "deviation": 1.0, "shape": "beta"},
        {"p10": 2.0, "p90": 1.0},
        {"low": 1.0, "high": "2"},
        {"low": math.nan, "high": 2.0},
    ],
)
def test_a_wrong_input_is_refused_in_one_line(written: object) -> None:
    with pytest.raises(ParameterError, match=r"^x = .* is not allowed: .+$"):
        declared(above=0.0).checked(written)


DRAWN = """design = "latin_hypercube"
samples = 40
seed = 1
[vary]
rigidity_index = { mean = 150, deviation = 60, shape = "lognormal" }
adhesion_factor = { low = 0, mode = 0.5, high = 1 }
stress_anisotropy = { mean = 0.8, deviation = 0.2 }
"""


def test_a_study_draws_each_share_of_a_distribution_once(tmp_path: Path) -> None:
    study = study_in(tmp_path, HEAD + DRAWN)
    index, adhesion, anisotropy = np.array(
        values(study, "rigidity_index", "adhesion_factor", "stress_anisotropy")
    ).T
    share = np.where(adhesion < 0.5, 2.0 * adhesion**2, 1.0 - 2.0 * (1.0 - adhesion) ** 2)
    assert sorted((40 * share).astype(int)) == list(range(40))
    # A mean of one draw from each share is off by less than the range over the number of shares.
    assert index.mean() == pytest.approx(150.0, abs=np.ptp(index) / 40)
    assert index.std() == pytest.approx(60.0, rel=0.1)
    assert 0.9 < anisotropy.max() < 1.0, "what the scene does not allow is moved to its bound"
    assert len(study.cases) == 40
