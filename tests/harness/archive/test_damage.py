"""Files that are damaged, and files that cannot be read for another reason.

Only a file with the mark of the harness and a wrong digest is damaged: it is replaced. Whatever
else cannot be read is told in one line and kept.
"""

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray as xr

from harness.archive import case_files, netcdf_files
from harness.archive.atomic_files import ArchiveError, DamagedError
from harness.archive.case_files import case_file, case_folder
from harness.archive.conventions import DAMAGED, UNREADABLE
from harness.archive.netcdf_files import read_netcdf, write_netcdf
from harness.cli.main import main
from harness.run.collect_and_clean import collect_and_write, outcomes
from harness.study.study import Study, with_snapshots
from tests.harness.conftest import DONE, Command, Depth, Refusal, damage, keep

Harm = Callable[[Path], object]
"""Makes a file unusable."""
READERS = ("compare", "plot", "report")
DIGEST = 72
"""Bytes of mark and digest at the end of a file."""


@pytest.fixture
def result(small: Study, tmp_path: Path) -> Path:
    """The collected file of a study of which all cases are complete."""
    keep(small, tmp_path)
    collect_and_write(small, tmp_path)
    return tmp_path / "small.nc"


def identity(path: Path) -> tuple[int, int, int]:
    """What tells a file from one written later."""
    stat = path.lstat()
    return stat.st_ino, stat.st_mtime_ns, stat.st_size


def flipped(content: bytes, bit: int) -> bytes:
    changed = bytearray(content)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


