"""Rows of parameters: effects where they vary together, and where each is changed alone."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from harness.archive.conventions import DERIVED_BY
from harness.archive.study_files import read_study, write_study
from harness.compare.spread import spreads_of
from harness.pictures.cases import cases_figure
from harness.pictures.drawing.rows import INSIDE
from harness.pictures.drawing.style import FAILED
from harness.pictures.effects import effects_figure, tornado_figure
from harness.pictures.literature import colours_of
from harness.pictures.method.stability import stability_rows
from harness.references.registry import reference_of

from .conftest import caption_of, collected, drawn, legend, result, texts

pytestmark = pytest.mark.slow

RANDOM = np.random.default_rng(2)
INDEX, ADHESION, NOISE = (RANDOM.uniform(0.0, 1.0, 30) for _ in range(3))
FACTOR = 10.0 + 2.0 * INDEX + 1.5 * ADHESION
A_THIRD_FAILED = np.where(np.arange(30) < 20, FACTOR, np.nan)
ALL = ["rigidity index", "adhesion factor", "density", "material"]


def random_cases(third: np.ndarray, factor: np.ndarray) -> xr.Dataset:
    """Cases of a rigidity index, an adhesion factor, and a density that has no effect."""
    columns = {"rigidity_index": 50.0 + INDEX, "adhesion_factor": ADHESION, "density": third}
    of_cases: Mapping[str, Sequence[object]] = {
        name: column[: len(factor)].tolist() for name, column in columns.items()
    }
    return result(of_cases, factor.tolist(), "latin_hypercube")


def rows_of(figure: Figure) -> list[str]:
    """The parameters that have a row, from the top."""
    return [
        next(name for name in ALL if label.startswith(name))
        for label in texts(figure.axes[0].get_yticklabels())
    ]


def slope_of(figure: Figure, name: str, values: np.ndarray, colour: str = "black") -> float:
    """The slope of an effect over its parameter, whose range is the height of its row."""
    row = rows_of(figure).index(name)
    (line,) = (
        it
        for it in figure.axes[0].lines
        if it.get_color() == colour and np.abs(np.asarray(it.get_ydata()) - row).max() < 0.41
    )
    share = np.ptp(line.get_ydata()) / (2.0 * INSIDE)
    return float(np.ptp(line.get_xdata()) / (share * np.ptp(values)))


@pytest.mark.parametrize(
    ("third", "factor", "shown", "told"),
    [
        (NOISE, FACTOR, ALL[:3], ""),
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
        (
            np.where(np.isfinite(A_THIRD_FAILED), 1.0, NOISE),
            A_THIRD_FAILED,
            ALL[:2],
            "same in all completed cases",
        ),
    ],
    ids=["apart", "in proportion", "nearly", "by a law", "of two", "constant"],
)
def test_effects_of_parameters_that_go_together(
    third: np.ndarray, factor: np.ndarray, shown: list[str], told: str
) -> None:
    dataset = random_cases(third, factor)
    figure = effects_figure(dataset)
    assert sorted(rows_of(figure)) == sorted(shown)
    assert told in caption_of(figure)
    assert ("goes with" in caption_of(figure)) == ("goes with" in told)
    slopes = {"rigidity index": 2.0, "adhesion factor": 1.5, "density": 0.0}
    for name in shown:
        values = dataset[name.replace(" ", "_")].values
        assert slope_of(figure, name, values) == pytest.approx(slopes[name], abs=1e-6)


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
    assert len(rows_of(figure)) == 2
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
    # Lu et al. give 1.3 times the adhesion factor, for a rigidity index of at least 50
    colour = colours_of([reference_of("lu_2004")])[0]
    slope = slope_of(figure, "adhesion factor", ADHESION, colour)
    assert slope == pytest.approx(1.3, rel=0.02)


def points(figure: Figure, row: int) -> list[tuple[float, float]]:
    """The values of a row and their heights over its middle, over half of those of the row."""
    lines = (it for it in figure.axes[0].lines if it.get_marker() == "o")
    line = [it for it in lines if len(it.get_xdata()) > 1][row]
    heights = (row - np.asarray(line.get_ydata(), dtype=float)) / INSIDE
    return list(zip(np.asarray(line.get_xdata()).tolist(), heights.round(6).tolist(), strict=True))


def test_tornado_has_the_largest_change_on_top_and_each_value_at_its_height() -> None:
    figure = drawn("one at a time")[1]["tornado"]
    (axes,) = figure.axes
    assert texts(axes.get_yticklabels()) == [
        r"rigidity index $I_{\mathrm{r}}$: 25, 100, 500",
        "adhesion factor $α$: 0.5, 1",
        "material: tresca, von mises",
        r"speed ratio $v/v_{\mathrm{s}}$: 0.03, 0.5",
    ]
    middle = 2.0 * np.log(4.0) / np.log(20.0) - 1.0  # on a logarithmic axis
    assert points(figure, 0) == [(8.0, -1.0), (11.0, round(middle, 6)), (14.0, 1.0)]
    assert points(figure, 1) == [(11.0, -1.0), (11.8, 1.0)]
    (cross,) = (line for line in axes.lines if line.get_marker() == "x")
    np.testing.assert_allclose(cross.get_xydata(), [[0.0, 3.0 - INSIDE]])  # on the axis itself
    assert legend(figure) == ["start: 11", "not completed"]


def test_effects_of_random_cases_are_found_again() -> None:
    dataset, pictures = drawn("at random")
    figure = pictures["effects"]
    labels = texts(figure.axes[0].get_yticklabels())
    assert [label.partition(" ")[0] for label in labels] == ["rigidity", "adhesion", "material:"]
    slope = slope_of(figure, "adhesion factor", dataset.adhesion_factor.values)
    assert slope == pytest.approx(1.5, rel=1e-9)  # what was put in is in the span of the fit
    assert "of their variance it explains 100 %" in caption_of(figure)


def test_a_few_cases_are_told_by_where_they_differ_from_most() -> None:
    figure = drawn("a few cases")[1]["cases"]
    (axes,) = figure.axes
    assert texts(axes.get_yticklabels()) == [
        "as most",
        "material = von mises",
        "$α$ = 1, $β$ = 120",
        "$β$ = 90, mean effective stress = 60\nkPa",
    ]
    (cross,) = (line for line in axes.lines if line.get_marker() == "x")
    assert (cross.get_color(), np.asarray(cross.get_ydata()).tolist()) == (FAILED, [3.0])
    assert legend(figure) == ["not completed"]
    assert "1 of 4 cases did not complete" in caption_of(figure)
    bottom, top = axes.get_ylim()
    assert bottom > top, "the first case is the uppermost"


@pytest.mark.parametrize(
    "vary",
    ["rigidity_index = [20]\nspeed_ratio = [0.1]", "speed_ratio = [0.1]\nrigidity_index = [20]"],
)
def test_a_bar_has_the_cases_that_change_its_parameter_alone(vary: str, tmp_path: Path) -> None:
    """The default speed follows the rigidity index; the order in the study says nothing."""
    text = f'design = "one_at_a_time"\nstability_map = true\n[vary]\n{vary}\n'
    factors = {"": 11.0, "rigidity_index": 8.0, "speed_ratio": 11.5}
    in_turn = ["", *(line.partition(" ")[0] for line in vary.splitlines())]
    results = [
        xr.Dataset({"resistance_factor": ((), factors[name], {"role": "headline"})})
        for name in in_turn
    ]
    dataset = collected(tmp_path, "ball_penetration", text, *results)
    assert dataset["changed"].values.tolist() == in_turn
    write_study(tmp_path / "s.nc", dataset)
    for kept in (dataset, read_study(tmp_path / "s.nc")):
        rows = texts(tornado_figure(kept).axes[0].get_yticklabels())
        assert [row.partition(": ")[2] for row in rows] == ["20, 100", "0.03, 0.1"]
        found = {row[0]: row[1] for row in stability_rows(kept)}
        assert found["rigidity index (100)"] == "20: 100% of 1, 100: 100% of 1"
        assert found["speed ratio (0.03)"] == "0.03: 100% of 1, 0.1: 100% of 1"
