"""Snapshots of a case in a file beside its own: written, read, missing, damaged, removed."""

from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

from harness.archive.atomic_files import ArchiveError
from harness.archive.case_files import (
    case_file,
    case_folder,
    discard,
    fields_file,
    find_fields,
    has_fields,
    is_complete,
    read_fields,
)
from harness.archive.netcdf_files import write_netcdf
from harness.run.collect_and_clean import collect_and_write, outcomes, stray_files
from harness.run.worker import run_case
from harness.study.study import Study, load_study, with_snapshots

DEFINITION = """
title = "One cone of next to no cost"
scene = "cone_penetration"
snapshots = [0.5, 3]

[fixed]
penetration = 1
steady_tolerance = 0
cells_per_radius = 1
"""


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[Study, Path]:
    """A study of one case with snapshots that was run, and the folder of its results."""
    out = tmp_path_factory.mktemp("results")
    file = out / "one.toml"
    file.write_text(DEFINITION)
    study = load_study(str(file))
    folder = case_folder(out, study)
    folder.mkdir(parents=True)
    assert run_case(study.cases[0], folder).status == "completed"
    collect_and_write(study, out)
    return study, out


@pytest.fixture
def own(ran: tuple[Study, Path], tmp_path: Path) -> tuple[Study, Path]:
    """The same in a folder that a test may change."""
    study, out = ran
    for file in case_folder(out, study).iterdir():
        copy = case_folder(tmp_path, study) / file.name
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(file.read_bytes())
    return study, tmp_path


def test_a_case_has_its_snapshots_beside_it_and_nothing_of_them_in_it(
    ran: tuple[Study, Path],
) -> None:
    study, out = ran
    folder, (case,) = case_folder(out, study), study.cases
    fields = read_fields(fields_file(folder, case))
    assert fields.penetration.values.tolist() == [0.5, 1.0]
    assert fields.attrs["case_key"] == case.key
    with (
        xr.open_dataset(case_file(folder, case)) as result,
        xr.open_dataset(out / "one.nc") as collected,
    ):
        assert "point" not in {*result.dims, *collected.dims}
    assert is_complete(folder, case)
    assert stray_files(study, out) == []


def test_snapshots_are_no_part_of_a_case(ran: tuple[Study, Path]) -> None:
    study, out = ran
    (case,) = study.cases
    other = with_snapshots(study, "0.7").cases[0]
    assert other.key == case.key
    assert not has_fields(case_folder(out, study), other)
    assert [it.status for it in outcomes(with_snapshots(study, "0.7"), out)] == ["no_fields"]
    assert [it.status for it in outcomes(with_snapshots(study, "3"), out)] == ["completed"]


def test_damage_shows(own: tuple[Study, Path]) -> None:
    study, out = own
    path = fields_file(case_folder(out, study), study.cases[0])
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    with pytest.raises(ArchiveError, match="was damaged or changed"):
        read_fields(path)
    (found,) = stray_files(study, out)
    assert found.path == path
    assert "was damaged" in found.what
    assert [it.status for it in outcomes(study, out)] == ["no_fields"]


@pytest.mark.parametrize("taken", ["[[0.5], [3.0]]", "3", "{", '{"0.5": 1}', "[0.5]"])
def test_moments_that_another_program_wrote_are_no_error(
    own: tuple[Study, Path], taken: str
) -> None:
    study, out = own
    folder, (case,) = case_folder(out, study), study.cases
    path = fields_file(folder, case)
    write_netcdf(read_fields(path).assign_attrs(snapshots=taken), path)
    assert not has_fields(folder, case)


def test_a_case_without_its_snapshots_is_not_done(own: tuple[Study, Path]) -> None:
    study, out = own
    folder, (case,) = case_folder(out, study), study.cases
    fields_file(folder, case).unlink()
    assert not is_complete(folder, case)
    assert is_complete(folder, replace(case, snapshots=()))


def test_they_go_with_their_case(own: tuple[Study, Path]) -> None:
    study, out = own
    folder, (case,) = case_folder(out, study), study.cases
    discard(folder, [case])
    assert list(folder.iterdir()) == []


def test_a_run_without_snapshots_leaves_none_of_an_earlier_one(own: tuple[Study, Path]) -> None:
    study, out = own
    folder, (case,) = case_folder(out, study), study.cases
    run_case(replace(case, snapshots=()), folder)
    assert not fields_file(folder, case).exists()


def test_they_are_found_from_any_file_of_the_study(ran: tuple[Study, Path]) -> None:
    study, out = ran
    folder, (case,) = case_folder(out, study), study.cases
    path = fields_file(folder, case)
    for file, key in (
        (out / "one.nc", None),
        (out / "one.nc", case.key),
        (case_file(folder, case), None),
        (path, None),
    ):
        assert find_fields(file, key) == path
    with pytest.raises(ArchiveError, match=f"did you mean '{case.key}'"):
        find_fields(out / "one.nc", f"{case.key}0")
    with pytest.raises(ArchiveError, match="there are those of"):
        find_fields(out / "one.nc", "x")