def test_no_flipped_bit_and_no_cut_reaches_the_netcdf_library(
    result: Path, monkeypatch: pytest.MonkeyPatch, depth: Depth
) -> None:
    monkeypatch.setattr(netCDF4, "Dataset", lambda *_, **__: pytest.fail("it saw the file"))
    content = result.read_bytes()
    body = 8 * (len(content) - DIGEST)
    for bit in np.random.default_rng(23).integers(body, size=depth(64, 5000)).tolist():
        result.write_bytes(flipped(content, bit))
        with pytest.raises(DamagedError, match="its digest does not match"):
            read_netcdf(result)
    for bit in range(body, 8 * len(content), 7):
        result.write_bytes(flipped(content, bit))
        with pytest.raises(ArchiveError, match="cannot be read: "):
            read_netcdf(result)
    for left in (0, 1, 71, DIGEST, 100, len(content) // 2, body // 8, len(content) - 1):
        result.write_bytes(content[:left])
        with pytest.raises(ArchiveError, match="the mark of this program is missing"):
            read_netcdf(result)


def rewritten(path: Path) -> None:
    """As a user does who corrects a number by xarray."""
    with xr.open_dataset(path) as dataset:
        other = dataset.load()
    other["cone_factor"] = other["cone_factor"] + 1
    other.to_netcdf(path)


def newer(path: Path) -> None:
    result = read_netcdf(path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(netcdf_files, "FORMAT_VERSION", 99)
        write_netcdf(result, path)


def in_its_place(make: Harm) -> Harm:
    return lambda path: (path.unlink(), make(path))


FAILING: dict[Path, BaseException] = {}
"""Files whose reading fails."""


@pytest.fixture(autouse=True)
def failing_files(monkeypatch: pytest.MonkeyPatch) -> None:
    FAILING.clear()
    opened = Path.open

    def or_fail(self: Path, *given: Any, **named: Any) -> object:
        if self in FAILING:
            raise FAILING[self]
        return opened(self, *given, **named)

    monkeypatch.setattr(Path, "open", or_fail)


def failing(error: BaseException) -> Harm:
    """A file whose reading fails, as of another user's, on a bad disk, or without memory."""
    return lambda path: FAILING.update({path: error})


DENIED = PermissionError(errno.EACCES, "Permission denied")
NO_FILE = "it is no file"
UNUSABLE: dict[str, tuple[Harm, str]] = {
    "cut": (
        lambda path: path.write_bytes(path.read_bytes()[:-100]),
        "the mark of this program is missing at its end",
    ),
    "rewritten": (rewritten, "as by xarray (`xarray.open_dataset` reads it then)"),
    "newer": (newer, "it has format 99, this program reads 1; use the program that wrote it"),
    "a fifo": (in_its_place(os.mkfifo), NO_FILE),
    "a folder": (in_its_place(Path.mkdir), NO_FILE),
    "a device": (in_its_place(lambda path: path.symlink_to("/dev/zero")), NO_FILE),
    "not allowed": (failing(DENIED), "Permission denied"),
    "larger than the memory": (failing(MemoryError()), "not enough memory"),
}
"""What is no damage, and the reason that is told."""


of_each = pytest.mark.parametrize(("harm", "reason"), UNUSABLE.values(), ids=UNUSABLE)


@of_each
def test_a_result_that_cannot_be_read_is_one_line_and_stays(
    harm: Harm, reason: str, result: Path, small: Study, refusal: Refusal
) -> None:
    harm(result)
    before = identity(result)
    for command in READERS:
        more = ["-o", str(result.with_suffix(".html"))] if command == "report" else []
        line = refusal([command, str(result), *more])
        assert line.startswith(f"harness: {result}: cannot be read: ")
        assert reason in line
    for command in ("collect", "run"):
        line = refusal([command, str(small.source), "--out", str(result.parent)])
        assert line.endswith("; not overwritten: move it away, or give another --out")
    assert identity(result) == before


@of_each
def test_a_case_that_cannot_be_read_is_told_and_kept_by_every_command(
    harm: Harm, reason: str, result: Path, small: Study, command: Command
) -> None:
    path = case_file(case_folder(result.parent, small), small.cases[1])
    harm(path)
    before, of_study = identity(path), (small.source, "--out", result.parent)
    said = command("status", *of_study, code=1).out.splitlines()
    assert said[2].split()[1] == UNREADABLE
    assert reason in said[2]
    assert "3 cases: 2 completed, 1 unreadable" in said[-1]
    assert f"{path}: cannot be read: " in command("collect", *of_study, code=1).err
    assert "kept: move it away, or `harness run --fresh`" in command("run", *of_study, code=1).err
    said = command("clean", *of_study, "--yes").err
    assert "; kept\n" in said
    assert "nothing to remove" in said
    assert identity(path) == before


@pytest.mark.usefixtures("in_this_process")
def test_damage_is_told_and_replaced(stub: Study, tmp_path: Path, command: Command) -> None:
    place, case, result = keep(stub, tmp_path), stub.cases[1], tmp_path / "stub.nc"
    collect_and_write(stub, tmp_path)
    damage(case_file(place, case))
    damage(result)
    (outcome,) = {it for it in outcomes(stub, tmp_path) if it.status == DAMAGED}
    assert "was damaged or changed after it was written" in outcome.message
    told = command("run", stub.source, "--out", tmp_path).err
    assert "the case is run again" in told
    assert "3 cases, 2 done already" in told
    assert case_files.is_complete(place, case)
    assert read_netcdf(result).attrs["study"] == "stub"


def test_snapshots_that_cannot_be_read_are_kept(result: Path, small: Study) -> None:
    place, study = case_folder(result.parent, small), with_snapshots(small, "0.5")
    fields = case_files.fields_file(place, study.cases[0])
    case_files.write_case(place, study.cases[0], DONE, "completed", fields=DONE)
    newer(fields)
    statuses = [it.status for it in outcomes(study, result.parent)]
    assert statuses == [UNREADABLE, "no_fields", "no_fields"]


@pytest.mark.parametrize("place", [".", "small", "small/cases"])
def test_a_folder_that_cannot_be_read_is_one_line(
    place: str, result: Path, small: Study, refusal: Refusal, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, scan = result.parent / place, os.scandir

    def fail(path: str) -> object:
        if Path(path) == folder:
            raise PermissionError(errno.EACCES, "Permission denied")
        return scan(path)

    monkeypatch.setattr(os, "scandir", fail)
    for command in ("status", "collect", "clean"):
        line = refusal([command, str(small.source), "--out", str(result.parent)])
        assert line == f"harness: {folder}: cannot be read: Permission denied"


@pytest.mark.parametrize("command", ["status", "collect", "clean", "run"])
def test_results_that_are_no_folder_are_told(command: str, small: Study, refusal: Refusal) -> None:
    line = refusal([command, str(small.source), "--out", str(small.source)])
    assert line == f"harness: {small.source}: is not a folder"


@pytest.mark.parametrize("command", ["report", "plot"])
def test_a_study_given_as_result_is_told(command: str, small: Study, refusal: Refusal) -> None:
    line = refusal([command, str(small.source)])
    assert line.endswith("it is no result; give the .nc file that `harness run` wrote")


def test_results_that_cannot_be_read_are_told_beside_others(result: Path, command: Command) -> None:
    damage(other := result.parent / "other.nc")
    told = command("status", "--out", result.parent)
    assert f"{other}: cannot be read: it was damaged" in told.err
    assert f"{result}  cone_penetration: 3 cases: 3 completed" in told.out
    words = ["recommend", "cone_penetration", "--error", "1%", "--results", result.parent]
    assert f"{other}: cannot be read: it was damaged" in command(*words, code=2).err
    assert main(["status", str(result)]) == 0
