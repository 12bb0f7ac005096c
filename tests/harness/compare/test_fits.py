"""Fits: order and limit of values on finer and finer meshes; a fit by columns of a matrix."""

import numpy as np
import pytest

from harness.compare.convergence import approach, order_of_error
from harness.compare.linear_fit import linear_fit, shared_variance

WIDTHS = 1.0 / np.array([2.0, 4.0, 8.0, 16.0])


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_order_and_limit_are_found_again(order: float) -> None:
    found = approach(WIDTHS, 10.0 + 3.0 * WIDTHS**order)
    # The order is interpolated between two 0.01 apart, of a function that curves by order 1:
    # so it is off by some 0.01**2 / 8 of it.
    assert found.order == pytest.approx(order, abs=2e-5)
    assert found.limit == pytest.approx(10.0, abs=1e-4)
    assert found.at(WIDTHS) == pytest.approx(10.0 + 3.0 * WIDTHS**order, abs=1e-3)


@pytest.mark.parametrize(
    "values",
    [
        [10.0, 10.4, 10.2, 10.3],  # to and fro
        [10.0, 10.1, 10.3, 10.7],  # by more and more
        [10.0, 10.0, 10.0, 10.0],  # no change
        [10.0, np.nan, np.nan, 10.1],  # too few
        [10.0, 10.5, 10.001, 10.0],  # too fast for a scheme of any order
    ],
)
def test_values_that_are_not_on_their_way_to_a_limit_have_no_order(values: list[float]) -> None:
    assert approach(WIDTHS, np.array(values)) is None


def test_an_error_has_the_order_between_the_two_finest() -> None:
    finest_first = WIDTHS[::-1]
    assert order_of_error(finest_first, finest_first**2) == pytest.approx(2.0)
    assert order_of_error(finest_first, np.array([np.nan, 0.0, -1.0, 1.0])) is None


RANDOM = np.random.default_rng(2)
INDEX, ADHESION, NOISE = (RANDOM.uniform(0.0, 1.0, 30) for _ in range(3))


def test_a_fit_by_columns_that_depend_on_others_leaves_out_as_one_by_the_others() -> None:
    one = np.stack([np.ones(30), INDEX], axis=1)
    twice = np.hstack([one, 3.0 * one])
    np.testing.assert_allclose(linear_fit(twice, NOISE).left_out, linear_fit(one, NOISE).left_out)
    without_first = linear_fit(one[1:], NOISE[1:]).weights
    assert NOISE[0] - one[0] @ without_first == pytest.approx(linear_fit(one, NOISE).left_out[0])
    assert linear_fit(one, 2.0 * INDEX).explained(2.0 * INDEX) == pytest.approx(1.0)
    centred = [column[:, None] - column.mean() for column in (INDEX, ADHESION)]
    share = np.corrcoef(INDEX, ADHESION)[0, 1] ** 2
    assert shared_variance(*centred) == pytest.approx(share)
