"""Tolerances that are kept and missed, and two results side by side."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.atomic_files import prepare
from harness.archive.case_files import case_folder, write_case
from harness.archive.collection import collect, write_study
from harness.cli.main import main
from harness.compare.cone_factors import with_references
from harness.compare.tolerances import (
    NotComparableError,
    differences,
    misses,
    unshared,
    with_tolerances,
)
from harness.study.cases import COMPLETED, cases_of
from harness.study.definition import StudyError
from harness.study.study import load_study

HEAD = 'title = "t"\nscene = "cone_penetration"\n'
FACTORS = (10.0, 11.0, 12.0)


def collected(
    folder: Path, factors: tuple[float, ...] = FACTORS, settings: tuple[str, ...] = ()
) -> xr.Dataset:
    """A study of three cases whose cone factors are given; not a number is a case that failed."""
    path = folder / "s.toml"
    path.write_text(HEAD + "[vary]\nadhesion_factor = [0, 0.5, 1]\n")
    study = load_study(str(path), settings)
    cases = cases_of(study)
    out = case_folder(folder, study)
    prepare(out)
    for case, factor in zip(cases, factors, strict=True):
        result = xr.Dataset({"cone_factor": factor, "error": factor / 1000, "run_time": 1.0})
        if np.isnan(factor):
            write_case(out, case, xr.Dataset(), "diverged", "too fast")
        else:
            write_case(out, case, result, COMPLETED)
    return with_references(collect(study, cases, out), ["lu_2004"])


def missed(dataset: xr.Dataset, **tolerances: float) -> list[str]:
    return misses(with_tolerances(dataset, tolerances))


def test_no_tolerance_misses_nothing(tmp_path: Path) -> None:
    assert missed(collected(tmp_path)) == []


def test_the_bound_of_a_result(tmp_path: Path) -> None:
    dataset = collected(tmp_path)
    assert missed(dataset, error=0.012) == []
    assert missed(dataset, error=0.0115) == [
        "error: adhesion_factor=1.0: 0.012 is beyond the tolerance 0.0115"
    ]


def test_the_bound_of_a_deviation(tmp_path: Path) -> None:
    dataset = collected(tmp_path)
    # 10 / 10.77 - 1, 11 / 11.42 - 1, 12 / 12.07 - 1
    assert missed(dataset, lu_2004=0.08) == []
    (line,) = missed(dataset, lu_2004=0.05)
    assert line.startswith("lu_2004: adhesion_factor=0.0: 0.071")


def test_a_reference_is_not_asked_outside_its_validity(tmp_path: Path) -> None:
    dataset = collected(tmp_path, settings=("rigidity_index=5",))
    assert missed(dataset, lu_2004=0.001) == ["lu_2004: applies to no case"]
    dataset = collected(tmp_path, settings=("adhesion_factor=0", "rigidity_index=[5, 100, 200]"))
    lines = missed(dataset, lu_2004=0.001)
    assert [line.split(":")[1] for line in lines] == [
        " rigidity_index=100.0",
        " rigidity_index=200.0",
    ]


def test_what_failed_is_missed(tmp_path: Path) -> None:
    (line,) = missed(collected(tmp_path, (10.0, np.nan, 12.0)), error=1.0)
    assert line.startswith("error: adhesion_factor=0.5: nan")


def test_what_is_not_there_is_missed(tmp_path: Path) -> None:
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
    tmp_path: Path, capsys: pytest.CaptureFixture[str], limit: float, code: int
) -> None:
    dataset = collected(tmp_path).assign_attrs(design="full")
    write_study(tmp_path / "s.nc", with_tolerances(dataset, {"error": limit}))
    assert main(["compare", str(tmp_path / "s.nc")]) == code
    assert ("error: adhesion_factor=1.0" in capsys.readouterr().err) == bool(code)


def test_collecting_keeps_the_tolerances_of_the_study(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    collected(tmp_path)
    with (tmp_path / "s.toml").open("a") as file:
        file.write("[compare]\ntolerance = { error = 0.011 }\n")
    assert main(["collect", str(tmp_path / "s.toml"), "--out", str(tmp_path)]) == 0
    assert main(["compare", str(tmp_path / "s.nc")]) == 1
    # Nothing is to be run again: run checks what is there.
    assert main(["run", str(tmp_path / "s.toml"), "--out", str(tmp_path)]) == 1
    assert "tolerance missed: error" in capsys.readouterr().err


def two(tmp_path: Path, *changed: float, settings: tuple[str, ...] = ()) -> list[xr.Dataset]:
    folders = [tmp_path / "one", tmp_path / "other"]
    for folder in folders:
        folder.mkdir()
    return [collected(folders[0]), collected(folders[1], changed, settings)]


def test_equal_results_do_not_differ(tmp_path: Path) -> None:
    one, other = two(tmp_path, *FACTORS)
    found, lonely = differences(one, other.assign(run_time=2 * other["run_time"]))
    assert [(it.name, it.size) for it in found] == [("cone_factor", 0), ("error", 0)]
    assert lonely == []


def test_the_largest_difference_is_named_with_its_case(tmp_path: Path) -> None:
    one, other = two(tmp_path, 10.0, 11.11, 12.0)
    found, _ = differences(one, other.isel(adhesion_factor=slice(None, None, -1)))
    assert [it.name for it in found] == ["cone_factor", "error"]
    assert [it.size for it in found] == pytest.approx([0.01, 0.01])
    assert {it.label for it in found} == {"adhesion_factor=0.5"}


def test_a_case_that_failed_in_one_differs_without_bound(tmp_path: Path) -> None:
    found, lonely = differences(*two(tmp_path, 10.0, np.nan, 12.0))
    assert {it.size for it in found} == {np.inf}
    assert lonely == ["completed in the first, diverged in the second: adhesion_factor=0.5"]


def test_a_status_that_differs_counts_where_no_number_does(tmp_path: Path) -> None:
    one, other = (it[["status", "adhesion_factor"]] for it in two(tmp_path, 10.0, np.nan, 12.0))
    found, lonely = differences(one, other)
    assert found == []
    assert lonely == ["completed in the first, diverged in the second: adhesion_factor=0.5"]


def test_what_was_not_compared_is_not_passed(
    tmp_path: Path, refusal: Callable[[list[str]], str]
) -> None:
    path = tmp_path / "s.nc"
    write_study(path, collected(tmp_path).drop_vars(["cone_factor", "error"]))
    told = "harness: nothing to compare: no case has a scalar result in either"
    assert refusal(["compare", str(path), str(path)]) == told
    one, other = two(tmp_path, *FACTORS)
    nothing = {"cone_factor": np.nan * one["cone_factor"], "error": np.nan * one["error"]}
    with pytest.raises(NotComparableError):
        differences(one.assign(nothing), other.assign(nothing))


def test_cases_of_one_result_alone_are_told(tmp_path: Path) -> None:
    one, other = two(tmp_path, *FACTORS)
    _, lonely = differences(one.isel(adhesion_factor=[0, 1]), other)
    assert lonely == ["only in the second: adhesion_factor=1.0"]


def test_results_of_other_parameters_are_not_compared(tmp_path: Path) -> None:
    with pytest.raises(NotComparableError):
        differences(*two(tmp_path, *FACTORS, settings=("density=1800",)))


def without(dataset: xr.Dataset, name: str) -> xr.Dataset:
    """A result of the scene before it had a parameter."""
    return dataset.drop_vars(name)


def test_a_result_from_before_a_parameter_is_compared_at_its_default(tmp_path: Path) -> None:
    one, other = two(tmp_path, *FACTORS)
    older = without(one, "friction_coefficient")
    assert differences(older, other) == differences(one, other)
    assert differences(other, older) == differences(other, one)
    assert unshared(one, other) == []
    told = "has friction_coefficient: compared where at the default"
    assert unshared(older, other) == [f"only the second {told}"]
    assert unshared(other, older) == [f"only the first {told}"]


def test_a_result_from_before_a_parameter_is_not_compared_elsewhere(tmp_path: Path) -> None:
    one, other = two(tmp_path, *FACTORS, settings=("friction_coefficient=0.1",))
    with pytest.raises(NotComparableError):
        differences(without(one, "friction_coefficient"), other)


def test_a_parameter_that_only_one_varies_leaves_its_default_to_compare(tmp_path: Path) -> None:
    varied = ("adhesion_factor=0.5", "friction_coefficient=[0.2, 0.1, 0]")
    one, other = two(tmp_path, 10.0, 11.0, 11.11, settings=varied)
    found, lonely = differences(without(one, "friction_coefficient"), other)
    assert [it.size for it in found] == pytest.approx([0.01, 0.01])
    assert sum(line.startswith("only in the second: ") for line in lonely) == 2


def test_a_parameter_that_is_no_more_is_named(tmp_path: Path) -> None:
    one, other = two(tmp_path, *FACTORS)
    older = one.assign(viscosity=((), 1.0, {"description": "as it was"}))
    assert differences(older, other) == differences(one, other)
    assert unshared(older, other) == ["only the first has viscosity: compared where at the default"]
    with pytest.raises(NotComparableError):
        differences(older, other.assign(viscosity=older["viscosity"] + 1.0))


@pytest.mark.parametrize(("tolerance", "code"), [("0", 1), ("0.005", 1), ("0.02", 0)])
def test_two_files_beside_each_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], tolerance: str, code: int
) -> None:
    paths = [str(tmp_path / "one.nc"), str(tmp_path / "other.nc")]
    for path, dataset in zip(paths, two(tmp_path, 10.0, 11.11, 12.0), strict=True):
        write_study(Path(path), dataset)
    assert main(["compare", *paths, "--tolerance", tolerance]) == code
    assert capsys.readouterr().out.splitlines()[0].split()[:3] == [
        "cone_factor",
        "0.01",
        "MISSED" if code else "ok",
    ]
