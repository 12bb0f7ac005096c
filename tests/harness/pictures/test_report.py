"""The page that reports results."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from harness.archive.study_files import write_study
from harness.cli.main import main
from harness.pictures.plot_parts import FAILED
from harness.pictures.report import page


def written(folder: Path, dataset: xr.Dataset) -> Path:
    file = folder / "made.nc"
    write_study(file, dataset)
    return file


def test_report_is_one_page_that_needs_nothing_else(tmp_path: Path, two_soils: xr.Dataset) -> None:
    file, out = written(tmp_path, two_soils), tmp_path / "report.html"
    assert main(["report", str(file), "-o", str(out)]) == 0
    text = out.read_text()
    assert text.count("<img") == text.count('src="data:image/png;base64,') == 2
    assert "http" not in text.replace("http-equiv", "")
    assert "velocity of &lt;particle 3&gt;" in text
    assert "Made &lt;up&gt;" in text
    assert list(tmp_path.glob(".*")) == []


def test_every_case_is_on_the_page(two_soils: xr.Dataset) -> None:
    text = page([two_soils])
    assert text.count("<td>completed</td>") == 5
    assert text.count('<tr class="bad">') == 1


def test_a_result_without_cone_factors_has_its_picture_on_the_page(two_soils: xr.Dataset) -> None:
    exact = two_soils.drop_vars(["cone_factor", "error_finest"]).assign_attrs(
        scene="thick_cylinder"
    )
    exact["error"] = exact["run_time"] * 0.01
    assert page([exact]).count("<img") == 1


def test_failures_have_one_colour_on_the_page_and_in_its_pictures(two_soils: xr.Dataset) -> None:
    assert f".bad {{ color: {FAILED} }}" in page([two_soils])
