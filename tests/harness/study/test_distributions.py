"""Distributions of inputs, in the file of a site and in a study."""

import math
from pathlib import Path

import numpy as np
import pytest

from harness.study.distributions import read_input, sampled
from harness.study.tables import StudyError, Table
from mpm_warp.arguments import FINITE, POSITIVE
from tests.harness.conftest import HEAD, study_in, values


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
def test_an_input_has_the_moments_of_its_distribution(
    written: object, mean: float, deviation: float | None
) -> None:
    """A Latin hypercube of n draws has a mean within its range over n of the exact one."""
    count = 20_000
    drawn = sampled({"x": read_input(Table("t:", {"x": written}), "x", FINITE)}, count, 1)["x"]
    assert drawn.mean() == pytest.approx(mean, abs=20.0 / count * max(1.0, np.ptp(drawn)))
    if deviation is not None:
        assert drawn.std() == pytest.approx(deviation, abs=20.0 / count * max(1.0, np.ptp(drawn)))


@pytest.mark.parametrize(
    "written",
    [
        "x",
        -1.0,
        True,
        {},
        {"low": 1.0},
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
    with pytest.raises(StudyError, match=r"^t: x = .*: .+$"):
        read_input(Table("t:", {"x": written}), "x", POSITIVE)


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
