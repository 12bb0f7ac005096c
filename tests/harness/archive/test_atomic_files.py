"""Files that are whole or not there, whoever writes them, on disks that are full or read-only."""

import csv
import os
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from harness.archive import atomic_files, case_files, study_files
from harness.archive.atomic_files import ArchiveError, abandoned, prepare, write_csv, write_whole
from harness.archive.conventions import COMPLETED
from harness.cli.main import main
from harness.study.cases import Case
from harness.study.study import Study, load_study
from tests.conftest import LIMIT, finished
from tests.harness.conftest import written

KILLED_AS_IT_WRITES = """
import os, sys
from pathlib import Path
from harness.archive.atomic_files import write_whole
os.fsync = lambda descriptor: os.kill(os.getpid(), 9)
write_whole(b"later", Path(sys.argv[1]))
"""


def test_a_process_killed_as_it_writes_leaves_the_earlier_file_and_one_that_the_next_removes(
    tmp_path: Path,
) -> None:
    path = tmp_path / "picture.png"
    path.write_bytes(b"earlier")
    command = [sys.executable, "-c", KILLED_AS_IT_WRITES, str(path)]
    assert subprocess.run(command, check=False).returncode == -signal.SIGKILL
    assert path.read_bytes() == b"earlier"
    (half_written,) = abandoned(tmp_path)
    assert set(tmp_path.iterdir()) == {path, half_written}
    prepare(tmp_path)
    assert set(tmp_path.iterdir()) == {path}


def test_no_name_that_is_guessed_leads_a_file_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "results"
    folder.mkdir()
    outside.write_bytes(b"another's")
    names = iter(["first", "second", "first", "second"])
    monkeypatch.setattr("secrets.token_hex", lambda _: next(names))
    for name in ("first", "second"):
        (folder / f".{name}{atomic_files.partial_ending(os.getpid())}").symlink_to(outside)
    with pytest.raises(ArchiveError, match="cannot be written: File exists"):
        write_whole(b"result", folder / "result.nc")
    with pytest.raises(ArchiveError, match="cannot be written to: File exists"):
        prepare(folder)
    assert outside.read_bytes() == b"another's"
    assert len(list(folder.iterdir())) == 2  # nor is it removed


def test_names_of_half_written_files_are_not_to_be_guessed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = list[str]()
    monkeypatch.setattr(os, "fsync", lambda _: seen.extend(it.name for it in tmp_path.iterdir()))
    write_whole(b"1", tmp_path / "1.nc")
    (tmp_path / "1.nc").unlink()
    write_whole(b"1", tmp_path / "1.nc")
    assert len(set(seen)) == 2
    umask = os.umask(0)
    os.umask(umask)
    assert (tmp_path / "1.nc").stat().st_mode & 0o777 == 0o666 & ~umask


def test_no_cell_of_a_table_is_a_formula_of_a_spreadsheet(tmp_path: Path) -> None:
    numbers = ["-0.5", "+1.2%", "-1e-05", "-3", "1", ""]
    formulas = ["=1+1", "=cmd|'/c calc'!A0", "@SUM(A1)", "+1+1", "-2+3"]
    lines = ["a\n=1", "\r=1", "\t=1"]
    write_csv([numbers, formulas, lines], tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    escaped = ["a\\n=1", "\\r=1", "\\t=1"]
    assert rows == [numbers, [f"'{it}" for it in formulas], escaped]


def arguments(small_file: Path, out: Path) -> list[str]:
    return ["run", str(small_file), "--out", str(out), "--workers", "1"]


def harness(
    arguments: list[str], before: list[str] | None = None, file_size: int = 0
) -> tuple[int, list[str]]:
    """Run the command in a process of its own; its exit code and what it said.

    `before` is a command that runs it, `file_size` bounds every file that it writes [byte].
    """

    def bound() -> None:
        if file_size:
            resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))

    command = [*(before or []), sys.executable, "-m", "harness", *arguments]
    result = finished(command, preexec_fn=bound)
    assert "Traceback" not in result.stderr
    return result.returncode, result.stderr.splitlines()


def completed(out: Path, study: Study) -> list[Case]:
    """Cases whose files are whole; there are no other files."""
    folder = case_files.case_folder(out, study)
    done = [case for case in study.cases if case_files.read_case(folder, case) is not None]
    assert {path.name for path in folder.iterdir()} == {f"{case.key}.nc" for case in done}
    return done


