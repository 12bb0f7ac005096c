"""What is kept of cases that did not complete: curves, the meaning of names, tracebacks."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
import xarray as xr

from harness.archive.case_files import case_folder, write_case
from harness.archive.collection import collect
from harness.archive.conventions import without_incomplete_curves
from harness.cli.main import main
from harness.run.worker import compute, run_case
from harness.study.study import Study, load_study
from mpm_warp.errors import SimulationDiverged
from mpm_warp.results import curves, variable
from mpm_warp.scenes.cone.cone_penetration import ConePenetration


def results_of(scale: float) -> xr.Dataset:
    """A curve of three samples, and a headline."""
    axis = (np.array([0.1, 0.2, 0.3]), "1", "penetration over radius")
    curve = curves("penetration", axis, penetration_resistance=(scale * np.ones(3), "Pa", "q"))
    factor = variable(scale, unit="1", meaning="cone factor", role="headline")
    return curve.assign(cone_factor=factor)


@pytest.fixture
def one(small_file: Path) -> Study:
    """A study that varies the penetration, which is the name of an axis too, and has one case."""
    return load_study(str(small_file), ["adhesion_factor=0", "penetration=[1]"])


def test_curves_of_the_only_case_are_collected_where_it_diverged(
    one: Study, tmp_path: Path
) -> None:
    folder = case_folder(tmp_path, one)
    folder.mkdir(parents=True)
    write_case(folder, one.cases[0], results_of(2.0), "diverged", "why")
    dataset = collect(one, folder)
    assert dataset.penetration_resistance.values.tolist() == [[2.0, 2.0, 2.0]]
    assert "cone_factor" not in dataset
    assert dataset.status.values.tolist() == ["diverged"]
    assert "penetration_resistance" not in without_incomplete_curves(dataset)


@pytest.mark.parametrize("status", ["completed", "diverged", "failed", None])
def test_dims_mean_the_same_whatever_became_of_the_cases(
    status: str | None, one: Study, tmp_path: Path
) -> None:
    folder = case_folder(tmp_path, one)
    folder.mkdir(parents=True)
    if status is not None:
        kept = xr.Dataset() if status == "failed" else results_of(2.0)
        write_case(folder, one.cases[0], kept, status)
    dataset = collect(one, folder)
    assert dataset.status.dims == ("penetration_parameter",)
    assert dataset.penetration_parameter.values.tolist() == [1.0]
    assert dataset.sizes.get("penetration", 3) == 3  # the axis of the curves, where there are any


def test_scalars_of_an_incomplete_case_are_no_numbers_beside_its_curve(
    small: Study, tmp_path: Path
) -> None:
    folder = case_folder(tmp_path, small)
    folder.mkdir(parents=True)
    first, second, _ = small.cases
    write_case(folder, first, results_of(1.0), "completed")
    write_case(folder, second, results_of(2.0).isel(penetration=slice(2)), "diverged", "why")
    dataset = collect(small, folder)
    np.testing.assert_array_equal(dataset.cone_factor, [1.0, np.nan, np.nan])
    np.testing.assert_array_equal(dataset.penetration_resistance[1], [2.0, 2.0, np.nan])
    shown = without_incomplete_curves(dataset)
    np.testing.assert_array_equal(shown.penetration_resistance[1], [np.nan] * 3)
    np.testing.assert_array_equal(shown.penetration_resistance[0], [1.0] * 3)


def test_a_failed_case_keeps_its_traceback_for_who_asks(
    small: Study,
    small_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail(*given: object) -> NoReturn:
        raise ZeroDivisionError("of the test")

    monkeypatch.setattr(ConePenetration, "run", fail)
    folder = case_folder(tmp_path, small)
    folder.mkdir(parents=True)
    run_case(small.cases[0], folder)
    arguments = ["status", str(small_file), f"--out={tmp_path}"]
    assert main(arguments) == 1
    told = capsys.readouterr()
    assert "failed" in told.out
    assert "Traceback" not in told.out + told.err
    assert main([*arguments, "--traceback"]) == 1
    shown = capsys.readouterr().out
    assert "Traceback" in shown
    assert 'raise ZeroDivisionError("of the test")' in shown
    collected = collect(small, folder)
    assert "Traceback" not in str(collected.attrs) + str(collected.message.values)


def test_a_case_that_ends_by_name_has_no_traceback(
    small: Study, monkeypatch: pytest.MonkeyPatch
) -> None:
    def diverge(*given: object) -> NoReturn:
        raise SimulationDiverged("of the test")

    monkeypatch.setattr(ConePenetration, "run", diverge)
    result = compute(small.cases[0])
    assert result.outcome.status == "diverged"
    assert "traceback" not in result.dataset.attrs
