"""How the result of a study is laid out: its dims, by design, and what two scenes share."""

from pathlib import Path
from types import SimpleNamespace
from typing import NoReturn

import numpy as np
import pytest
import xarray as xr

from harness.archive.case_files import write_case
from harness.archive.conventions import COMPLETED, HALF_WIDTH, reasons_of, without_incomplete_curves
from harness.archive.study_files import collect, read_study, write_study
from harness.cli.main import main
from harness.compare.result_table import cone_factor_table
from harness.pictures.pictures import draw
from harness.report.report import page
from harness.run.rerun import read_for_rerun, verdict
from harness.run.worker import run_case
from harness.study.study import Study, load_study
from mpm_warp.results import curves, variable
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.uncertainty import further_runs
from tests.harness.conftest import DONE, HEAD, HYPERCUBE, keep, prepared, study_in


def collected(tmp_path: Path, text: str) -> xr.Dataset:
    """The dataset of a study whose cases have invented results."""
    made = study_in(tmp_path, text)
    factors = [
        xr.Dataset({"cone_factor": ((), 10.0 + place, {"role": "headline"}), "run_time": 1.0})
        for place in range(len(made.cases))
    ]
    return collect(made, keep(made, tmp_path, *factors))


def test_what_is_no_grid_has_a_dimension_of_cases(tmp_path: Path) -> None:
    dataset = collected(tmp_path, HEAD + HYPERCUBE)
    assert dataset["cone_factor"].dims == ("case",)
    assert dataset["rigidity_index"].dims == ("case",)
    assert dataset["density"].dims == ()
    assert np.unique(dataset["case_key"]).size == 20
    write_study(tmp_path / "s.nc", dataset)
    read = read_study(tmp_path / "s.nc")
    assert len(cone_factor_table(read).partition("\n\n")[0].splitlines()) == 23
    assert [path.name for path in draw(read, tmp_path)[0]] == ["s_effects.png"]


def test_derived_parameters_stand_over_the_grid(tmp_path: Path) -> None:
    text = HEAD + '[derived]\ndomain_radius = "6 * sqrt(rigidity_index)"\n'
    text += "[vary]\nrigidity_index = [25, 100]\nadhesion_factor = [0, 1]\n"
    dataset = collected(tmp_path, text)
    assert dataset["domain_radius"].dims == ("rigidity_index", "adhesion_factor")
    assert dataset["domain_radius"].sel(rigidity_index=100).values.tolist() == [60, 60]
    assert cone_factor_table(dataset)
    assert draw(dataset, tmp_path)[0]


FACTOR = (), 1.0, {"role": "headline"}
OF_TWO_SCENES = {
    "other dims": [
        xr.Dataset({"stress": ("x", [1.0, 2.0])}, {"x": [0.0, 1.0]}),
        xr.Dataset({"stress": (("x", "y"), [[3.0], [4.0]])}, {"x": [0.0, 1.0], "y": [0.0]}),
    ],
    "a dim of its own": [
        xr.Dataset({"displacement": 0.1}),
        xr.Dataset({"load": ("displacement", [1.0, 2.0])}, {"displacement": [0.0, 1.0]}),
    ],
}


@pytest.mark.parametrize("difference", OF_TWO_SCENES)
def test_results_of_one_name_over_other_dims_are_told_apart(
    tmp_path: Path, difference: str
) -> None:
    results = [it.assign(factor=FACTOR) for it in OF_TWO_SCENES[difference]]
    made = study_in(tmp_path, 'title = "t"\nscene = ["strip_footing", "material_point"]\n')
    write_study(tmp_path / "s.nc", collect(made, keep(made, tmp_path, *results)))
    for case, result in zip(made.cases, results, strict=True):
        found, before = read_for_rerun(tmp_path / "s.nc", case.key)
        assert (found.scene, found.parameters) == (case.scene, case.parameters)
        again = result.assign_attrs(status=COMPLETED)
        assert verdict(before, again) == (True, "bit-identical")


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


@pytest.mark.parametrize("status", ["completed", "diverged", "failed", None])
def test_dims_mean_the_same_whatever_became_of_the_cases(
    status: str | None, one: Study, tmp_path: Path
) -> None:
    folder = prepared(one, tmp_path)
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
    folder = prepared(small, tmp_path)
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
    run_case(small.cases[0], folder := prepared(small, tmp_path))
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


def test_of_a_law_of_ones_own_table_and_report_say_that_nothing_is_known(tmp_path: Path) -> None:
    """In one of two cases; the collected file says what was built, and so does not say Tresca."""
    made = study_in(tmp_path, HEAD + "[vary]\nadhesion_factor = [0, 1]\n")
    laws, results = ("tresca", "their_clay.Hardening"), []
    for law in laws:
        parts = {"mesh": 0.1}
        reasons = [] if law == "tresca" else [f"law: nobody has measured {law}"]
        run = SimpleNamespace(name="cone_factor", factor=10.0, description="Nc")
        known = further_runs.TestRun.stated(run, 0.1, parts, reasons)
        shear = variable(0.0, unit="1", meaning="shear part")
        built = variable(law, unit=None, meaning="law as built", role="built")
        results.append(xr.Dataset(known | {"cone_factor_shear": shear, "built_law": built}))
    write_study(tmp_path / "s.nc", collect(made, keep(made, tmp_path, *results)))
    dataset = read_study(tmp_path / "s.nc")
    assert dataset.cone_factor.values.tolist() == [10.1, 10.0]
    assert np.isnan(dataset.cone_factor_uncertainty.values).tolist() == [False, True]
    assert dataset.material.values.tolist() == list(laws)
    line = f"no uncertainty of adhesion_factor=1.0: law: nobody has measured {laws[1]}"
    assert line in cone_factor_table(dataset).splitlines()
    written = page([dataset])[0]
    assert written.count(f"law: nobody has measured {laws[1]}") == 1
    assert "no U: law" in written
    assert HALF_WIDTH in written


def test_texts_that_only_one_scene_gives_are_empty_for_the_others(tmp_path: Path) -> None:
    made = study_in(tmp_path, 'title = "t"\nscene = ["cone_penetration", "t_bar_penetration"]\n')
    told = DONE.assign(why_no_uncertainty=((), "law: none", {"role": "reason"}))
    write_study(tmp_path / "s.nc", collect(made, keep(made, tmp_path, told, DONE)))
    assert reasons_of(read_study(tmp_path / "s.nc")) == ["law: none", ""]
