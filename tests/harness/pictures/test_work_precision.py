"""Error against run time, as a picture."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from harness.pictures.work_precision import shows_work_precision, study_figure
from tests.harness.pictures.conftest import figures


def fronts(figure: Figure) -> list[list[list[float]]]:
    """The points of each front."""
    lines = [line for line in figure.axes[0].lines if line.get_linestyle() == "-"]
    return [line.get_xydata().tolist() for line in lines]


def told(figure: Figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_each_soil_has_a_front_of_its_own(two_soils: xr.Dataset) -> None:
    figure = study_figure(two_soils)
    assert told(figure) == [
        r"$I_{\mathrm{r}}$ = 50",
        r"$I_{\mathrm{r}}$ = 100",
        "not completed",
    ]
    first, second = fronts(figure)
    np.testing.assert_allclose(first, [[1.0, 0.1], [2.0, 0.02]], rtol=1e-12)
    np.testing.assert_allclose(second, [[1.0, 11.0 / 10.1 - 1.0]], rtol=1e-12)


def test_points_tell_all_settings_that_vary() -> None:
    shape = ("cells_per_radius", "particles_per_cell")
    dataset = xr.Dataset(
        {
            "error": (shape, [[0.1, 0.2], [0.03, 0.01]]),
            "run_time": (shape, [[1.0, 1.5], [2.0, 8.0]]),
            "status": (shape, [["completed"] * 2] * 2),
        },
        coords={"cells_per_radius": [2, 4], "particles_per_cell": [4, 9]},
        attrs={"scene": "cone_penetration"},
    )
    figure = study_figure(dataset)
    (front,) = fronts(figure)
    assert front == [[1.0, 0.1], [2.0, 0.03], [8.0, 0.01]]
    beside = [text.get_text() for text in figure.axes[0].texts]
    assert beside == ["2 / 4", "4 / 4", "4 / 9"]
    assert "Beside points: $R/h$ / particles per cell." in figure.get_supxlabel()
    (grey,) = [it for it in figure.axes[0].lines if it.get_label() == "beaten by another"]
    assert grey.get_xydata().tolist() == [[1.5, 0.2]]  # the entry of the legend has its points


def test_the_uncertainty_of_the_reference_is_a_line(two_soils: xr.Dataset) -> None:
    dataset = two_soils.assign(error_floor=two_soils["error_finest"] * 0.0 + 0.01)
    (line,) = [it for it in study_figure(dataset).axes[0].lines if it.get_linestyle() == ":"]
    assert list(line.get_ydata()) == [0.01, 0.01]


def test_it_is_not_meant_for_cases_of_different_soils_alone(two_soils: xr.Dataset) -> None:
    assert not shows_work_precision(two_soils.isel(cells_per_radius=[1]))


def test_pictures_of_a_result_with_finest_error(two_soils: xr.Dataset) -> None:
    assert set(figures(two_soils)) == {"convergence", "work_precision"}


def test_each_scene_of_several_has_its_own_front() -> None:
    dataset = xr.Dataset(
        {
            "error": ("case", [0.1, 0.01, 0.5, 0.3]),
            "run_time": ("case", [1.0, 2.0, 1.5, 3.0]),
            "status": ("case", ["completed"] * 4),
        },
        coords={
            "case": range(4),
            "scene": ("case", ["thick_cylinder"] * 2 + ["cavity_sphere"] * 2),
            "cell_count": ("case", [5.0, 10.0, np.nan, np.nan]),
            "cells_per_radius": ("case", [np.nan, np.nan, 4.0, 8.0]),
        },
        attrs={"scene": "thick_cylinder cavity_sphere"},
    )
    figure = study_figure(dataset)
    assert fronts(figure) == [[[1, 0.1], [2, 0.01]], [[1.5, 0.5], [3, 0.3]]]
    assert told(figure) == ["thick cylinder", "cavity sphere"]


def test_a_soil_that_gives_a_value_stands_beside_one_that_leaves_it_to_the_scene() -> None:
    parameter = {"role": "parameter", "units": "1"}
    dataset = xr.Dataset(
        {
            "error": ("case", [0.2, 0.02, 0.3, 0.03], {"role": "error"}),
            "run_time": ("case", [1.0, 2.0, 1.1, 2.1]),
            "status": ("case", ["completed"] * 4),
        },
        coords={
            "step_count": ("case", [10, 100, 10, 100], parameter),
            "ductility": ("case", [np.nan, np.nan, 2.0, 2.0], parameter),
        },
        attrs={"scene": "material_point", "design": "list"},
    )
    assert len(fronts(study_figure(dataset))) == 2
    assert told(study_figure(dataset)) == [
        r"$ξ_{\mathrm{95}}$ = derived",
        r"$ξ_{\mathrm{95}}$ = 2",
    ]
