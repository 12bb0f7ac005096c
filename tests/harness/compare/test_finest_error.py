"""Errors of cases, the settings that they recommend, and the page that reports them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.case_files import FORMAT_VERSION
from harness.archive.collection import write_study
from harness.cli.main import main
from harness.compare.finest_error import FINEST, with_errors
from harness.compare.recommend import recommend
from harness.errors import HarnessError
from harness.pictures.pictures import figures
from harness.pictures.plot_parts import FAILED
from harness.pictures.report import page
from harness.pictures.work_precision import study_figure

MESHES = [1.5, 2.0, 4.0]
STIFFNESS = [50.0, 100.0]


def result() -> xr.Dataset:
    """Two soils on three meshes; the finest case of the second soil has failed."""
    shape = ("rigidity_index", "cells_per_radius")
    factor = np.array([[9.9, 9.18, 9.0], [11.0, 10.1, np.nan]])
    seconds = np.array([[1.0, 2.0, 8.0], [1.0, 2.5, np.nan]])
    status = np.array([["completed"] * 3, ["completed", "completed", "diverged"]])
    return xr.Dataset(
        {
            "cone_factor": (shape, factor, {"units": "1", "long_name": "cone factor"}),
            "run_time": (shape, seconds),
            "case_time": (shape, np.nan_to_num(seconds, nan=3.0)),
            "particle_updates": (shape, 1e6 * seconds),
            "status": (shape, status),
            "message": (shape, np.where(status == "completed", "", "velocity of <particle 3>")),
            "case_key": (shape, np.char.add("key ", status)),
            "adhesion_factor": ((), 0.0, {"description": "adhesion factor", "units": "1"}),
            "apex_angle": 60.0,
            "poissons_ratio": 0.49,
            "material": "tresca",
        },
        coords={"rigidity_index": STIFFNESS, "cells_per_radius": MESHES},
        attrs={
            "scene": "cone_penetration",
            "scene_version": 1,
            "study": "made",
            "title": "Made <up>",
            "format_version": FORMAT_VERSION,
        },
    )


def test_error_is_against_the_costliest_case_of_the_same_soil() -> None:
    error = with_errors(result())[FINEST]
    np.testing.assert_allclose(error.sel(rigidity_index=50.0), [0.1, 0.02, np.nan], rtol=1e-12)
    # Where the finest case has failed, the next one is the reference.
    stiff = error.sel(rigidity_index=100.0)
    np.testing.assert_allclose(stiff, [11.0 / 10.1 - 1.0, np.nan, np.nan], rtol=1e-12)


def test_an_exact_error_is_left_alone() -> None:
    dataset = result().assign(error=0.5)
    assert FINEST not in with_errors(dataset)


def test_one_case_of_each_soil_has_no_error() -> None:
    assert FINEST not in with_errors(result().isel(cells_per_radius=[1]))


def written(folder: Path, dataset: xr.Dataset) -> Path:
    file = folder / "made.nc"
    write_study(file, dataset)
    return file


def test_recommended_are_the_cheapest_settings_good_for_every_soil(tmp_path: Path) -> None:
    file = written(tmp_path, with_errors(result()))
    found = recommend("cone_penetration", 0.05, [file])
    assert found is not None
    assert found.settings == {"cells_per_radius": 2.0}
    assert (found.error, found.run_time) == (pytest.approx(0.02), 2.5)
    cheap = recommend("cone_penetration", 0.5, [file])
    assert cheap is not None
    assert cheap.settings == {"cells_per_radius": 1.5}


def test_settings_that_failed_once_are_not_recommended(tmp_path: Path) -> None:
    dataset = with_errors(result())
    dataset["status"].loc[{"rigidity_index": 100.0, "cells_per_radius": 2.0}] = "diverged"
    assert recommend("cone_penetration", 0.05, [written(tmp_path, dataset)]) is None


def test_nothing_is_recommended_from_nothing(tmp_path: Path) -> None:
    file = written(tmp_path, result())
    with pytest.raises(HarnessError, match="no result with errors"):
        recommend("cone_penetration", 0.05, [file])


@pytest.mark.parametrize(("error", "code"), [("5%", 0), ("0.0001", 1)])
def test_recommend_from_the_command_line(
    error: str, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written(tmp_path, with_errors(result()))
    arguments = ["recommend", "cone_penetration", "--error", error, "--results", str(tmp_path)]
    assert main(arguments) == code
    assert ("cells_per_radius = 2.0" in capsys.readouterr().out) == (code == 0)


def test_picture_marks_the_front_and_the_failure() -> None:
    (axes,) = study_figure(with_errors(result())).axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["cases", "cone_penetration, Pareto front: cells per radius", "failed"]
    front = axes.lines[1].get_xydata()
    np.testing.assert_allclose(front, [[1.0, 11.0 / 10.1 - 1.0], [2.0, 0.02]], rtol=1e-12)


def test_pictures_of_a_result_with_errors() -> None:
    assert set(figures(with_errors(result()))) == {"cone_factor", "work_precision"}


def test_report_is_one_page_that_needs_nothing_else(tmp_path: Path) -> None:
    file, out = written(tmp_path, with_errors(result())), tmp_path / "report.html"
    assert main(["report", str(file), "-o", str(out)]) == 0
    text = out.read_text()
    assert text.count("<img") == text.count('src="data:image/png;base64,') == 2
    assert "http" not in text.replace("http-equiv", "")
    assert "velocity of &lt;particle 3&gt;" in text
    assert "Made &lt;up&gt;" in text
    assert list(tmp_path.glob(".*")) == []


def test_every_case_is_on_the_page() -> None:
    text = page([with_errors(result())])
    assert text.count("<td>completed</td>") == 5
    assert text.count('<tr class="bad">') == 1


def test_a_result_without_cone_factors_has_its_picture_on_the_page() -> None:
    exact = result().drop_vars("cone_factor").assign_attrs(scene="thick_cylinder")
    exact["error"] = exact["run_time"] * 0.01
    assert page([exact]).count("<img") == 1


def test_each_scene_of_several_has_its_own_front() -> None:
    dataset = xr.Dataset(
        {
            "error": ("case", [0.1, 0.01, 0.5, 0.3]),
            "run_time": ("case", [1.0, 2.0, 1.5, 3.0]),
        },
        coords={
            "case": range(4),
            "scene": ("case", ["thick_cylinder"] * 2 + ["cavity_sphere"] * 2),
            "cells_per_radius": ("case", [np.nan, np.nan, 4.0, 8.0]),
        },
    )
    (axes,) = study_figure(dataset).axes
    fronts = [line.get_xydata() for line in axes.lines[1:]]
    np.testing.assert_allclose(fronts, [[[1, 0.1], [2, 0.01]], [[1.5, 0.5], [3, 0.3]]])


def test_failures_have_one_colour_on_the_page_and_in_its_pictures() -> None:
    assert f".bad {{ color: {FAILED} }}" in page([with_errors(result())])
