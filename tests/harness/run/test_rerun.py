"""A case again from its file alone."""

import json
import shutil
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest
import xarray as xr

from harness.archive import case_files, netcdf_files, study_files
from harness.archive.atomic_files import ArchiveError
from harness.archive.collection import collect
from harness.archive.conventions import COMPLETED, CRASHED
from harness.cli.main import main
from harness.run.rerun import PROVENANCE, read_for_rerun, verdict
from harness.study.study import Study, load_study
from tests.harness.conftest import SMALL, Command, Refusal, keep, study_in

pytestmark = pytest.mark.slow

SETTINGS = ["material=['von_mises']", "rigidity_index=[50, 100]", "adhesion_factor=0.5"]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which a study has run with parameters of every type, one of them derived."""
    folder = tmp_path_factory.mktemp("ran")
    file = study_in(folder, dedent(SMALL), name="small").source
    settings = [part for setting in SETTINGS for part in ("--set", setting)]
    assert main(["run", str(file), *settings, "--out", str(folder)]) == 0
    return folder


@pytest.fixture
def done(ran: Path, tmp_path: Path) -> Study:
    """That study, its results in `tmp_path`."""
    shutil.copytree(ran, tmp_path, dirs_exist_ok=True)
    return load_study(str(tmp_path / "small.toml"), SETTINGS)


def test_a_case_file_gives_the_same_bits_again(
    done: Study, tmp_path: Path, command: Command
) -> None:
    case = done.cases[1]
    path = case_files.case_file(case_files.case_folder(tmp_path, done), case)
    elsewhere = path.rename(tmp_path / "alone.nc")
    files = set(tmp_path.rglob("*"))
    assert command("rerun", elsewhere).out == f"{case.key}: bit-identical\n"
    assert set(tmp_path.rglob("*")) == files


def test_a_case_of_a_collected_file_gives_the_same_bits_again(
    done: Study, tmp_path: Path, command: Command
) -> None:
    for case in done.cases:
        told = command("rerun", tmp_path / "small.nc", case.key)
        assert told.out == f"{case.key}: bit-identical\n"


@pytest.mark.parametrize("collected", [False, True])
def test_another_bit_is_noticed(
    done: Study, tmp_path: Path, collected: bool, command: Command
) -> None:
    case = done.cases[1]
    folder = case_files.case_folder(tmp_path, done)
    result = case_files.read_case(folder, case)
    result.penetration_resistance.values[-1] *= 1 + 2**-52
    result.attrs["commit"] = "other"
    case_files.write_case(folder, case, result, "completed")
    path = case_files.case_file(folder, case)
    if collected:
        path = tmp_path / "changed.nc"
        study_files.write_study(path, collect(done, folder))
    told = command("rerun", path, case.key, code=1).out
    assert told.startswith(f"{case.key}: differs in penetration_resistance; ")
    assert "; commit other -> " in told
    assert "same machine" not in told


def test_an_integer_that_has_none_in_a_collected_file_differs() -> None:
    """And it is no warning that a number is not one."""
    said = dict.fromkeys(PROVENANCE, "the same")
    said |= {"scene": "cone_penetration", "status": COMPLETED}
    before = xr.Dataset({"status": COMPLETED, "step_count": np.nan}, attrs=said)
    again = xr.Dataset({"step_count": 7}, attrs=said)
    same, words = verdict(before, again)
    assert not same
    assert words.startswith("differs in step_count")


def test_a_case_that_had_crashed_is_run_but_not_compared(
    small: Study, tmp_path: Path, command: Command
) -> None:
    case = small.cases[0]
    case_files.write_case(tmp_path, case, xr.Dataset(), CRASHED, "why")
    told = command("rerun", case_files.case_file(tmp_path, case), code=1).out
    assert "not to be compared: crashed before, completed again" in told


MALFORMED = "a parameter is missing or malformed; it cannot be run again"
CHANGES: list[tuple[dict[str, object], str]] = [
    ({"rigidity_index": 51.0}, "the parameters there are not those of case"),
    ({"parameters": "{"}, MALFORMED),
    ({"parameters": "[1]"}, MALFORMED),
    ({"scene_version": "new"}, "scene, scene_version or status is missing or malformed"),
    ({"scene_version": 0}, "was computed by version 0 of cone_penetration, this simulator has"),
    ({"scene": "spiral"}, "unknown scene 'spiral'"),
]


@pytest.mark.parametrize(("changes", "told"), CHANGES)
def test_a_case_file_that_cannot_be_run_again_is_one_line(
    changes: dict[str, object], told: str, small: Study, tmp_path: Path, refusal: Refusal
) -> None:
    path = case_files.case_file(keep(small, tmp_path), small.cases[0])
    whole = netcdf_files.read_netcdf(path)
    if "rigidity_index" in changes:
        changes = {"parameters": json.dumps({**json.loads(whole.attrs["parameters"]), **changes})}
    netcdf_files.write_netcdf(whole.assign_attrs(changes), path)
    assert told in refusal(["rerun", str(path)])


@pytest.mark.parametrize(
    ("friction", "version", "told"),
    [(None, {}, MALFORMED), ("rough", {}, MALFORMED), (None, {"scene_version": 0}, CHANGES[4][1])],
    ids=["missing", "no number", "of another version, before its parameters are read"],
)
def test_a_result_that_cannot_be_run_again_is_one_line(
    friction: str | None,
    version: dict[str, int],
    told: str,
    small: Study,
    tmp_path: Path,
    refusal: Refusal,
) -> None:
    path, result = tmp_path / "changed.nc", collect(small, tmp_path)
    changed = result.drop_vars("friction_coefficient").assign_attrs(version)
    if friction is not None:
        changed = changed.assign(friction_coefficient=friction)
    study_files.write_study(path, changed)
    assert told in refusal(["rerun", str(path), small.cases[1].key])


def test_a_case_that_is_not_in_the_file_is_one_line(
    small: Study, tmp_path: Path, refusal: Refusal
) -> None:
    one, other, _ = small.cases
    folder = keep(small, tmp_path)
    path, result = case_files.case_file(folder, one), tmp_path / "small.nc"
    study_files.write_study(result, collect(small, folder))
    stranger = tmp_path / "stranger.nc"
    netcdf_files.write_netcdf(xr.Dataset(attrs={"format_version": 1}), stranger)
    for arguments, told in (
        ((path, other.key), f"is the file of case {one.key} alone"),
        ((result,), f"no case is named; there are 3, `harness status {result}` lists them"),
        ((result, one.key[:-1]), f"did you mean '{one.key}'?"),
        ((stranger,), "is neither the file of a case nor the result of a study"),
        ((tmp_path / "none.nc",), "none.nc: no such file"),
    ):
        assert told in refusal(["rerun", *map(str, arguments)])


def test_the_only_case_of_a_result_need_not_be_named(small_file: Path, tmp_path: Path) -> None:
    study = load_study(str(small_file), ["adhesion_factor=0.5"])
    result = tmp_path / "small.nc"
    study_files.write_study(result, collect(study, keep(study, tmp_path)))
    case, _ = read_for_rerun(result, None)
    assert case.key == study.cases[0].key


def test_snapshots_are_no_result(tmp_path: Path) -> None:
    with pytest.raises(ArchiveError, match=r"holds the snapshots of a case; .* in 0123\.nc"):
        read_for_rerun(tmp_path / "0123.fields.nc", None)
