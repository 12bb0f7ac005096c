"""The result of a study: its layout by design, what scenes share, failed and damaged cases."""

import json
from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

from harness.archive.case_files import case_file, case_folder, write_case
from harness.archive.collection import collect
from harness.archive.conventions import (
    COMPLETED,
    HALF_WIDTH,
    reasons_of,
    without_incomplete_curves,
)
from harness.archive.provenance import SOURCES
from harness.archive.study_files import read_study, write_study
from harness.compare.result_table import cone_factor_table
from harness.compare.spread import spreads_of
from harness.pictures.pictures import draw
from harness.report.report import page
from harness.report.tables import case_parameters
from harness.run.collect_and_clean import collect_and_write
from harness.run.worker import run_case
from harness.study.cases import Case
from harness.study.study import Study, load_study
from mpm_warp.provenance import sources_digest
from mpm_warp.results import curves, variable
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from tests.harness.conftest import DONE, HEAD, Command, Refusal, damage, keep, prepared, study_in


def test_a_case_counts_as_often_as_the_hypercube_drew_it(tmp_path: Path) -> None:
    """Many samples at the bound of a parameter are one case, and bear on the mean all the same."""
    text = HEAD + 'design = "latin_hypercube"\nsamples = 200\nseed = 3\n[vary]\n'
    made = study_in(tmp_path, text + "adhesion_factor = { mean = 0.9, deviation = 0.3 }\n")
    factors = [
        xr.Dataset({"cone_factor": ((), case.parameters["adhesion_factor"], {"role": "headline"})})
        for case in made.cases
    ]
    write_study(tmp_path / "s.nc", collect(made, keep(made, tmp_path, *factors)))
    read = read_study(tmp_path / "s.nc")
    (spread,) = spreads_of(read)
    # The share above 1 of a normal distribution around 0.9, and what it is less on the mean.
    above = norm.sf(1.0, 0.9, 0.3)
    mean = 0.9 + above * 0.1 - 0.3 * norm.pdf(1.0 / 3.0)
    assert read.draws.values.max() == pytest.approx(200 * above, abs=1)
    assert spread.mean == pytest.approx(mean, abs=2e-3)  # below 0 lie 0.1 %
    assert spread.percentiles[1:].tolist() == [pytest.approx(0.9, abs=5e-3), 1.0]
    assert spread.shares["adhesion_factor"] == pytest.approx(1.0)


def test_what_a_profile_takes_the_place_of_says_nothing(tmp_path: Path) -> None:
    """Such a column, su, stiffness and layers: their defaults do not hold in that ground."""
    header = "depth [m], strength [kPa], adhesion_factor [1]"
    tables = [f"{header}; 0, {strength}, 0.3; 9, 40, 0.3" for strength in (10, 20)]
    ground = f"[vary]\nprofile = {json.dumps(tables)}\n[fixed]\nfrom_depth = 3\n"
    study = study_in(tmp_path, f'title = "s"\nscene = "sounding"\n{ground}')
    dataset = collect(study, keep(study, tmp_path))
    for name in ("undrained_shear_strength", "rigidity_index", "adhesion_factor"):
        assert np.isnan(dataset[name]).all()
    shown = {name for name, *_ in case_parameters(dataset)["fixed"]}
    assert "from_depth" in shown
    assert not shown & {"undrained_shear_strength", "layer_strength_ratio", "adhesion_factor"}


def test_the_file_of_a_study_has_its_coordinates_in_order(tmp_path: Path) -> None:
    """Tables and pictures of the file are those of the run, whose coordinates are not sorted."""
    cases = (
        "[[case]]\nrigidity_index = 50\n[[case]]\napex_angle = 90\n[[case]]\nadhesion_factor = 1\n"
    )
    made = study_in(tmp_path, f'{HEAD}design = "list"\n{cases}')
    dataset = collect(made, keep(made, tmp_path))
    write_study(tmp_path / "s.nc", dataset)
    assert [*read_study(tmp_path / "s.nc").coords] == [*dataset.coords]
    assert [*dataset.coords] != sorted(map(str, dataset.coords))


