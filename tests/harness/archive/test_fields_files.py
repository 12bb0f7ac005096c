"""Snapshots of a case in a file beside its own: written, read, missing, damaged, removed."""

import shutil
from dataclasses import replace
from pathlib import Path
from textwrap import dedent
from typing import NamedTuple

import pytest
import xarray as xr

from harness.archive import case_files
from harness.archive.atomic_files import ArchiveError
from harness.run.collect_and_clean import collect_and_write, outcomes, stray_files
from harness.run.worker import run_case
from harness.study.cases import Case
from harness.study.study import Study, with_snapshots
from tests.harness.conftest import SMALL, damage, prepared, study_in


class Ran(NamedTuple):
    """A study of one case with snapshots that was run, and its files."""

    study: Study
    case: Case
    out: Path
    folder: Path
    fields: Path

    @classmethod
    def in_(cls, out: Path, study: Study) -> "Ran":
        folder, (case,) = case_files.case_folder(out, study), study.cases
        return cls(study, case, out, folder, case_files.fields_file(folder, case))

    def statuses(self, study: Study) -> list[str]:
        return [it.status for it in outcomes(study, self.out)]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    out = tmp_path_factory.mktemp("results")
    study = study_in(out, "snapshots = [0.5, 3]" + dedent(SMALL), "adhesion_factor=0", name="one")
    assert run_case(study.cases[0], prepared(study, out)).status == "completed"
    collect_and_write(study, out)
    return Ran.in_(out, study)


@pytest.fixture
def own(ran: Ran, tmp_path: Path) -> Ran:
    """The same in a folder that a test may change."""
    shutil.copytree(ran.out, tmp_path, dirs_exist_ok=True)
    return Ran.in_(tmp_path, ran.study)


def test_a_case_has_its_snapshots_beside_it_and_nothing_of_them_in_it(ran: Ran) -> None:
    fields = case_files.read_fields(ran.fields)
    assert fields.penetration.values.tolist() == [0.5, 1.0]
    assert fields.attrs["case_key"] == ran.case.key
    for file in (case_files.case_file(ran.folder, ran.case), ran.out / "one.nc"):
        with xr.open_dataset(file) as result:
            assert "point" not in result.dims
    assert case_files.is_complete(ran.folder, ran.case)
    assert stray_files(ran.study, ran.out) == []


def test_snapshots_are_no_part_of_a_case(ran: Ran) -> None:
    other = with_snapshots(ran.study, "0.7")
    assert other.cases[0].key == ran.case.key
    assert not case_files.has_fields(ran.folder, other.cases[0])
    assert ran.statuses(other) == ["no_fields"]
    assert ran.statuses(with_snapshots(ran.study, "3")) == ["completed"]


def test_damage_shows(own: Ran) -> None:
    damage(own.fields)
    with pytest.raises(ArchiveError, match="was damaged or changed"):
        case_files.read_fields(own.fields)
    (found,) = stray_files(own.study, own.out)
    assert found.path == own.fields
    assert "was damaged" in found.what
    assert own.statuses(own.study) == ["no_fields"]


def test_snapshots_go_with_their_case_which_is_not_done_without_them(own: Ran) -> None:
    fields = own.fields.read_bytes()
    own.fields.unlink()
    assert not case_files.is_complete(own.folder, own.case)
    assert case_files.is_complete(own.folder, replace(own.case, snapshots=()))
    own.fields.write_bytes(fields)
    case_files.discard(own.folder, [own.case])
    assert list(own.folder.iterdir()) == []


def test_a_run_without_snapshots_leaves_those_of_another_run(
    own: Ran,
) -> None:
    without = replace(own.case, snapshots=())
    run_case(without, own.folder)  # another run has completed it meanwhile, with snapshots
    assert case_files.is_complete(own.folder, own.case)
    case_files.case_file(own.folder, own.case).unlink()
    run_case(without, own.folder)
    assert not own.fields.exists()


def test_they_are_found_from_any_file_of_the_study(ran: Ran) -> None:
    collected, key = ran.out / "one.nc", ran.case.key
    for file, of in ((collected, None), (collected, key), (ran.fields, None)):
        assert case_files.find_fields(file, of) == ran.fields
    assert case_files.find_fields(case_files.case_file(ran.folder, ran.case), None) == ran.fields
    with pytest.raises(ArchiveError, match=f"did you mean '{key}'"):
        case_files.find_fields(collected, f"{key}0")
    with pytest.raises(ArchiveError, match="cases with snapshots: "):
        case_files.find_fields(collected, "x")