@pytest.fixture
def full_disk(tmp_path: Path) -> Iterator[Path]:
    """A file system of its own that can be filled."""
    mount, place = shutil.which("mount"), tmp_path / "disk"
    place.mkdir()
    command = [str(mount), "-t", "tmpfs", "-o", "size=4m", "tmpfs", str(place)]
    if mount is None or subprocess.run(command, capture_output=True, check=False).returncode:
        pytest.skip("a file system cannot be mounted here")
    yield place
    subprocess.run(["umount", str(place)], check=True)


@pytest.mark.slow
def test_a_full_disk_ends_the_run_and_loses_nothing(
    full_disk: Path, small_file: Path, small: Study
) -> None:
    filler = full_disk / "filler"
    assert main([*arguments(small_file, full_disk), "--set", "adhesion_factor=[0]"]) == 0
    before = study_files.read_study(full_disk / "small.nc")
    first = written(small, full_disk)
    room = os.statvfs(full_disk)
    filler.write_bytes(bytes(room.f_bavail * room.f_frsize - 8192))

    code, told = harness(arguments(small_file, full_disk))
    assert code == 2
    assert told[-1].endswith(".nc: cannot be written: No space left on device")
    assert "3 cases: 2 missing, 1 completed; " in told[-2]
    assert len(completed(full_disk, small)) == 1
    assert study_files.read_study(full_disk / "small.nc").identical(before)

    with filler.open("ab") as file:
        room = os.statvfs(full_disk)
        file.write(bytes(room.f_bavail * room.f_frsize))
    code, told = harness(arguments(small_file, full_disk))
    assert (code, len(told)) == (2, 1)
    assert told[0] == f"harness: {full_disk}: cannot be written to: No space left on device"

    filler.unlink()
    assert harness(arguments(small_file, full_disk))[0] == 0
    assert first.items() <= written(small, full_disk).items()
    assert len(completed(full_disk, small)) == 3


@pytest.mark.slow
def test_files_that_may_not_grow_end_the_run_and_lose_nothing(
    small_file: Path, tmp_path: Path, small: Study
) -> None:
    out = tmp_path / "out"
    arguments_ = arguments(small_file, out)
    assert main([*arguments_, "--set", "adhesion_factor=[0]"]) == 0
    (case, *_) = completed(out, small)
    size = case_files.case_file(case_files.case_folder(out, small), case).stat().st_size
    code, told = harness(arguments_, file_size=size // 2)
    assert code == 2
    assert told[-1].endswith(".nc: cannot be written: File too large")
    assert completed(out, small) == [case]
    assert harness(arguments_)[0] == 0
    assert len(completed(out, small)) == 3


@pytest.mark.slow
def test_a_folder_that_is_read_only_is_one_line(
    small_file: Path, tmp_path: Path, small: Study
) -> None:
    before: list[str] = []
    if os.geteuid() == 0:  # root may write everywhere, unless it gives that up
        setpriv = shutil.which("setpriv")
        if setpriv is None:
            pytest.skip("root cannot give up its rights here")
        before = [setpriv, "--bounding-set=-dac_override", "--inh-caps=-dac_override"]
    out = tmp_path / "out"
    assert main([*arguments(small_file, out), "--set", "adhesion_factor=[0]"]) == 0
    folder = case_files.case_folder(out, small)
    folder.chmod(0o555)
    code, told = harness(arguments(small_file, out), before)
    folder.chmod(0o755)
    assert (code, told) == (2, [f"harness: {folder}: cannot be written to: Permission denied"])
    assert len(completed(out, small)) == 1


@pytest.mark.slow
def test_two_runs_in_one_folder_do_not_harm_each_other(small_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    setting = ["--set", f"rigidity_index={list(range(100, 160, 10))}"]
    runs = [
        subprocess.Popen(
            [sys.executable, "-m", "harness", *arguments(small_file, out), *setting],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    try:
        told = [run.communicate(timeout=LIMIT)[1] for run in runs]
    finally:
        for run in runs:
            run.kill()
    assert [run.returncode for run in runs] == [0, 0], told
    study = load_study(str(small_file), setting[1:])
    assert len(completed(out, study)) == 18
    assert set(study_files.read_study(out / "small.nc").status.values.flat) == {COMPLETED}
    assert not list(out.rglob(".*"))
