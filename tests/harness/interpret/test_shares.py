"""Shares of an error by cause, against cases whose first-order indices are known."""

import numpy as np
import pytest

from harness.interpret.inference.shares import TOGETHER, error_shares
from harness.study.distributions import normal, sampled

DRAWS = 2048
EVEN = np.ones(DRAWS, dtype=int)


@pytest.mark.parametrize("net", [60.0, 90.0, 120.0, 180.0, 240.0])
def test_one_cause_has_all_of_the_error(net: float) -> None:
    """ln su of soft clay, qnet [kPa], with the error of a test of class 2."""
    drawn = sampled({"test": normal(105.0 / 1.96)}, DRAWS, seed=1)
    values = np.log(np.maximum(net + drawn["test"], 0.01 * net))
    assert error_shares(drawn, values[None], EVEN)[TOGETHER] < 0.01


def test_shares_of_a_sum_are_those_of_its_terms() -> None:
    """Of x + 2 y, independent and of one variance: a fifth and four fifths."""
    drawn = sampled({"x": normal(1.0), "y": normal(1.0)}, DRAWS, seed=1)
    shares = error_shares(drawn, (drawn["x"] + 2.0 * drawn["y"])[None], EVEN)
    assert shares["x"][0] == pytest.approx(0.2, abs=0.01)
    assert shares["y"][0] == pytest.approx(0.8, abs=0.01)
    assert shares[TOGETHER][0] == pytest.approx(0.0, abs=0.01)


def test_shares_of_a_product_are_its_sobol_indices() -> None:
    """Of exp(a x + b y): (exp(a^2) - 1) / (exp(a^2 + b^2) - 1) for x, with b^2 for y."""
    a, b = 0.5, 0.4
    drawn = sampled({"x": normal(1.0), "y": normal(1.0)}, 16 * DRAWS, seed=1)
    values = np.exp(a * drawn["x"] + b * drawn["y"])[None]
    shares = error_shares(drawn, values, np.ones(16 * DRAWS, dtype=int))
    of_x, of_y = np.expm1([a**2, b**2]) / np.expm1(a**2 + b**2)
    assert shares["x"][0] == pytest.approx(of_x, abs=0.01)
    assert shares["y"][0] == pytest.approx(of_y, abs=0.01)
    assert shares[TOGETHER][0] == pytest.approx(1.0 - of_x - of_y, abs=0.015)


def test_a_cause_of_no_effect_has_no_share() -> None:
    """Nor where few draws have most of the weight, as when the sleeve contradicts the inputs."""
    drawn = sampled({"x": normal(1.0), "none": normal(1.0)}, DRAWS, seed=1)
    values = np.stack([drawn["x"], np.exp(drawn["x"])])
    noise = sampled({"x": normal(1.0)}, DRAWS, seed=2)["x"]
    weights = 1 + (50.0 * (noise > 1.5)).astype(int)
    shares = error_shares(drawn, values + noise, weights)
    assert np.all(shares["none"] < 0.02)
