"""Convergence: order and limit beside the values; error against run time."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from harness.pictures.method.convergence import convergence_figure
from harness.pictures.method.work_precision import study_figure

from .conftest import MADE, caption_of, figures, legend, result, texts

CELLS = (2.0, 4.0, 8.0, 16.0)


def test_each_series_has_its_limit_at_the_end_of_refinement() -> None:
    figure = convergence_figure(MADE["a mesh"]())
    (axes,) = figure.axes
    hollow = [line for line in axes.lines if line.get_markerfacecolor() == "white"]
    assert [line.get_ydata()[0] for line in hollow] == pytest.approx([10.0, 11.5], abs=1e-3)
    assert legend(figure) == ["$α$ = 0: order 1.00, limit 10", "$α$ = 1: order 1.00, limit 11.5"]
    assert texts(axes.get_xticklabels())[:2] == ["∞", "16"]


def test_corrected_values_are_drawn_beside_those_as_simulated_which_have_the_order() -> None:
    made = MADE["a mesh"]()
    correction = made["cone_factor"] - 0.1 * np.arange(2) - 10.0
    made["cone_factor_correction"] = -correction.drop_attrs()
    made["cone_factor"].values[:] -= correction.values
    figure = convergence_figure(made)
    assert sorted(legend(figure)) == [
        "$α$ = 0, as simulated: order 1.00, limit 10",
        "$α$ = 0, corrected",
        "$α$ = 1, as simulated: order 1.00, limit 11.5",
        "$α$ = 1, corrected",
    ]
    assert "Corrected values have no order" in caption_of(figure)


def test_an_error_is_drawn_on_logarithmic_axes_with_its_order() -> None:
    made = result({"cell_count": [5, 10, 20]}).assign_attrs(scene="thick_cylinder")
    made = made.drop_vars(["cone_factor", "penetration_resistance"])
    labels = {"role": "headline", "units": "1", "long_name": "error"}
    made["error"] = "cell_count", [0.04, 0.01, 0.0025], labels
    figure = convergence_figure(made)
    assert figure.axes[0].get_yscale() == "log"
    assert legend(figure) == ["computed: order 2.00"]


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
    assert convergence_figure(dataset) is None


def fronts(figure: Figure) -> list[list[list[float]]]:
    """The points of each front."""
    lines = [line for line in figure.axes[0].lines if line.get_linestyle() == "-"]
    return [line.get_xydata().tolist() for line in lines if line.get_xydata().size]


def timed(
    dims: str | tuple[str, ...], error: object, run_time: object, scene: str, **coords: object
) -> xr.Dataset:
    """A result of completed cases with errors and run times."""
    errors = (dims, error, {"role": "error"})
    made = xr.Dataset({"error": errors, "run_time": (dims, run_time)}, coords)
    made["status"] = dims, np.full(made["error"].shape, "completed")
    return made.assign_attrs(scene=scene)


def test_each_soil_has_a_front_of_its_own(two_soils: xr.Dataset) -> None:
    figure = study_figure(two_soils)
    assert legend(figure) == [r"$I_{\mathrm{r}}$ = 50", r"$I_{\mathrm{r}}$ = 100"]
    assert "1 of 6 cases did not complete." in figure.get_supxlabel().replace("\n", " ")
    first, second = fronts(figure)
    np.testing.assert_allclose(first, [[1.0, 0.1], [2.0, 0.02]], rtol=1e-12)
    np.testing.assert_allclose(second, [[1.0, 11.0 / 10.1 - 1.0]], rtol=1e-12)


def test_points_tell_all_settings_that_vary() -> None:
    settings = {"cells_per_radius": [2, 4], "particles_per_cell": [4, 9]}
    error, run_time = [[0.1, 0.2], [0.03, 0.01]], [[1.0, 1.5], [2.0, 8.0]]
    figure = study_figure(timed(tuple(settings), error, run_time, "cone_penetration", **settings))
    (front,) = fronts(figure)
    assert front == [[1.0, 0.1], [2.0, 0.03], [8.0, 0.01]]
    assert texts(figure.axes[0].texts) == ["2 / 4", "4 / 4", "4 / 9"]
    assert "Beside points: $R/h$ / particles per cell." in figure.get_supxlabel()
    (grey,) = [it for it in figure.axes[0].lines if it.get_label() == "beaten by another"]
    assert grey.get_xydata().tolist() == [[1.5, 0.2]]  # the entry of the legend has its points


def test_the_uncertainty_of_the_reference_is_a_line(two_soils: xr.Dataset) -> None:
    dataset = two_soils.assign(error_floor=two_soils["error_finest"] * 0.0 + 0.01)
    (line,) = [it for it in study_figure(dataset).axes[0].lines if it.get_linestyle() == ":"]
    assert list(line.get_ydata()) == [0.01, 0.01]


def test_it_is_not_meant_for_cases_none_of_which_has_an_error(two_soils: xr.Dataset) -> None:
    """As where all but the reference state none; nor for cases of different soils alone."""
    silent = two_soils.assign(error_finest=np.nan * two_soils["error_finest"])
    assert study_figure(silent) is None
    assert study_figure(two_soils.isel(cells_per_radius=[1])) is None


def test_pictures_of_a_result_with_finest_error(two_soils: xr.Dataset) -> None:
    assert set(figures(two_soils)) == {"convergence", "work_precision"}


def test_each_scene_of_several_has_its_own_front() -> None:
    dataset = timed(
        "case",
        [0.1, 0.01, 0.5, 0.3],
        [1.0, 2.0, 1.5, 3.0],
        "thick_cylinder cavity_sphere",
        case=range(4),
        cell_count=("case", [5.0, 10.0, np.nan, np.nan]),
        cells_per_radius=("case", [np.nan, np.nan, 4.0, 8.0]),
    )
    scenes = ["thick_cylinder"] * 2 + ["cavity_sphere"] * 2
    figure = study_figure(dataset.assign_coords(scene=("case", scenes)))
    assert fronts(figure) == [[[1, 0.1], [2, 0.01]], [[1.5, 0.5], [3, 0.3]]]
    assert legend(figure) == ["thick cylinder", "cavity sphere"]


PARAMETER = {"role": "parameter", "units": "1"}


def test_a_soil_that_gives_a_value_stands_beside_one_that_leaves_it_to_the_scene() -> None:
    dataset = timed(
        "case",
        [0.2, 0.02, 0.3, 0.03],
        [1.0, 2.0, 1.1, 2.1],
        "material_point",
        step_count=("case", [10, 100, 10, 100], PARAMETER),
        ductility=("case", [np.nan, np.nan, 2.0, 2.0], PARAMETER),
    )
    figure = study_figure(dataset.assign_attrs(design="list"))
    assert len(fronts(figure)) == 2
    assert legend(figure) == [r"$ξ_{\mathrm{95}}$ = derived", r"$ξ_{\mathrm{95}}$ = 2"]


def test_the_soil_of_a_single_front_stands_in_the_caption() -> None:
    """In the legend there is no room for all that one at a time varies."""
    dataset = timed(
        "case",
        [0.1, 0.02, 0.03],
        [1.0, 2.0, 1.0],
        "cone_penetration",
        cells_per_radius=("case", [2, 4, 2], PARAMETER),
        rigidity_index=("case", [50.0, 50.0, 100.0], PARAMETER),
    )
    figure = study_figure(dataset.assign_attrs(design="one_at_a_time"))
    assert legend(figure) == ["front: no other is faster and better"]
    told = caption_of(figure).replace("\N{NO-BREAK SPACE}", " ")
    assert r"All points: $I_{\mathrm{r}}$ = 50." in told


def test_a_point_is_a_measured_error_and_the_front_joins_the_errors_that_rank_cases() -> None:
    """Those are the upper ends of thin lines, so that the front never rises."""
    along = "cells_per_radius"
    dataset = timed(along, [0.01, 0.03], [1.0, 2.0], "cone_penetration", cells_per_radius=[2, 4])
    dataset["cone_factor"] = along, [10.0, 10.0], {"role": "headline"}
    dataset["cone_factor_uncertainty"] = along, [2.0, 0.5], {"role": "uncertainty"}
    figure = study_figure(dataset)
    assert fronts(figure) == [[[1.0, 0.2], [2.0, 0.05]]]
    points = [it for it in figure.axes[0].lines if it.get_marker() == "o" and it.get_xdata().size]
    assert [it.get_xydata().tolist() for it in points] == [[[1.0, 0.01], [2.0, 0.03]]]
    (lines,) = figure.axes[0].collections
    ends = [np.asarray(path.vertices).tolist() for path in lines.get_paths()]
    assert ends == [[[1.0, 0.01], [1.0, 0.2]], [[2.0, 0.03], [2.0, 0.05]]]