def test_derived_parameters_stand_over_the_grid(tmp_path: Path) -> None:
    text = HEAD + '[derived]\ndomain_radius = "6 * sqrt(rigidity_index)"\n'
    text += "[vary]\nrigidity_index = [25, 100]\nadhesion_factor = [0, 1]\n"
    study = study_in(tmp_path, text)
    dataset = collect(study, keep(study, tmp_path))
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
def test_results_of_one_name_over_other_dims_are_two(tmp_path: Path, difference: str) -> None:
    results = [it.assign(factor=FACTOR) for it in OF_TWO_SCENES[difference]]
    made = study_in(tmp_path, 'title = "t"\nscene = ["strip_footing", "material_point"]\n')
    write_study(tmp_path / "s.nc", collect(made, keep(made, tmp_path, *results)))
    stored = read_study(tmp_path / "s.nc")
    for place, (case, result) in enumerate(zip(made.cases, results, strict=True)):
        for name, array in result.drop_vars("factor").data_vars.items():
            own = f"{case.scene}_{name}"
            found = stored[own if own in stored else name].isel(case=place)
            assert found.shape == array.shape
            np.testing.assert_array_equal(found.values, array.values)


@pytest.mark.parametrize(
    ("told", "expected"),
    [
        ([("N", "a"), ("N", "a")], ("N", "a")),
        ([("N", "by Shield"), ("N, simple shear", "2 + pi")], ("N", "by Shield / 2 + pi")),
        ([("N", "a"), ("load", "a")], ("cone factor", "a")),
        ([("N", it) for it in "abcd"], ("N", "by the scene or law of the case")),
    ],
)
def test_what_is_said_of_a_result_is_true_of_all_cases(
    told: list[tuple[str, str]], expected: tuple[str, str], tmp_path: Path
) -> None:
    values = [number / 10.0 for number in range(len(told))]
    made = study_in(tmp_path, f"{HEAD}[vary]\nadhesion_factor = {values}\n")
    results = [
        xr.Dataset(
            {"cone_factor": DONE["cone_factor"].assign_attrs(long_name=name, description=it)}
        )
        for name, it in told
    ]
    said = collect(made, keep(made, tmp_path, *results))["cone_factor"].attrs
    assert (said["long_name"], said["description"]) == expected


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
def test_dims_are_the_same_whatever_happened(
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


def test_an_incomplete_case_has_curves_and_no_scalars(small: Study, folder: Path) -> None:
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
    small: Study, folder: Path, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    def fail(*given: object) -> NoReturn:
        raise ZeroDivisionError("of the test")

    monkeypatch.setattr(ConePenetration, "run", fail)
    run_case(small.cases[0], folder)
    status = ["status", small.source, "--out", folder.parents[1]]
    told = command(*status, code=1)
    assert "failed" in told.out
    assert "Traceback" not in told.out + told.err
    shown = command(*status, "--traceback", code=1).out
    assert "Traceback" in shown
    assert 'raise ZeroDivisionError("of the test")' in shown
    collected = collect(small, folder)
    assert "Traceback" not in str(collected.attrs) + str(collected.message.values)


def test_of_a_law_of_ones_own_table_and_report_say_that_nothing_is_known(tmp_path: Path) -> None:
    """In one of two cases; the collected file says what was built, and so does not say Tresca."""
    made = study_in(tmp_path, HEAD + "[vary]\nadhesion_factor = [0, 1]\n")
    laws = ("tresca", "their_clay.Hardening")
    reason = f"law: nobody has measured {laws[1]}: nothing is corrected"
    results = [
        DONE.assign(
            cone_factor_uncertainty=((), half_width, {"role": "uncertainty"}),
            why_no_uncertainty=((), why, {"role": "reason"}),
            cone_factor_shear=0.0,
            built_law=((), law, {"role": "built"}),
        )
        for law, half_width, why in zip(laws, (0.1, np.nan), ("", reason), strict=True)
    ]
    write_study(tmp_path / "s.nc", collect(made, keep(made, tmp_path, *results)))
    dataset = read_study(tmp_path / "s.nc")
    assert np.isnan(dataset.cone_factor_uncertainty.values).tolist() == [False, True]
    assert dataset.material.values.tolist() == list(laws)
    line = f"no uncertainty of adhesion_factor=1.0: {reason}"
    assert line in cone_factor_table(dataset).splitlines()
    written = page([dataset])[0]
    assert written.count(f"law: nobody has measured {laws[1]}") == 1
    assert "no U: law" in written
    factor, why = "pore_pressure_factor_shoulder", "shoulder: the filter is lower than a cell"
    for name, values in {"": [5.0, 4.0], "_uncertainty": [0.2, np.nan]}.items():
        dataset[f"{factor}{name}"] = ("adhesion_factor", values, {"units": "1"})
    dataset[f"{factor}_why_no_uncertainty"] = ("adhesion_factor", ["", why])
    written = page([dataset])[0]
    assert ">5.0 ± 0.2<" in written
    assert ">4.00, no U: shoulder<" in written
    assert why in written
    assert HALF_WIDTH in written


def test_texts_that_only_one_scene_gives_are_empty_for_the_others(tmp_path: Path) -> None:
    made = study_in(tmp_path, 'title = "t"\nscene = ["cone_penetration", "t_bar_penetration"]\n')
    told = DONE.assign(why_no_uncertainty=((), "law: none", {"role": "reason"}))
    write_study(tmp_path / "s.nc", collect(made, keep(made, tmp_path, told, DONE)))
    read = read_study(tmp_path / "s.nc")
    assert reasons_of(read) == ["law: none", ""]
    assert read["why_no_uncertainty"].attrs["scenes"] == "cone_penetration"


@pytest.fixture
def completed(small: Study, tmp_path: Path) -> list[Case]:
    """The cases of a study, all completed by the present code."""
    now = {SOURCES: f"mpm_warp {sources_digest('mpm_warp')}"}
    keep(small, tmp_path, *[DONE.assign_attrs(now)] * 3)
    return list(small.cases)


def test_a_damaged_case_does_not_keep_the_others_from_being_collected(
    small: Study, completed: list[Case], folder: Path, tmp_path: Path, command: Command
) -> None:
    path = case_file(folder, completed[1])
    collect_and_write(small, tmp_path)
    damage(path)
    told = command("collect", small.source, "--out", tmp_path, code=1).err.splitlines()
    assert told[-2].startswith(f"harness: {path}: cannot be read: ")
    assert told[-2].endswith("; `harness run` runs the case again")
    assert told[-1].startswith("harness: 3 cases: 2 completed, 1 damaged; ")
    lost = "had 1 result of cases that are damaged now"
    kept = "kept as it was in small_before.nc; `harness status` says why"
    assert told[:-2] == [f"harness: {tmp_path / 'small.nc'}: {lost}; {kept}"]
    dataset = read_study(tmp_path / "small.nc")
    assert dataset.status.values.tolist() == [COMPLETED, "damaged", COMPLETED]
    assert str(dataset.message.values[1]).startswith(f"{path}: cannot be read: ")
    assert np.isnan(dataset.cone_factor.values).tolist() == [False, True, False]


@pytest.mark.usefixtures("completed")
def test_no_result_is_replaced_by_nothing(small: Study, tmp_path: Path, refusal: Refusal) -> None:
    collect_and_write(small, tmp_path)
    result = tmp_path / "small.nc"
    before = result.read_bytes()
    out = ["--out", str(result.parent)]
    line = refusal(["collect", str(small.source), "--set", "rigidity_index=50", *out])
    assert line == (
        f"harness: {case_folder(result.parent, small)}: has no case of this study; "
        "run it first, or give each --set that it was run with; cases of another version of its "
        "scene do not count"
    )
    assert result.read_bytes() == before
    refusal(["collect", str(small.source), "--out", str(result.parent / "none")])
    assert not (result.parent / "none").exists()


@pytest.mark.parametrize("command", ["compare", "plot", "report"])
def test_a_missing_file_is_one_line(command: str, tmp_path: Path, refusal: Refusal) -> None:
    path = tmp_path / "none.nc"
    assert refusal([command, str(path)]) == f"harness: {path}: no such file"
    for number in range(20):
        (tmp_path / f"{number:016x}.nc").touch()
    assert refusal([command, str(path)]) == f"harness: {path}: no such file"


def test_a_link_that_leads_nowhere_is_told_in_plain_words(tmp_path: Path, command: Command) -> None:
    lost = tmp_path / "lost.nc"
    lost.symlink_to("nowhere")
    first, _ = command("status", "--out", tmp_path, code=2).err.splitlines()
    assert first == f"harness: {lost}: no such file"
