"""Tolerances that are kept and missed."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.study_files import write_study
from harness.cli.main import main
from harness.compare.compared import misses, with_tolerances
from harness.study.study import load_study
from harness.study.tables import StudyError

HEAD = 'title = "t"\nscene = "cone_penetration"\n'


def missed(dataset: xr.Dataset, **tolerances: float) -> list[str]:
    return misses(with_tolerances(dataset, tolerances))


def test_no_tolerance_misses_nothing(tmp_path: Path, collected: Callable[..., xr.Dataset]) -> None:
    assert missed(collected(tmp_path)) == []


def test_the_bound_of_a_result(tmp_path: Path, collected: Callable[..., xr.Dataset]) -> None:
    dataset = collected(tmp_path)
    assert missed(dataset, error=0.012) == []
    assert missed(dataset, error=0.0115) == [
        "error: adhesion_factor=1.0: 0.012 is beyond the tolerance 0.0115"
    ]


def test_the_bound_of_a_deviation(tmp_path: Path, collected: Callable[..., xr.Dataset]) -> None:
    dataset = collected(tmp_path)
    # 10 / 10.77 - 1, 11 / 11.42 - 1, 12 / 12.07 - 1
    assert missed(dataset, lu_2004=0.08) == []
    (line,) = missed(dataset, lu_2004=0.05)
    assert line.startswith("lu_2004: adhesion_factor=0.0: 0.071")


def test_a_reference_is_not_asked_outside_its_validity(
    tmp_path: Path, collected: Callable[..., xr.Dataset]
) -> None:
    dataset = collected(tmp_path, settings=("rigidity_index=5",))
    assert missed(dataset, lu_2004=0.001) == ["lu_2004: applies to no case"]
    dataset = collected(tmp_path, settings=("adhesion_factor=0", "rigidity_index=[5, 100, 200]"))
    lines = missed(dataset, lu_2004=0.001)
    assert [line.split(":")[1] for line in lines] == [
        " rigidity_index=100.0",
        " rigidity_index=200.0",
    ]


def test_what_failed_is_missed(tmp_path: Path, collected: Callable[..., xr.Dataset]) -> None:
    (line,) = missed(collected(tmp_path, (10.0, np.nan, 12.0)), error=1.0)
    assert line.startswith("error: adhesion_factor=0.5: nan")


def test_what_is_not_there_is_missed(tmp_path: Path, collected: Callable[..., xr.Dataset]) -> None:
    (line,) = missed(collected(tmp_path), eror=1.0)
    assert line == "eror: is neither a reference nor a result here; did you mean 'error'?"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("tolerance = 0.1", "must be a table"),
        ("tolerance = { lu_2004 = 0.1 }", "is not among the references"),
        ("tolerance = { error = 0 }", "must be a number > 0"),
        ('tolerance = { error = "1" }', "must be a number > 0"),
    ],
)
def test_a_malformed_tolerance_is_refused(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "s.toml").write_text(HEAD + "[compare]\n" + text)
    with pytest.raises(StudyError, match=told):
        load_study(str(tmp_path / "s.toml"))


@pytest.mark.parametrize(("limit", "code"), [(0.02, 0), (0.011, 1)])
def test_compare_ends_with_1_where_a_tolerance_is_missed(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    limit: float,
    code: int,
    collected: Callable[..., xr.Dataset],
) -> None:
    dataset = collected(tmp_path).assign_attrs(design="full")
    write_study(tmp_path / "s.nc", with_tolerances(dataset, {"error": limit}))
    assert main(["compare", str(tmp_path / "s.nc")]) == code
    assert ("error: adhesion_factor=1.0" in capsys.readouterr().err) == bool(code)


def test_collecting_keeps_the_tolerances_of_the_study(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], collected: Callable[..., xr.Dataset]
) -> None:
    collected(tmp_path)
    with (tmp_path / "s.toml").open("a") as file:
        file.write("[compare]\ntolerance = { error = 0.011 }\n")
    assert main(["collect", str(tmp_path / "s.toml"), "--out", str(tmp_path)]) == 0
    assert main(["compare", str(tmp_path / "s.nc")]) == 1
    # Nothing is to be run again: run checks what is there.
    assert main(["run", str(tmp_path / "s.toml"), "--out", str(tmp_path)]) == 1
    assert "tolerance missed: error" in capsys.readouterr().err
