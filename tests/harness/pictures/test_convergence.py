"""Convergence: the order and the limit that three values tell."""

import numpy as np
import pytest
import xarray as xr

from harness.pictures.convergence import approach, convergence_figure, shows_convergence

from .conftest import MADE, result

CELLS = (2.0, 4.0, 8.0, 16.0)
WIDTHS = 1.0 / np.array(CELLS)


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0])
def test_order_and_limit_are_found_again(order: float) -> None:
    found = approach(WIDTHS, 10.0 + 3.0 * WIDTHS**order)
    assert found is not None
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


def test_each_series_has_its_limit_at_the_end_of_refinement() -> None:
    figure = convergence_figure(MADE["a mesh"]())
    (axes,) = figure.axes
    hollow = [line for line in axes.lines if line.get_markerfacecolor() == "white"]
    assert [line.get_ydata()[0] for line in hollow] == pytest.approx([10.0, 11.5], abs=1e-3)
    (legend,) = figure.legends
    told = [text.get_text() for text in legend.get_texts()]
    assert told == ["$α$ = 0: order 1.00, limit 10", "$α$ = 1: order 1.00, limit 11.5"]
    assert [text.get_text() for text in axes.get_xticklabels()][:2] == ["∞", "16"]


def test_an_error_is_drawn_on_logarithmic_axes_with_its_order() -> None:
    made = result({"cell_count": [5, 10, 20]}).assign_attrs(scene="thick_cylinder")
    made = made.drop_vars(["cone_factor", "penetration_resistance"])
    labels = {"role": "headline", "units": "1", "long_name": "error"}
    made["error"] = "cell_count", [0.04, 0.01, 0.0025], labels
    figure = convergence_figure(made)
    assert figure.axes[0].get_yscale() == "log"
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["computed: order 2.00"]


@pytest.mark.parametrize(
    "varied",
    [
        {"rigidity_index": [25.0, 100.0, 500.0]},  # no parameter of the method
        {"cells_per_radius": [2.0, 4.0]},  # too few
        {"cells_per_radius": list(CELLS), "rigidity_index": list(np.linspace(50, 90, 9))},
    ],
)
def test_it_is_not_meant_for_other_studies(varied: dict[str, list[float]]) -> None:
    dataset: xr.Dataset = result(varied)
    assert not shows_convergence(dataset)
