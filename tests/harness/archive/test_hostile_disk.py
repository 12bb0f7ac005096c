"""Disks that are full, read-only or damaged, clocks that go back: a clear word, nothing lost."""

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from harness.archive import case_files, study_files
from harness.archive.conventions import COMPLETED
from harness.cli.main import main
from harness.study.cases import Case
from harness.study.study import Study, load_study
from tests.harness.conftest import written

pytestmark = pytest.mark.slow

LIMIT = 120
"""Seconds after which what is waited for does not come."""


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

    result = subprocess.run(
        [*(before or []), sys.executable, "-m", "harness", *arguments],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=bound,
        timeout=LIMIT,
    )
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
    assert "interrupted; 3 cases: 2 missing, 1 completed; " in told[-2]
    assert len(completed(full_disk, small)) == 1
    assert study_files.read_study(full_disk / "small.nc").identical(before)

    with filler.open("ab") as file:
        room = os.statvfs(full_disk)
        file.write(bytes(room.f_bavail * room.f_frsize))
    code, told = harness(arguments(small_file, full_disk))
    assert (code, len(told)) == (2, 1)
    assert told[0].endswith("/small/cases: cannot be written to: No space left on device")

    filler.unlink()
    assert harness(arguments(small_file, full_disk))[0] == 0
    assert first.items() <= written(small, full_disk).items()
    assert len(completed(full_disk, small)) == 3


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


def test_two_runs_in_one_folder_do_not_harm_each_other(small_file: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    setting = ["--set", f"rigidity_index={list(range(50, 110, 10))}"]
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
