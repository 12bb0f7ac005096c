"""Effects of parameters that vary together, and beside the literature."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from harness.archive.conventions import DERIVED_BY
from harness.compare.linear_fit import linear_fit, shared_variance
from harness.compare.spread import spreads_of
from harness.pictures.cases import cases_figure
from harness.pictures.effects import effects_figure

from .conftest import caption_of, collected, legend, result

pytestmark = pytest.mark.slow

RANDOM = np.random.default_rng(2)
INDEX, ADHESION, NOISE = (RANDOM.uniform(0.0, 1.0, 30) for _ in range(3))
FACTOR = 10.0 + 2.0 * INDEX + 1.5 * ADHESION
FAILED = np.where(np.arange(30) < 20, FACTOR, np.nan)
ALL = ["rigidity index", "adhesion factor", "density"]


def random_cases(third: np.ndarray, factor: np.ndarray) -> xr.Dataset:
    """Cases of a rigidity index, an adhesion factor, and a density that has no effect."""
    columns = {"rigidity_index": 50.0 + INDEX, "adhesion_factor": ADHESION, "density": third}
    of_cases: Mapping[str, Sequence[object]] = {
        name: column[: len(factor)].tolist() for name, column in columns.items()
    }
    return result(of_cases, factor.tolist(), "latin_hypercube")


def panels_of(figure: Figure) -> list[str]:
    """The parameters that have a panel."""
    names = (axes.get_xlabel() for axes in figure.axes)
    return [next(name for name in ALL if text.startswith(name)) for text in names]


@pytest.mark.parametrize(
    ("third", "factor", "shown", "told"),
    [
        (NOISE, FACTOR, ALL, ""),
        (0.5 * ADHESION, FACTOR, ALL[:2], "not told apart: density goes with adhesion factor."),
        (ADHESION + 0.1 * NOISE, FACTOR, ALL[:2], "density goes with adhesion factor."),
        (ADHESION**2, FACTOR, ALL[:2], "density goes with adhesion factor."),
        (
            2.0 - INDEX - ADHESION,
            FACTOR,
            ALL[:2],
            "density goes with rigidity index and adhesion factor.",
        ),
        # varied, but not where cases completed
        (np.where(np.isfinite(FAILED), 1.0, NOISE), FAILED, ALL[:2], "same in all completed cases"),
    ],
    ids=["apart", "in proportion", "nearly", "by a law", "of two", "constant"],
)
def test_effects_of_parameters_that_go_together(
    third: np.ndarray, factor: np.ndarray, shown: list[str], told: str
) -> None:
    dataset = random_cases(third, factor)
    figure = effects_figure(dataset)
    assert sorted(panels_of(figure)) == sorted(shown)
    assert told in caption_of(figure)
    assert ("goes with" in caption_of(figure)) == ("goes with" in told)
    for axes in figure.axes:
        (line,) = (it for it in axes.lines if it.get_label() == "computed")
        slope = np.ptp(line.get_ydata()) / np.ptp(line.get_xdata())
        expected = {"rigidity index": 2.0, "adhesion factor": 1.5, "density": 0.0}
        (name,) = (name for name in ALL if axes.get_xlabel().startswith(name))
        assert slope == pytest.approx(expected[name], abs=1e-6)


def test_too_few_cases_for_a_fit_have_a_row_each() -> None:
    few = random_cases(0.5 * ADHESION[:4], FACTOR[:4])
    assert effects_figure(few) is None
    assert cases_figure(few) is not None


def test_what_a_study_derives_is_said_and_has_no_effect(tmp_path: Path) -> None:
    design = """design = "latin_hypercube"
samples = 16
seed = 1
[vary.rigidity_index]
from = 50
to = 100
[vary.adhesion_factor]
mean = 0.5
deviation = 0.1
[derived]
shaft_adhesion_factor = "0.5 * adhesion_factor"
"""
    factors = (10.0 + 0.1 * case for case in range(16))
    headline = {"role": "headline", "units": "1", "long_name": "cone factor"}
    results = [xr.Dataset({"cone_factor": ((), factor, headline)}) for factor in factors]
    dataset = collected(tmp_path, "cone_penetration", design, *results)
    assert dataset["shaft_adhesion_factor"].attrs[DERIVED_BY] == "0.5 * adhesion_factor"
    figure = effects_figure(dataset)
    assert len(figure.axes) == 2
    assert r"Derived: $α_{\mathrm{s}}$ = 0.5 * adhesion_factor." in caption_of(figure)
    (spread,) = spreads_of(dataset)
    assert "shaft_adhesion_factor" not in spread.shares
    assert {"rigidity_index", "adhesion_factor"} <= spread.shares.keys()


def test_a_reference_has_the_effect_of_its_values_in_valid_cases() -> None:
    columns = {"rigidity_index": 40.0 + 100.0 * INDEX, "adhesion_factor": ADHESION}
    dataset = result(
        {name: column.tolist() for name, column in columns.items()},
        FACTOR.tolist(),
        "latin_hypercube",
    )
    figure = effects_figure(dataset)
    assert legend(figure) == ["computed", "Lu et al. 2004"]  # the others are of von Mises clay
    adhesion = next(it for it in figure.axes if it.get_xlabel().startswith("adhesion"))
    lu = next(it for it in adhesion.lines if it.get_label() == "Lu et al. 2004")
    # Lu et al. give 1.3 times the adhesion factor, for a rigidity index of at least 50
    assert np.ptp(lu.get_ydata()) / np.ptp(lu.get_xdata()) == pytest.approx(1.3, rel=0.02)
    assert lu.get_xdata().size == np.count_nonzero(columns["rigidity_index"] >= 50.0)


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
